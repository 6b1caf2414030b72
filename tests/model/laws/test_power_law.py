"""The paper's power law: Eqs. 6-11, its special indices, and how far its rounding reaches."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.model.laws.power_law import (
    LAW,
    rounded_viscous_stress,
    viscous_stress,
)
from stickslip.parameters import Parameters

PAPER = Parameters()
PHI = 0.5  # of no effect
H, K_VISCOUS = PAPER.film_thickness, PAPER.viscosity_coefficient
INDICES = [-0.999, -0.9, -2 / 3, -0.5, -1 / 3, 0.0, 1 / 3, 2 / 3, 2.0, 5.0]
SPECIAL = [-2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3]

speeds = st.floats(1e-20, 1.0)
signed_speeds = speeds | speeds.map(lambda u: -u)
indices = st.floats(-0.999, 2.0) | st.sampled_from(INDICES)


def fluid(gamma: float) -> Parameters:
    return PAPER._replace(rheological_index=gamma)


def slope(p: Parameters, u: float) -> float:
    """Derivative of the viscous stress with respect to `u`."""
    return rounded_viscous_stress(p, u, PHI, 0.0)[1]


def test_the_law_declares_the_indices_with_specialised_kernels() -> None:
    assert LAW.special_indices == tuple(SPECIAL)
    assert set(LAW.parameters) == {"viscosity_coefficient", "rheological_index"}


@given(u=signed_speeds, gamma=indices)
def test_the_viscous_stress_is_the_effective_viscosity_times_the_strain_rate(
    u: float, gamma: float
) -> None:
    rate = abs(u) / H
    effective_viscosity = K_VISCOUS * rate**gamma
    stress = viscous_stress(fluid(gamma), u, PHI)
    assert abs(stress) == pytest.approx(effective_viscosity * rate, rel=1e-12, abs=0)


def test_the_pseudoplastic_stress_at_the_speed_of_the_drive_is_a_megapascal() -> None:
    # k (8e-6/1e-9)^(1/3) = 20 k
    assert viscous_stress(fluid(-2 / 3), 8e-6, PHI) == pytest.approx(1e6, rel=1e-14, abs=0)


@pytest.mark.parametrize("gamma", SPECIAL)
@given(u=signed_speeds)
def test_the_special_indices_agree_with_the_general_power(gamma: float, u: float) -> None:
    rate = abs(u) / H
    # (gamma + 1) is rounded, and the power amplifies the error by ln(rate).
    power = math.copysign(K_VISCOUS * rate ** (gamma + 1.0), u)
    rounding = 2.3e-16 * abs(math.log(rate)) if rate > 0 else 0.0
    assert viscous_stress(fluid(gamma), u, PHI) == pytest.approx(power, rel=1e-14 + rounding, abs=0)


@pytest.mark.parametrize("gamma", INDICES)
def test_only_a_pseudoplastic_fluid_has_a_cusp(gamma: float) -> None:
    assert bool(LAW.has_cusp(fluid(gamma))) == (gamma < 0)


@pytest.mark.parametrize("gamma", INDICES)
def test_the_stable_slope_is_that_at_the_fastest_slip_without_the_cusp(
    gamma: float,
) -> None:
    p = fluid(gamma)
    expected = 0.0 if gamma < 0 else slope(p, 3e-6)
    assert LAW.stable_slope(p, 3e-6, PHI) == expected


# --- the rounded cusp ----------------------------------------------------------------------------

THINNING = [-0.999, -0.9, -2 / 3, -0.5, -0.1]
U_S = 8e-12
"""1e-6 of the largest speed of the drive."""


def rounded(u: float, gamma: float, u_s: float = U_S) -> tuple[float, float]:
    return rounded_viscous_stress(fluid(gamma), u, PHI, u_s)[:2]


@given(u=signed_speeds, gamma=indices, u_s=st.sampled_from([0.0, 8e-15, U_S, 8e-9]))
def test_rounding_changes_the_stress_by_no_more_than_stated(
    u: float, gamma: float, u_s: float
) -> None:
    exact = viscous_stress(fluid(gamma), u, PHI)
    stress, _ = rounded(u, gamma, u_s)
    bound = 0.5 * abs(gamma) * (u_s / u) ** 2 if gamma < 0 else 0.0
    # The general power has an error in proportion to its logarithm.
    power = 1e-15 * (5 + (1 + abs(gamma)) * abs(math.log(abs(u) / H)))
    assert abs(stress - exact) <= (bound + power) * abs(exact)


@pytest.mark.parametrize("gamma", THINNING)
def test_the_stated_change_is_reached(gamma: float) -> None:
    u = 30 * U_S
    bound = 0.5 * abs(gamma) * (U_S / u) ** 2
    change = 1 - rounded(u, gamma)[0] / viscous_stress(fluid(gamma), u, PHI)
    assert change == pytest.approx(bound, rel=2e-3, abs=0)


@pytest.mark.parametrize("gamma", THINNING)
def test_the_rounded_slope_at_rest_is_finite_and_the_largest(gamma: float) -> None:
    stress, slope = rounded(0.0, gamma)
    assert stress == 0.0
    assert slope == pytest.approx(K_VISCOUS / H * (U_S / H) ** gamma, rel=1e-13, abs=0)
    assert all(0 < rounded(u, gamma)[1] < slope for u in (0.1 * U_S, U_S, 10 * U_S))


@pytest.mark.parametrize("gamma", SPECIAL)
@pytest.mark.parametrize("u", [1e-18, -U_S, 3e-9, 8e-6])
def test_the_rounded_stress_is_continuous_in_the_index(gamma: float, u: float) -> None:
    neighbour = math.nextafter(gamma, 1.0)
    if gamma == 0.0 and u == 1e-18:
        return  # the rounding begins just below 0
    assert rounded(u, neighbour) == pytest.approx(rounded(u, gamma), rel=3e-14, abs=0)
