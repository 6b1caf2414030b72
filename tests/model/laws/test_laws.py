"""What every law of the viscous stress promises: odd, rising, its slope, its rounding, its bounds.

A new law in `options.FRICTION_LAWS` is tested by being there; fluids with other parameters than
these belong into FLUIDS.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from support.differences import slope_of
from support.reduced import reduced_of

from stickslip.model import scaling
from stickslip.model.laws import FrictionLaw, friction_law
from stickslip.options import FRICTION_LAWS, Physics
from stickslip.parameters import Parameters

FLUIDS = [
    Parameters(rheological_index=gamma)
    for gamma in (-0.9, -2 / 3, -0.5, -1 / 3, 0.0, 1 / 3, 2 / 3, 2.0, 5.0)
] + [Parameters(viscosity_coefficient=1.0, film_thickness=1e-8)]

SPEEDS = np.geomspace(1e-15, 1.0, 61).tolist()
U_S = 8e-12
"""A tolerance of 1e-6 of the drive's largest speed."""

SCALED = (
    "a parameter is not scaled as the law uses it: a number with a unit in its file, or a time "
    "that meets |u|/h and is not among `scaled`"
)


PHI = 0.37
"""An order parameter at which laws are looked at."""


class Fluid(NamedTuple):
    law: FrictionLaw
    p: Parameters

    def stress(self, u: float, phi: float = PHI) -> float:
        return float(self.law.stress(self.p, u, phi))

    def rounded(self, u: float, u_s: float, phi: float = PHI) -> tuple[float, float]:
        """Stress and its slope over u."""
        stress, slope, _ = self.law.rounded(self.p, u, phi, u_s)
        return stress, slope


@pytest.fixture(
    scope="module",
    params=[(law, p) for law in FRICTION_LAWS for p in FLUIDS],
    ids=lambda param: f"{param[0]},{param[1].rheological_index:.2g},{param[1].film_thickness:g}",
)
def fluid(request: pytest.FixtureRequest) -> Fluid:
    law, p = request.param
    return Fluid(friction_law(law), p)


@pytest.fixture(scope="module", params=FRICTION_LAWS)
def law(request: pytest.FixtureRequest) -> FrictionLaw:
    return friction_law(request.param)


# --- what is declared ----------------------------------------------------------------------------


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(KeyError, match="no-such-law"):
        friction_law("no-such-law")


def test_a_laws_own_parameters_change_its_stress(law: FrictionLaw) -> None:
    p = Parameters()
    for name in law.parameters:
        changed = p._replace(**{name: 0.9 * getattr(p, name)})
        assert law.stress(changed, 3e-6, PHI) != law.stress(p, 3e-6, PHI)


# --- the exact law -------------------------------------------------------------------------------


def slope(fluid: Fluid, u: float) -> float:
    """Derivative of the exact stress with respect to `u`."""
    return fluid.rounded(u, 0.0)[1]


def test_the_stress_is_odd_bit_for_bit_and_has_the_sign_of_the_slip(fluid: Fluid) -> None:
    for u in SPEEDS:
        stress = fluid.stress(u)
        assert stress > 0
        assert fluid.stress(-u) == -stress


def test_the_stress_does_not_fall_with_the_slip(fluid: Fluid) -> None:
    speeds = [-u for u in reversed(SPEEDS)] + [0.0, *SPEEDS]
    stresses = [fluid.stress(u) for u in speeds]
    assert np.all(np.diff(stresses) >= 0)
    assert min(slope(fluid, u) for u in speeds) >= 0


def test_the_stress_does_not_fall_with_the_order_parameter(fluid: Fluid) -> None:
    for u in SPEEDS:
        assert np.all(np.diff([fluid.stress(u, phi) for phi in (0.0, 1e-9, 0.1, PHI, 1.1)]) >= 0)


def test_the_derivative_over_the_log_of_the_order_parameter_is_that_of_the_stress(
    fluid: Fluid,
) -> None:
    for u in SPEEDS[::10]:

        def stress(psi: float, u: float = u) -> float:
            return fluid.stress(u, math.exp(psi))

        of_law = fluid.law.rounded(fluid.p, u, PHI, 0.0)[2]
        difference = slope_of(stress, math.log(PHI), 1e-3)
        assert of_law == pytest.approx(difference, rel=1e-9, abs=1e-11 * fluid.stress(u))


