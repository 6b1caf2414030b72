"""Friction: Eqs. 4-11 consistent with each other, odd, dissipative, finite where V = v."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.model import friction

H, K_VISCOUS, TAU, AREA = 1e-9, 5e4, 1e-8, 0.6e-9
INDICES = [-0.999, -0.9, -2 / 3, -0.5, 0.0, 1 / 3, 2 / 3, 2.0, 5.0]
SPECIAL = [-2 / 3, 0.0, 2 / 3]

speeds = st.floats(1e-20, 1.0)
signed_speeds = speeds | speeds.map(lambda u: -u)
indices = st.floats(-0.999, 2.0) | st.sampled_from(INDICES)


def test_the_elastic_strain_is_the_slip_in_a_relaxation_time_over_the_thickness() -> None:
    assert friction.elastic_strain(-6.8e-7, TAU, H) == pytest.approx(-6.8e-6, rel=1e-15)


def test_the_strain_rate_is_absolute() -> None:
    assert friction.strain_rate(-3e-6, H) == friction.strain_rate(3e-6, H)
    assert friction.strain_rate(3e-6, H) == pytest.approx(3000.0, rel=1e-15)


@pytest.mark.parametrize("gamma", INDICES)
def test_the_viscosity_coefficient_is_the_effective_viscosity_at_unit_rate(gamma: float) -> None:
    assert friction.effective_viscosity(1.0, K_VISCOUS, gamma) == K_VISCOUS


@given(u=signed_speeds, gamma=indices)
def test_the_viscous_stress_is_the_effective_viscosity_times_the_strain_rate(
    u: float, gamma: float
) -> None:
    rate = friction.strain_rate(u, H)
    eta = friction.effective_viscosity(rate, K_VISCOUS, gamma)
    stress = friction.viscous_stress(u, H, K_VISCOUS, gamma)
    assert abs(stress) == pytest.approx(eta * rate, rel=1e-12)


def test_the_pseudoplastic_stress_at_the_speed_of_the_drive_is_a_megapascal() -> None:
    # k (8e-6/1e-9)^(1/3) = 20 k
    stress = friction.viscous_stress(8e-6, H, K_VISCOUS, -2 / 3)
    assert stress == pytest.approx(1e6, rel=1e-14)


@given(u=signed_speeds, gamma=indices)
def test_the_viscous_stress_has_the_sign_of_the_relative_velocity(u: float, gamma: float) -> None:
    assert friction.viscous_stress(u, H, K_VISCOUS, gamma) * u > 0


@given(u=speeds, gamma=indices)
def test_the_viscous_stress_is_odd_bit_for_bit(u: float, gamma: float) -> None:
    forward = friction.viscous_stress(u, H, K_VISCOUS, gamma)
    assert friction.viscous_stress(-u, H, K_VISCOUS, gamma) == -forward


@given(u=speeds, gamma=indices)
def test_the_viscous_slope_is_even_bit_for_bit(u: float, gamma: float) -> None:
    forward = friction.viscous_stress_slope(u, H, K_VISCOUS, gamma)
    assert friction.viscous_stress_slope(-u, H, K_VISCOUS, gamma) == forward


@given(u=signed_speeds, gamma=indices)
def test_the_viscous_slope_is_the_derivative_of_the_viscous_stress(u: float, gamma: float) -> None:
    step = 1e-3 * u

    def stress(times: int) -> float:
        return friction.viscous_stress(u + times * step, H, K_VISCOUS, gamma)

    difference = (stress(-2) - 8 * stress(-1) + 8 * stress(1) - stress(2)) / (12 * step)
    slope = friction.viscous_stress_slope(u, H, K_VISCOUS, gamma)
    # Where the stress is nearly constant (gamma near -1) the differences lose digits.
    noise = 1e-11 * abs(stress(0) / u)
    assert slope == pytest.approx(difference, rel=1e-9, abs=noise)


@pytest.mark.parametrize("gamma", SPECIAL)
@given(u=signed_speeds)
def test_the_special_indices_agree_with_the_general_power(gamma: float, u: float) -> None:
    rate = abs(u) / H
    stress = friction.viscous_stress(u, H, K_VISCOUS, gamma)
    # (gamma + 1) is rounded, which the power amplifies by ln(rate): count that out.
    power = math.copysign(K_VISCOUS * rate ** (gamma + 1.0), u)
    rounding = 2.3e-16 * abs(math.log(rate)) if rate > 0 else 0.0
    assert stress == pytest.approx(power, rel=1e-14 + rounding)


@pytest.mark.parametrize("gamma", SPECIAL)
def test_the_stress_is_continuous_in_the_index_at_the_special_ones(gamma: float) -> None:
    special = friction.viscous_stress(3e-6, H, K_VISCOUS, gamma)
    for neighbour in (math.nextafter(gamma, -1.0), math.nextafter(gamma, 1.0)):
        stress = friction.viscous_stress(3e-6, H, K_VISCOUS, neighbour)
        assert stress == pytest.approx(special, rel=1e-14)


@pytest.mark.parametrize("gamma", INDICES)
@pytest.mark.parametrize("u", [0.0, -0.0, 5e-324, -5e-324, 1e-300])
def test_stress_and_slope_are_finite_where_the_blocks_move_together(gamma: float, u: float) -> None:
    assert math.isfinite(friction.viscous_stress(u, H, K_VISCOUS, gamma))
    slope = friction.viscous_stress_slope(u, H, K_VISCOUS, gamma)
    assert math.isfinite(slope)
    assert slope >= 0


@pytest.mark.parametrize("gamma", INDICES)
def test_the_stress_vanishes_where_the_blocks_move_together(gamma: float) -> None:
    assert friction.viscous_stress(0.0, H, K_VISCOUS, gamma) == 0.0


def test_the_slope_at_rest_is_infinite_for_a_pseudoplastic_fluid_as_far_as_floats_go() -> None:
    assert friction.viscous_stress_slope(0.0, H, K_VISCOUS, -2 / 3) > 1e60
    newtonian = friction.viscous_stress_slope(0.0, H, K_VISCOUS, 0.0)
    assert newtonian == pytest.approx(K_VISCOUS / H, rel=1e-15)


# --- the rounded cusp ----------------------------------------------------------------------------

THINNING = [-0.999, -0.9, -2 / 3, -0.5, -0.1]
U_S = 8e-12
"""A tolerance of 1e-6 of the drive's largest speed."""


