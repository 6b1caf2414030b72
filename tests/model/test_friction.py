"""Friction: strain, strain rate and force of Eqs. 4-10 and 24."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.model import friction
from stickslip.model.laws import friction_law
from stickslip.options import FRICTION_LAWS
from stickslip.parameters import Parameters

PAPER = Parameters()  # tau 1e-8 s, h 1e-9 m


def test_the_elastic_strain_is_the_slip_in_a_relaxation_time_over_the_thickness() -> None:
    assert friction.elastic_strain(PAPER, -6.8e-7) == pytest.approx(-6.8e-6, rel=1e-15, abs=0)


@given(u=st.floats(-1.0, 1.0))
def test_the_strain_has_its_slope_everywhere(u: float) -> None:
    assert friction.elastic_strain(PAPER, u) == u * friction.strain_slope(PAPER)


def test_the_strain_rate_is_absolute() -> None:
    assert friction.strain_rate(PAPER, -3e-6) == friction.strain_rate(PAPER, 3e-6)
    assert friction.strain_rate(PAPER, 3e-6) == pytest.approx(3000.0, rel=1e-15, abs=0)


def test_the_friction_force_is_the_sum_of_the_stresses_times_the_area() -> None:
    assert friction.friction_force(PAPER, 4e6, 1e6) == pytest.approx(3e-3, rel=1e-15, abs=0)


@pytest.mark.parametrize("law", FRICTION_LAWS)
@given(
    u=st.floats(-1.0, 1.0),
    gamma=st.floats(-0.999, 2.0) | st.sampled_from([-2 / 3, 0.0, 2 / 3]),
    stiffness=st.floats(0.0, 1e13),
)
def test_friction_never_supplies_power(law: str, u: float, gamma: float, stiffness: float) -> None:
    p = PAPER._replace(rheological_index=gamma)
    sigma_el = stiffness * friction.elastic_strain(p, u)
    sigma_v = friction_law(law).stress(p, u, 0.5)
    assert friction.friction_force(p, sigma_el, sigma_v) * u >= 0
