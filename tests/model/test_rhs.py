"""The right-hand side against the independent twin; its Jacobian against finite differences."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from support import reference
from support.parameters import random_parameters

from stickslip.model import drive, noise
from stickslip.model.models import model_of
from stickslip.model.rhs import Equations, relative_state, starting_state
from stickslip.options import FRICTION_LAWS, HARMONICS, Physics
from stickslip.parameters import Parameters

INDICES = [-2 / 3, -0.5, 0.0, 1 / 3, 2 / 3]
FIVE_POINTS = (-2, -1, 1, 2)
WEIGHTS = (1 / 12, -8 / 12, 8 / 12, -1 / 12)


@pytest.fixture(scope="module", params=FRICTION_LAWS)
def model(request: pytest.FixtureRequest) -> Equations:
    return model_of(Physics(request.param, drive=HARMONICS)).equations


class Case(NamedTuple):
    """A state y = (x, u, psi) at the phase time t, and its u."""

    p: Parameters
    t: float
    y: tuple[float, float, float]
    u: float


def random_case(rng: np.random.Generator, gamma: float) -> Case:
    """Parameters near those of the paper, and a state within reach but not on the cusp."""
    p = random_parameters(rng, gamma)
    t = rng.uniform(0.0, 2 * math.pi / p.angular_frequency)
    speed = abs(p.drive_amplitude) * p.angular_frequency
    u = float(speed * 10.0 ** rng.uniform(-3, 1) * rng.choice([-1.0, 1.0]))
    x = p.drive_amplitude * rng.uniform(-1.5, 1.5)
    # A stuck, a melting or a fully melted film.
    psi = rng.choice([rng.uniform(-1.5, 0.3), rng.uniform(-8.0, -1.0), rng.uniform(-35.0, -8.0)])
    return Case(p, t, (x, u, float(psi)), u)


def cases(gamma: float, number: int = 200) -> list[Case]:
    rng = np.random.default_rng(20130720)
    return [random_case(rng, gamma) for _ in range(number)]


def derivative(
    model: Equations, case: Case, direction: int, u_s: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Five-point difference of the right-hand side along x, u, psi or t, and its rounding error."""
    p, t, y, u = case
    speed = abs(p.drive_amplitude) * p.angular_frequency
    steps = (
        abs(p.drive_amplitude),
        1e-3 * abs(u),
        1e-3,
        1e-3 * min(abs(u) / speed, 1.0) / p.angular_frequency,
    )
    step = steps[direction]
    values = []
    for times in FIVE_POINTS:
        at = [*y, t]
        at[direction] += times * step
        values.append(model.rhs(p, at[3], tuple(at[:3]), u_s))
    # The rounding errors of the largest terms.
    psi = y[2]
    _, F = model.exact(p, u, math.exp(psi))
    heating = 2 * p.thermal_coefficient * (p.temperature + p.critical_temperature)
    strain = u * p.strain_relaxation_time / p.film_thickness
    sizes = np.array(
        [
            speed + abs(u) + steps[1],
            speed * p.angular_frequency
            + (abs(F) + 4 * p.spring_stiffness * abs(p.drive_amplitude)) / p.block_mass,
            p.kinetic_coefficient
            * (heating + p.elastic_coefficient * strain**2 + 4 * p.quartic_coefficient)
            + noise.typical_path(p, math.exp(0.01 - psi)),
        ]
    )
    return np.dot(WEIGHTS, values) / step, 4e-16 * sizes / step


@pytest.mark.parametrize("gamma", INDICES)
def test_the_right_hand_side_agrees_with_the_independent_twin(gamma: float) -> None:
    model = model_of(Physics("power-law", drive=HARMONICS)).equations  # the law of the twin
    for p, t, y, u in cases(gamma):
        x, _, psi = y
        speed, omega = abs(p.drive_amplitude) * p.angular_frequency, p.angular_frequency
        v, v_dot = reference.upper_velocity(t, p) - u, drive.upper_acceleration(p, t)
        rates = model.rhs(p, t, y, 0.0)
        ours = np.array([rates[0], v_dot - rates[1], rates[2]])
        twin = np.array(reference.right_hand_side(t, np.array([x, v, psi]), p))
        # Each term to 1e-12; the sums may cancel.
        F = reference.friction_force(u, math.exp(y[2]), p)
        strain = u * p.strain_relaxation_time / p.film_thickness
        terms = np.array(
            [
                abs(v),
                speed * omega + (abs(F) + 2 * p.spring_stiffness * abs(y[0])) / p.block_mass,
                p.kinetic_coefficient
                * (
                    2 * p.thermal_coefficient * abs(p.temperature - p.critical_temperature)
                    + p.elastic_coefficient * strain**2
                    + p.cubic_coefficient * math.exp(y[2])
                    + p.quartic_coefficient * math.exp(2 * y[2])
                ),
            ]
        )
        closure = 0.2807297 * p.noise_intensity * math.exp(-2 * y[2])
        amplified = 1 + (abs(v) + speed) * 1e-3 / abs(u)  # the twin subtracts two speeds
        assert np.all(abs(ours - twin) <= 1e-12 * amplified * terms + [0, 0, 1e-7 * closure])


