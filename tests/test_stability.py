"""The stability of a fixed step: what gives finite and wrong numbers is refused."""

import math

import numpy as np
import pytest

from stickslip.parameters import Parameters
from stickslip.stability import ACCURATE_PART, REFUSE_ABOVE, fastest_rate, largest_stable_step


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


def test_the_step_of_the_paper_is_accepted_at_the_parameters_of_fig_3() -> None:
    assert ACCURATE_PART * limit() > 1e-10


def test_the_step_8e_9_that_has_a_small_error_at_fig_3_is_accepted_there() -> None:
    assert limit() > 8e-9


def test_the_largest_step_at_fig_3_is_set_by_the_melting_in_the_slip() -> None:
    # The order parameter relaxes with up to 2e8 1/s in the slip.
    assert 5e-9 < limit() < 2.5e-8
    assert limit(kinetic_coefficient=50.0) == pytest.approx(2 * limit(), rel=1e-12)


def test_the_largest_step_is_the_limit_over_the_fastest_rate() -> None:
    rate = float(fastest_rate(np.array(Parameters()))[0])
    assert limit() == pytest.approx(REFUSE_ABOVE / rate, rel=1e-15)
    assert REFUSE_ABOVE == 2.0


def test_without_a_slip_the_relaxation_of_the_solid_is_seen() -> None:
    # No springs, no drive to speak of: 2 alpha (T - T_c) - 2 b phi + 3 c phi^2 at phi_plus.
    phi = 0.603782
    rate = 100.0 * (2 * 0.95 * -90.0 - 2 * 230.0 * phi + 3 * 850.0 * phi**2)
    step = limit(spring_stiffness=0.0, drive_amplitude=1e-15, elastic_coefficient=1.0)
    assert step == pytest.approx(2.0 / rate, rel=1e-5)


def test_elastic_friction_limits_the_step_of_a_light_block() -> None:
    phi, M = 0.603782, 1e-9
    rate = 4e12 * phi**2 * 1e-8 / 1e-9 * 0.6e-9 / M
    step = limit(
        block_mass=M, kinetic_coefficient=1e-6, spring_stiffness=0.0, viscosity_coefficient=0.0
    )
    assert step == pytest.approx(2.0 / rate, rel=1e-5)


def test_newtonian_friction_limits_the_step_by_k_A_over_h_M() -> None:
    step = limit(
        rheological_index=0.0,
        elastic_coefficient=0.0,
        kinetic_coefficient=1e-6,
        spring_stiffness=0.0,
        viscosity_coefficient=1e6,
    )
    assert step == pytest.approx(2.0 * 1e-9 * 0.4 / (1e6 * 0.6e-9), rel=1e-9)


def test_dilatant_friction_limits_the_step_by_its_slope_at_the_speed_of_the_drive() -> None:
    step = limit(
        rheological_index=2 / 3,
        elastic_coefficient=0.0,
        kinetic_coefficient=1e-6,
        spring_stiffness=0.0,
    )
    slope = 5e4 * (5 / 3) / 1e-9 * (8e-6 / 1e-9) ** (2 / 3)
    assert step == pytest.approx(2.0 * 0.4 / (slope * 0.6e-9), rel=1e-9)


def test_the_springs_limit_the_step_where_nothing_else_does() -> None:
    step = limit(
        elastic_coefficient=0.0,
        viscosity_coefficient=0.0,
        kinetic_coefficient=1e-6,
        spring_stiffness=1e8,
    )
    assert step == pytest.approx(2.0 / math.sqrt(2e8 / 0.4), rel=1e-9)


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