def test_the_slope_is_the_derivative_of_the_stress(fluid: Fluid) -> None:
    def stress(u: float) -> float:
        return fluid.stress(u)

    for u in [*SPEEDS, *(-u for u in SPEEDS)]:
        # Where the stress is nearly constant the differences lose digits, and a law need not be
        # exact to more than a rounding of its stress at the speed of the drive.
        noise = 1e-11 * abs(stress(u) / u) + 1e-13 * stress(8e-6) / abs(u)
        difference = slope_of(stress, u, 1e-3 * u)
        assert slope(fluid, u) == pytest.approx(difference, rel=1e-9, abs=noise)


@pytest.mark.parametrize("u", [0.0, -0.0, 5e-324, -5e-324, 1e-300])
def test_all_is_finite_where_the_blocks_move_together(fluid: Fluid, u: float) -> None:
    for u_s in (0.0, U_S):
        stress, steepness = fluid.rounded(u, u_s)
        assert math.isfinite(stress)
        assert 0 <= steepness < math.inf
    assert math.isfinite(fluid.stress(u))
    assert 0 <= slope(fluid, u) < math.inf


def test_the_stress_vanishes_where_the_blocks_move_together(fluid: Fluid) -> None:
    assert fluid.stress(0.0) == 0.0
    assert fluid.rounded(0.0, U_S)[0] == 0.0


def test_nan_goes_through(fluid: Fluid) -> None:
    assert math.isnan(fluid.stress(math.nan))
    assert math.isnan(fluid.rounded(math.nan, U_S)[0])


# --- the rounded law -----------------------------------------------------------------------------


def test_the_rounded_law_is_the_exact_one_away_from_the_cusp(fluid: Fluid) -> None:
    for u in [*SPEEDS, *(-u for u in SPEEDS)]:
        for part in (1e-3, 1e-5, 1e-7):
            exact = fluid.stress(u), slope(fluid, u)
            rounded = fluid.rounded(u, part * abs(u))
            # The distance falls with the square; a general power is exact to its logarithm.
            assert rounded == pytest.approx(exact, rel=20 * part**2 + 1e-13, abs=0)


def test_without_a_cusp_there_is_nothing_to_round(fluid: Fluid) -> None:
    if not fluid.law.has_cusp(fluid.p):
        for u in SPEEDS:
            exact = fluid.stress(u), slope(fluid, u)
            assert fluid.rounded(u, 10 * u) == pytest.approx(exact, rel=1e-13, abs=0)


def test_the_rounded_stress_is_odd_and_its_slope_even_bit_for_bit(fluid: Fluid) -> None:
    for u in SPEEDS:
        stress, steepness = fluid.rounded(u, U_S)
        assert fluid.rounded(-u, U_S) == (-stress, steepness)


def test_the_rounded_slope_is_the_derivative_of_the_rounded_stress(fluid: Fluid) -> None:
    def stress(u: float) -> float:
        return fluid.rounded(u, U_S)[0]

    for u in [way * size * U_S for size in np.geomspace(0.1, 30.0, 30) for way in (1, -1)]:
        step = 1e-3 * abs(u)
        noise = 1e-14 * 40 * max(abs(stress(u - 2 * step)), abs(stress(u + 2 * step))) / step
        noise += 1e-13 * stress(8e-6) / abs(u)
        rounded = fluid.rounded(u, U_S)[1]
        assert rounded == pytest.approx(slope_of(stress, u, step), rel=1e-9, abs=noise)


# --- what a law says about itself ----------------------------------------------------------------


def test_a_cusp_is_where_the_slope_has_no_bound(fluid: Fluid) -> None:
    at_rest, near = (slope(fluid, u) for u in (0.0, 1e-15))
    if fluid.law.has_cusp(fluid.p):
        assert at_rest > 10 * near > 10 * slope(fluid, 1e-6)
        assert fluid.rounded(0.0, U_S)[1] < at_rest
    else:
        assert at_rest <= near * (1 + 1e-6)


def test_the_stable_slope_bounds_the_slopes_of_a_law_without_a_cusp(fluid: Fluid) -> None:
    for u in SPEEDS:
        stable = fluid.law.stable_slope(fluid.p, u, PHI)
        assert 0 <= stable < math.inf
        if not fluid.law.has_cusp(fluid.p):
            slopes = [slope(fluid, part * u) for part in (0.0, 0.1, 0.5, 1.0)]
            assert stable >= max(slopes) * (1 - 1e-12)


def test_the_nondimensional_stress_is_the_original_in_other_units(fluid: Fluid) -> None:
    unit = scaling.units_of(fluid.p)
    q = scaling.model_values(None)(reduced_of(fluid.p, Physics(fluid.law.name)))
    for u in (-2.0, 1e-3, 1.0, 30.0):
        expected = fluid.stress(u * unit.speed) / unit.stress
        assert fluid.law.stress(q, u, PHI) == pytest.approx(expected, rel=1e-12, abs=0), SCALED