@pytest.mark.parametrize(
    ("gamma", "rounded"), [*((gamma, 0.0) for gamma in INDICES), (-2 / 3, 0.7), (-0.5, 0.7)]
)
@pytest.mark.parametrize("direction", range(4), ids=["x", "u", "psi", "t"])
def test_the_jacobian_agrees_with_finite_differences(
    model: Equations, gamma: float, rounded: float, direction: int
) -> None:
    for case in cases(gamma):
        u_s = rounded * abs(case.u)  # below this speed the cusp is rounded
        rows = model.jacobian(case.p, case.t, case.y, u_s)
        column = np.array(
            rows[3] if direction == 3 else [row[direction] for row in rows[:3]], dtype=float
        )
        differences, rounding = derivative(model, case, direction, u_s)
        assert np.all(abs(column - differences) <= 1e-8 * abs(differences) + 30 * rounding)


@pytest.mark.parametrize("gamma", INDICES)
def test_the_rates_of_stress_and_force_are_their_derivatives_along_the_motion(
    model: Equations,
    gamma: float,
) -> None:
    for p, t, y, u in cases(gamma, 100):
        rates = np.array(model.rhs(p, t, y, 0.0))
        u_dot, psi_dot = rates[1:]
        sigma, F, sigma_rate, F_rate = model.observables_and_rates(p, t, y, 0.0)
        assert (sigma, F) == pytest.approx(model.exact(p, u, math.exp(y[2])), rel=1e-9, abs=0)
        # A time in which neither the slip nor ln(phi) nor the drive changes by more than 1e-3.
        step = 1e-3 / max(abs(u_dot / u), abs(psi_dot), p.angular_frequency)
        values = [
            model.exact(p, u + times * step * u_dot, math.exp(y[2] + times * step * psi_dot))
            for times in FIVE_POINTS
        ]
        differences = np.dot(WEIGHTS, values) / step
        noise = 1e-8 * np.array([abs(sigma), abs(F)]) / step * 1e-3
        assert abs(sigma_rate - differences[0]) <= 1e-7 * abs(differences[0]) + noise[0]
        assert abs(F_rate - differences[1]) <= 1e-7 * abs(differences[1]) + noise[1]


@pytest.mark.parametrize("gamma", [-0.999, *INDICES, 5.0])
def test_right_hand_side_and_jacobian_are_finite_where_the_blocks_move_together(
    model: Equations,
    gamma: float,
) -> None:
    p = Parameters(rheological_index=gamma)
    assert np.all(np.isfinite(model.rhs(p, 0.0, (0.0, 0.0, -1.0), 0.0)))
    assert np.all(np.isfinite(model.jacobian(p, 0.0, (0.0, 0.0, -1.0), 0.0)))


def test_the_relative_state_is_its_own_inverse() -> None:
    for p, t, y, u in cases(-2 / 3, 50):
        x, v, psi = relative_state(p, t, y)
        V = reference.upper_velocity(t, p)
        assert (x, psi) == (y[0], y[2])
        assert v == pytest.approx(V - u, rel=1e-12, abs=1e-14 * abs(V))
        assert relative_state(p, t, (x, v, psi))[1] == pytest.approx(u, rel=1e-9)
        assert relative_state(p, 0.0, y)[1] == -u  # at phase 0 the drive stands still


def test_without_noise_the_right_hand_side_has_no_closure(model: Equations) -> None:
    p = Parameters(noise_intensity=0.0, initial_order_parameter=0.1)
    rate = model.rhs(p, 0.0, (0.0, 0.0, -600.0), 0.0)[2]
    assert rate == pytest.approx(100.0 * 2 * 0.95 * 90.0, rel=1e-14, abs=0)


def test_the_start_equals_that_of_the_twin() -> None:
    for gamma in (0.0, 2 / 3):
        for p, *_ in cases(gamma, 50):
            q = p._replace(initial_displacement=1e-7, initial_velocity=-2e-6)
            assert starting_state(q) == pytest.approx(reference.starting_state(q), rel=1e-8, abs=0)


def test_compiled_and_plain_python_agree(model: Equations) -> None:
    for p, t, y, _ in cases(-2 / 3, 50) + cases(1 / 3, 50):
        for function in (model.rhs, model.jacobian):
            compiled, plain = function(p, t, y, 0.0), function.py_func(p, t, y, 0.0)
            for ours, theirs in zip(np.ravel(compiled), np.ravel(plain), strict=True):
                assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-20)