def rounded(u: float, gamma: float, u_s: float = U_S) -> tuple[float, float]:
    return friction.rounded_viscous_stress(u, u_s, H, K_VISCOUS, gamma)


@given(u=signed_speeds, gamma=indices, u_s=st.sampled_from([0.0, 8e-15, U_S, 8e-9]))
def test_rounding_changes_the_stress_by_no_more_than_stated(
    u: float, gamma: float, u_s: float
) -> None:
    exact = friction.viscous_stress(u, H, K_VISCOUS, gamma)
    stress, _ = rounded(u, gamma, u_s)
    bound = 0.5 * abs(gamma) * (u_s / u) ** 2 if gamma < 0 else 0.0
    # The general power has an error in proportion to its logarithm.
    power = 1e-15 * (5 + (1 + abs(gamma)) * abs(math.log(abs(u) / H)))
    assert abs(stress - exact) <= (bound + power) * abs(exact)


@pytest.mark.parametrize("gamma", THINNING)
def test_the_stated_change_is_no_exaggeration(gamma: float) -> None:
    u = 30 * U_S
    exact = friction.viscous_stress(u, H, K_VISCOUS, gamma)
    bound = 0.5 * abs(gamma) * (U_S / u) ** 2
    assert 1 - rounded(u, gamma)[0] / exact == pytest.approx(bound, rel=2e-3)


@given(u=speeds, gamma=indices)
def test_the_rounded_stress_is_odd_and_its_slope_even_bit_for_bit(u: float, gamma: float) -> None:
    stress, slope = rounded(u, gamma)
    assert rounded(-u, gamma) == (-stress, slope)


