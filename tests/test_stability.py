"""The stability of a fixed step: steps with finite but wrong results are refused."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.parameters import Parameters
from stickslip.stability import ACCURATE_PART, largest_stable_step, static_strength, step_as_text


def limit(**changes: float) -> float:
    return float(largest_stable_step(np.array(Parameters(**changes)))[0])


FINITE_BUT_WRONG = [
    ({"angular_frequency": 38.0}, 8e-8),  # stress 17 times too high
    ({"rheological_index": 0.0}, 2.6e-5),  # force 8 times too high
    ({"rheological_index": 2 / 3}, 2e-6),  # 2.3 times
    ({"block_mass": 1e-3}, 2e-6),  # stress 13 times
    ({"strain_relaxation_time": 1e-6}, 2e-6),  # 10 times, with a good power balance
]


@pytest.mark.parametrize(("changes", "dt"), FINITE_BUT_WRONG)
def test_a_step_that_gives_finite_but_wrong_numbers_is_refused(
    changes: dict[str, float], dt: float
) -> None:
    assert limit(**changes) < dt


@pytest.mark.parametrize("omega", [10.0, 15.0, 32.0, 38.0])
def test_the_step_of_the_paper_is_accepted_at_its_parameters(omega: float) -> None:
    assert limit(angular_frequency=omega) > 10 * 1e-10 > 1e-10 / ACCURATE_PART


def test_the_largest_step_at_fig_3_is_set_by_the_melting_in_the_slip() -> None:
    # The order parameter relaxes at up to 2e8 1/s in the slip; the error at 8e-9 s is still small.
    assert 8e-9 < limit() < 2.5e-8
    assert limit(kinetic_coefficient=50.0) == pytest.approx(2 * limit(), rel=1e-12)


PHI = 0.603782
"""phi_plus at 200 K and no strain."""

NO_SPRINGS = {"spring_stiffness": 0.0}
SLOW_FILM = {"kinetic_coefficient": 1e-6}
VISCOUS = {"elastic_coefficient": 0.0, **SLOW_FILM}
# The friction A k (u/h)^(5/3) is never more than the inertia in the drive.
LOCKED = 1e-9 * (0.4 * 10.0**2 * 0.8e-6 / (0.6e-9 * 5e4)) ** (3 / 5)


def dilatant_slope(k: float, speed: float) -> float:
    return k * (5 / 3) / 1e-9 * (speed / 1e-9) ** (2 / 3)


# Scenes in which a known rate is the fastest: changes, the rate [1/s], and its relative error, as
# PHI has six digits.
FASTEST = {
    "relaxation of a solid that does not slip": (
        {**NO_SPRINGS, "drive_amplitude": 1e-15, "elastic_coefficient": 1.0},
        # 2 alpha (T - T_c) - 2 b phi + 3 c phi^2 at phi_plus
        100.0 * (2 * 0.95 * -90.0 - 2 * 230.0 * PHI + 3 * 850.0 * PHI**2),
        1e-5,
    ),
    "elastic friction of a light block": (
        {"block_mass": 1e-9, **SLOW_FILM, **NO_SPRINGS, "viscosity_coefficient": 0.0},
        4e12 * PHI**2 * 1e-8 / 1e-9 * 0.6e-9 / 1e-9,
        1e-5,
    ),
    "Newtonian friction": (
        {"rheological_index": 0.0, **VISCOUS, **NO_SPRINGS, "viscosity_coefficient": 1e6},
        1e6 * 0.6e-9 / (1e-9 * 0.4),
        1e-9,
    ),
    "dilatant friction at the speed of the drive": (
        {"rheological_index": 2 / 3, **VISCOUS, "viscosity_coefficient": 5.0},
        dilatant_slope(5.0, 8e-6) * 0.6e-9 / 0.4,
        1e-9,
    ),
    "a thick fluid that locks the block before it is that fast": (
        {"rheological_index": 2 / 3, **VISCOUS, **NO_SPRINGS},
        dilatant_slope(5e4, LOCKED) * 0.6e-9 / 0.4,
        1e-9,
    ),
    "springs": (
        {**VISCOUS, "viscosity_coefficient": 0.0, "spring_stiffness": 1e8},
        math.sqrt(2e8 / 0.4),
        1e-9,
    ),
}


@pytest.mark.parametrize(("changes", "rate", "rel"), FASTEST.values(), ids=FASTEST)
def test_the_largest_step_is_2_over_the_fastest_rate(
    changes: dict[str, float], rate: float, rel: float
) -> None:
    assert limit(**changes) == pytest.approx(2.0 / rate, rel=rel)


def test_the_step_of_the_paper_is_stable_where_a_thick_fluid_locks_the_block() -> None:
    # An earlier version refused it, although 8e-9 s gives the force of the first period to 1e-7.
    step = limit(rheological_index=0.95, viscosity_coefficient=4e5, angular_frequency=60.0)
    assert 1e-7 < step < 1e-6


def test_the_limit_depends_on_the_start() -> None:
    # From x_0 the springs drive a slip in which steps above 2e-7 s give NaN.
    scene = {
        "temperature": 310.0,
        "spring_stiffness": 2e4,
        "angular_frequency": 20.0,
        "kinetic_coefficient": 10.0,
        "viscosity_coefficient": 1e4,
    }
    assert limit(**scene, initial_displacement=2e-7) < 2e-7
    assert limit(**scene) > 1e-6


def test_a_start_at_speed_or_with_tight_springs_makes_the_slip_faster() -> None:
    assert limit(initial_velocity=1e-3) < limit()
    assert limit(initial_velocity=-1e-3) == limit(initial_velocity=1e-3)


def test_the_infinite_slope_of_a_pseudoplastic_fluid_is_left_out() -> None:
    assert limit(rheological_index=-2 / 3) == limit(rheological_index=-0.5)


def test_a_mirrored_drive_has_the_same_limit() -> None:
    assert limit(drive_amplitude=-0.8e-6) == limit()


EXTREMES = [
    {"spring_stiffness": 0.0},
    {"spring_stiffness": 1e8},
    {"rheological_index": -0.999},
    {"rheological_index": -0.9},
    {"rheological_index": 2.0},
    {"rheological_index": 5.0},
    {"viscosity_coefficient": 0.0},
    {"viscosity_coefficient": 1e9},
    {"elastic_coefficient": 0.0},
    {"cubic_coefficient": 0.0},
    {"thermal_coefficient": 0.0},
    {"cubic_coefficient": 0.0, "thermal_coefficient": 0.0},
    {"temperature": 0.0},
    {"temperature": 1e4},
    {"angular_frequency": 1e5},
    {"block_mass": 1e-9},
    {"film_thickness": 1e-11},
]


@pytest.mark.parametrize("changes", EXTREMES, ids=str)
def test_the_largest_step_is_positive_and_finite_at_extreme_parameters(
    changes: dict[str, float],
) -> None:
    assert 0.0 < limit(**changes) < math.inf


def test_many_points_give_what_each_gives_alone() -> None:
    points = np.array([Parameters(**changes) for changes in EXTREMES])
    alone = [limit(**changes) for changes in EXTREMES]
    assert np.array_equal(largest_stable_step(points), alone)


def test_a_step_that_does_not_resolve_the_drive_is_refused() -> None:
    calm = {
        "angular_frequency": 1e5,
        "temperature": 320.0,
        "kinetic_coefficient": 1e-3,
        "strain_relaxation_time": 1e-12,
        "rheological_index": 0.0,
        "viscosity_coefficient": 1e3,
    }
    assert limit(**calm) <= 2 * np.pi / 1e5 / 60


# --- the text of a step ---------------------------------------------------------------------------


@given(st.floats(1e-12, 1e-1))
def test_a_step_in_two_digits_is_still_allowed(step: float) -> None:
    text = step_as_text(step)
    assert 0.9 * step < float(text) <= step
    assert len(re.sub(r"e.*|[.]|^0[.]0*", "", text)) <= 2


# --- the static strength --------------------------------------------------------------------------


def strength_by_hand(p: Parameters) -> float:
    """The largest of many strains up to melting: Eqs. 13, 16 and 19 written out again."""
    half = p.cubic_coefficient / (2 * p.quartic_coefficient)
    heating = 2 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    most = (half**2 * p.quartic_coefficient - heating) / p.elastic_coefficient
    eps = np.linspace(0.0, math.sqrt(max(most, 0.0)), 100_001)
    B = p.elastic_coefficient * eps**2 + heating
    phi = half + np.sqrt(np.maximum(half**2 - B / p.quartic_coefficient, 0.0))
    return float(np.max(p.elastic_coefficient * phi**2 * eps))


@pytest.mark.parametrize(
    "changes",
    [{}, {"temperature": 285.0}, {"temperature": 100.0}, {"cubic_coefficient": 0.0}],
    ids=str,
)
def test_the_static_strength_is_the_largest_stress_of_a_solid_film(
    changes: dict[str, float],
) -> None:
    p = Parameters(**changes)
    assert static_strength(np.array(p))[0] == pytest.approx(strength_by_hand(p), rel=1e-4)


def test_fewer_strains_give_less_and_never_more() -> None:
    temperatures = np.linspace(150.0, 295.0, 30)
    points = np.array([Parameters(temperature=T) for T in temperatures])
    fine, coarse = static_strength(points, 2000), static_strength(points, 12)
    assert np.all(coarse <= fine)
    assert np.all(coarse >= 0.98 * fine)


def test_a_film_that_is_liquid_or_not_elastic_has_no_strength() -> None:
    liquid = Parameters(temperature=400.0)
    assert static_strength(np.array(liquid))[0] == 0.0
    assert static_strength(np.array(Parameters(elastic_coefficient=0.0)))[0] == 0.0
