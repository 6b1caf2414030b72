"""The typical path of the noise: its constant, its start, and its exactness for linear motion."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from stickslip.model import noise
from stickslip.parameters import Parameters

PAPER = Parameters()
D = PAPER.noise_intensity
ALPHA, T_C = PAPER.thermal_coefficient, PAPER.critical_temperature
B_CUBIC, C_QUARTIC = PAPER.cubic_coefficient, PAPER.quartic_coefficient
DELTA = PAPER.kinetic_coefficient
D_EFF = noise.TYPICAL_FRACTION * D


def with_noise(D: float) -> Parameters:
    return PAPER._replace(noise_intensity=D)


def start(phi_0: float = 0.0, D: float = D, T: float = 200.0, b: float = B_CUBIC) -> float:
    p = PAPER._replace(
        initial_order_parameter=phi_0, noise_intensity=D, temperature=T, cubic_coefficient=b
    )
    return noise.starting_order_parameter(p)


# --- the constant --------------------------------------------------------------------------------


def test_the_typical_fraction_is_the_geometric_mean_of_chi_squared() -> None:
    def integrand(z: float) -> float:
        return math.log(z * z) * math.exp(-0.5 * z * z) * math.sqrt(2 / math.pi)

    mean_log = quad(integrand, 0, 1)[0] + quad(integrand, 1, 40)[0]
    assert math.exp(mean_log) == pytest.approx(noise.TYPICAL_FRACTION, rel=1e-9, abs=0)


# --- the closure is exact while the dynamics are linear ------------------------------------------


@pytest.mark.parametrize("rate", [-3e4, -40.0, 0.0, 40.0, 1.7e4])
def test_the_closure_follows_the_geometric_mean_of_the_linear_process(rate: float) -> None:
    # dphi = rate phi dt + sqrt(2 D) dW from N(0, s_0): the variance obeys s' = 2 rate s + 2 D,
    # and exp(E ln|phi|) = sqrt(s exp(E ln chi^2_1)).
    s_0 = 1e-22
    times = np.linspace(0.0, 6.0 / (abs(rate) or 40.0), 25)
    if rate == 0.0:
        variance = s_0 + 2 * D * times
    else:
        variance = (s_0 + D / rate) * np.exp(2 * rate * times) - D / rate
    closure = solve_ivp(
        lambda _, psi: [rate + noise.typical_path(PAPER, math.exp(-psi[0]))],
        (0.0, times[-1]),
        [0.5 * math.log(noise.TYPICAL_FRACTION * s_0)],
        method="LSODA",
        t_eval=times,
        rtol=1e-10,
        atol=1e-12,
    )
    exact = 0.5 * np.log(noise.TYPICAL_FRACTION * variance)
    assert closure.y[0] == pytest.approx(exact, abs=1e-7)


def test_the_closure_is_still_at_phi_zero_without_noise() -> None:
    assert noise.typical_path(with_noise(0.0), 1e150) == 0.0
    assert noise.typical_kick(with_noise(0.0), 0.0, 1e-9) == 0.0


def test_the_closure_vanishes_in_the_solid() -> None:
    assert noise.typical_path(PAPER, 1 / 0.6) < 1e-18


# --- the kick of a fixed step --------------------------------------------------------------------


def test_the_kick_of_a_fixed_step_is_the_closure_times_phi_and_the_step() -> None:
    phi, dt = 1e-9, 1e-10
    expected = noise.typical_path(PAPER, 1 / phi) * phi * dt
    assert noise.typical_kick(PAPER, phi, dt) == pytest.approx(expected, rel=1e-13, abs=0)


@given(phi=st.floats(0.0, 1.0), dt=st.floats(1e-13, 1e-5), exponent=st.floats(-30.0, -6.0))
def test_the_kick_of_a_fixed_step_never_exceeds_the_noise_of_that_step(
    phi: float, dt: float, exponent: float
) -> None:
    p = with_noise(10.0**exponent)
    kick = noise.typical_kick(p, phi, dt)
    assert 0.0 < kick <= math.sqrt(noise.effective_intensity(p) * dt) * (1 + 1e-15)


def test_the_kick_at_phi_zero_is_the_noise_of_the_step() -> None:
    dt = 1e-10
    assert noise.typical_kick(PAPER, 0.0, dt) == pytest.approx(
        math.sqrt(D_EFF * dt), rel=1e-14, abs=0
    )


# --- the start -----------------------------------------------------------------------------------


def level(term: float, power: int, D: float = D) -> float:
    """phi at which the noise balances a term of the force, delta `term` phi^`power`."""
    return (noise.TYPICAL_FRACTION * D / (term * DELTA)) ** (1 / (power + 1))


@pytest.mark.parametrize(
    ("scene", "limited"),
    [
        ({}, level(2 * ALPHA * 90.0, 1)),
        ({"T": 380.0}, level(2 * ALPHA * 90.0, 1)),
        ({"T": T_C}, level(B_CUBIC, 2)),
        ({"T": math.nextafter(T_C, 300.0)}, level(B_CUBIC, 2)),
        ({"T": T_C, "b": 0.0}, level(C_QUARTIC, 3)),
        ({"D": 1e9}, level(C_QUARTIC, 3, 1e9)),  # the steepest term limits a strong noise
    ],
    ids=str,
)
def test_the_term_that_limits_the_noise_sets_the_start(
    scene: dict[str, float], limited: float
) -> None:
    assert start(**scene) == pytest.approx(limited, rel=1e-14, abs=0)


@given(T=st.floats(0.0, 1e4), b=st.floats(0.0, 1e3), exponent=st.floats(-40.0, 0.0))
def test_at_the_start_the_noise_balances_its_limiting_term(
    T: float, b: float, exponent: float
) -> None:
    phi = start(D=10.0**exponent, T=T, b=b)
    terms = DELTA * np.array([2 * ALPHA * abs(T - T_C) * phi, b * phi**2, C_QUARTIC * phi**3])
    kick = noise.TYPICAL_FRACTION * 10.0**exponent / phi
    assert terms.max() == pytest.approx(kick, rel=1e-9, abs=0)


def test_a_start_above_the_noise_is_kept() -> None:
    assert start(phi_0=0.01) == 0.01
    assert start(phi_0=1e-14) == start()


@pytest.mark.parametrize("T", [200.0, T_C])
@pytest.mark.parametrize("b", [0.0, B_CUBIC])
def test_without_noise_the_start_is_not_lifted(T: float, b: float) -> None:
    assert start(D=0.0, T=T, b=b) == 0.0
    assert start(phi_0=0.3, D=0.0, T=T, b=b) == 0.3