@given(u=st.floats(-100.0, 100.0), gamma=st.floats(-0.999, 0.0) | st.sampled_from(THINNING))
def test_the_rounded_slope_is_the_derivative_of_the_rounded_stress(u: float, gamma: float) -> None:
    u *= U_S
    step = 1e-3 * math.hypot(u, U_S)

    def stress(times: int) -> float:
        return rounded(u + times * step, gamma)[0]

    difference = (stress(-2) - 8 * stress(-1) + 8 * stress(1) - stress(2)) / (12 * step)
    noise = 1e-14 * 40 * max(abs(stress(-2)), abs(stress(2))) / step
    assert rounded(u, gamma)[1] == pytest.approx(difference, rel=1e-9, abs=noise)


@pytest.mark.parametrize("gamma", THINNING)
def test_the_rounded_slope_at_rest_is_finite_and_the_largest(gamma: float) -> None:
    stress, slope = rounded(0.0, gamma)
    assert stress == 0.0
    assert slope == pytest.approx(K_VISCOUS / H * (U_S / H) ** gamma, rel=1e-13)
    assert all(0 < rounded(u, gamma)[1] < slope for u in (0.1 * U_S, U_S, 10 * U_S))


@pytest.mark.parametrize("gamma", INDICES)
@pytest.mark.parametrize("u", [0.0, -0.0, 5e-324, -5e-324, 1e-300])
def test_without_a_rounding_stress_and_slope_are_finite_all_the_same(
    gamma: float, u: float
) -> None:
    stress, slope = rounded(u, gamma, 0.0)
    assert math.isfinite(stress)
    assert math.isfinite(slope)
    assert slope >= 0


@pytest.mark.parametrize("gamma", INDICES)
def test_a_rounded_stress_lets_nan_through(gamma: float) -> None:
    assert math.isnan(rounded(math.nan, gamma)[0])


@pytest.mark.parametrize("gamma", SPECIAL)
@pytest.mark.parametrize("u", [1e-18, -U_S, 3e-9, 8e-6])
def test_the_rounded_stress_is_continuous_in_the_index(gamma: float, u: float) -> None:
    neighbour = math.nextafter(gamma, 1.0)
    if gamma == 0.0 and u == 1e-18:
        return  # just below 0 the rounding sets in
    assert rounded(u, neighbour) == pytest.approx(rounded(u, gamma), rel=3e-14)


# --- the force -----------------------------------------------------------------------------------


def test_the_friction_force_is_the_sum_of_the_stresses_times_the_area() -> None:
    assert friction.friction_force(4e6, 1e6, AREA) == pytest.approx(3e-3, rel=1e-15)


@given(u=st.floats(-1.0, 1.0), gamma=indices, stiffness=st.floats(0.0, 1e13))
def test_friction_never_gives_power(u: float, gamma: float, stiffness: float) -> None:
    sigma_el = stiffness * friction.elastic_strain(u, TAU, H)
    sigma_v = friction.viscous_stress(u, H, K_VISCOUS, gamma)
    assert friction.friction_force(sigma_el, sigma_v, AREA) * u >= 0


def test_nan_goes_through() -> None:
    for gamma in INDICES:
        assert math.isnan(friction.viscous_stress(math.nan, H, K_VISCOUS, gamma))


@pytest.mark.parametrize("gamma", INDICES)
@pytest.mark.parametrize("u", [-1e-5, -1e-18, 0.0, 3e-9, 8e-6])
def test_compiled_and_plain_python_agree(gamma: float, u: float) -> None:
    args = (u, H, K_VISCOUS, gamma)
    for function in (friction.viscous_stress, friction.viscous_stress_slope):
        assert function(*args) == pytest.approx(function.py_func(*args), rel=1e-14)
    rate = friction.strain_rate(u, H)
    assert rate == friction.strain_rate.py_func(u, H)
    assert friction.elastic_strain(u, TAU, H) == friction.elastic_strain.py_func(u, TAU, H)
    if rate > 0.0:
        eta = friction.effective_viscosity
        assert eta(rate, K_VISCOUS, gamma) == pytest.approx(
            eta.py_func(rate, K_VISCOUS, gamma), rel=1e-14
        )
