"""The record of an orbit: extrema, work and phases, in the slots of one lane alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    ELAPSED,
    FIRST_PHASE,
    FIRST_SOLID,
    FORCE_MAX,
    FORCE_MIN,
    FORCE_SIZE,
    HARD,
    IN_PHASE,
    LAST_PHASE,
    LAST_SOLID,
    LIQUID,
    LOSS,
    MELTED,
    MELTINGS,
    MOTION_IN_PHASE,
    MOTION_OUT_OF_PHASE,
    OUT_OF_PHASE,
    PHI_MAX,
    RECORD,
    SOFT,
    SOLID,
    SOLID_CHANGES,
    SOLID_TIME,
    SQUARED_FORCE,
    STRESS_MAX,
    STRESS_MIN,
    UNSEEN,
    UNSEEN_TIME,
    Moment,
    accumulator,
    make_see_integrals,
)

LANES, LANE, FIRST = 4, 2, 3
ALONE = accumulator(1, 0)
"""The accumulator of a record that fills a whole array."""

THRESHOLD, MELTING = 0.135, 0.0135


def fresh() -> np.ndarray:
    record = np.full(RECORD, 7.0)
    ALONE.clear(record, 0)
    return record


# --- lanes ----------------------------------------------------------------------------------------


def test_a_lane_touches_only_its_own_slots() -> None:
    lanes = np.full((FIRST + RECORD + 2) * LANES, -99.0)
    own = np.zeros_like(lanes, dtype=bool).reshape(-1, LANES)
    own[FIRST : FIRST + RECORD, LANE] = True
    record = accumulator(LANES, FIRST)
    record.clear(lanes, LANE)
    record.see_extremum(lanes, LANE, STRESS_MAX, 5.0, True)
    record.see_phase(lanes, LANE, 0.6, THRESHOLD, MELTING, 1.0, True)
    record.see_solid(lanes, LANE, False, False, True, True)
    record.add(lanes, LANE, BLOCK_WORK, 1.0, True)
    record.mirror(lanes, LANE)
    values = lanes.reshape(-1, LANES)
    np.testing.assert_array_equal(values[~own], -99.0)
    alone = fresh()
    ALONE.see_extremum(alone, 0, STRESS_MAX, 5.0, True)
    ALONE.see_phase(alone, 0, 0.6, THRESHOLD, MELTING, 1.0, True)
    ALONE.see_solid(alone, 0, False, False, True, True)
    ALONE.add(alone, 0, BLOCK_WORK, 1.0, True)
    ALONE.mirror(alone, 0)
    np.testing.assert_array_equal(values[own], alone)


# --- extrema and work -----------------------------------------------------------------------------


@pytest.mark.parametrize("slot", [STRESS_MAX, FORCE_MAX])
def test_extrema_are_taken_over_accepted_values(slot: int) -> None:
    record = fresh()
    for value, seen in ((3.0, True), (9.0, False), (-2.0, True), (-8.0, False), (1.0, True)):
        ALONE.see_extremum(record, 0, slot, value, seen)
    assert record[slot : slot + 2].tolist() == [3.0, -2.0]
    other = STRESS_MAX + FORCE_MAX - slot
    assert record[other : other + 2].tolist() == [-math.inf, math.inf]


@pytest.mark.parametrize(
    ("value", "extrema"), [(-4.0, [-4.0, -4.0]), (math.nan, [-math.inf, math.inf])]
)
def test_the_first_value_is_both_maximum_and_minimum_unless_it_is_nan(
    value: float, extrema: list[float]
) -> None:
    record = fresh()
    ALONE.see_extremum(record, 0, STRESS_MAX, value, True)
    assert record[[STRESS_MAX, STRESS_MIN]].tolist() == extrema


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_rejected_step_that_is_not_finite_leaves_no_trace(value: float) -> None:
    record = fresh()
    ALONE.see_extremum(record, 0, STRESS_MAX, 1.0, True)
    ALONE.see_phase(record, 0, 0.6, THRESHOLD, MELTING, 1.0, True)
    ALONE.add(record, 0, BLOCK_WORK, 1.0, True)
    before = record.copy()
    for slot in (STRESS_MAX, FORCE_MAX):
        ALONE.see_extremum(record, 0, slot, value, False)
    ALONE.see_phase(record, 0, value, THRESHOLD, MELTING, 1.0, False)
    ALONE.add(record, 0, BLOCK_WORK, value, False)
    np.testing.assert_array_equal(record, before)


def moment(V: float, F: float, power: float) -> Moment:
    return Moment(
        x=0.1, V=V, u=0.3, phi=0.5, sigma_el=1.0, F=F, power=power, loss=abs(F),
        motion=2.0 * F, phase=math.pi / 6,
    )  # fmt: skip


def test_a_step_adds_to_every_integral_what_its_quadrature_says() -> None:
    record, see = fresh(), make_see_integrals(ALONE, (0.25, 0.75))
    moments = moment(2.0, -3.0, 4.0), moment(1.0, 1.0, 8.0)
    for seen in (True, False):
        see(record, 0, moments, 2.0, seen)
    assert record[BLOCK_WORK] == 2.0 * (0.25 * 4.0 + 0.75 * 8.0)
    assert record[LOSS] == 2.0 * (0.25 * 3.0 + 0.75 * 1.0)
    assert record[ABSOLUTE_WORK] == 2.0 * (0.25 * 6.0 + 0.75 * 1.0)
    make_see_integrals(ALONE, (1.0,))(record, 0, moments[:1], 1.0, True)
    assert record[ABSOLUTE_WORK] == 2.0 * (0.25 * 6.0 + 0.75 * 1.0) + 6.0


def test_integrals_of_a_step_with_a_single_moment() -> None:
    record, moments = fresh(), (moment(2.0, -3.0, 4.0),)
    make_see_integrals(ALONE, (1.0,))(record, 0, moments, 2.0, True)
    assert record[ELAPSED] == 2.0
    assert record[[IN_PHASE, OUT_OF_PHASE]] == pytest.approx([-math.sqrt(27.0), 3.0], rel=1e-15)
    motion = record[[MOTION_IN_PHASE, MOTION_OUT_OF_PHASE]]
    assert motion == pytest.approx([-math.sqrt(108.0), 6.0], rel=1e-15)
    assert record[[SQUARED_FORCE, FORCE_SIZE]].tolist() == [18.0, 6.0]


def test_the_mirror_image_exchanges_maxima_and_minima_and_keeps_the_rest() -> None:
    record = fresh()
    record[:] = np.arange(1.0, RECORD + 1)
    before = record.copy()
    ALONE.mirror(record, 0)
    assert record[[STRESS_MAX, STRESS_MIN]].tolist() == [-before[STRESS_MIN], -before[STRESS_MAX]]
    assert record[[FORCE_MAX, FORCE_MIN]].tolist() == [-before[FORCE_MIN], -before[FORCE_MAX]]
    np.testing.assert_array_equal(record[FORCE_MIN + 1 :], before[FORCE_MIN + 1 :])
    ALONE.mirror(record, 0)
    np.testing.assert_array_equal(record, before)


# --- phases ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("course", "meltings", "ends"),
    [
        ([0.6, 0.1, 0.01, 0.1, 0.6], 1, (SOLID, SOLID)),
        ([0.05, 0.01, 0.1, 0.6, 0.05], 0, (MELTED, SOLID)),  # the melting comes after the end
        ([0.01, 0.6, 0.01, 0.6, 0.01], 2, (MELTED, MELTED)),
        ([0.6, 0.02, 0.6, 0.1, 0.6], 0, (SOLID, SOLID)),  # not far enough for a melting
        ([0.01, 0.1, 0.01], 0, (MELTED, MELTED)),  # ... nor for a solidification before one
        ([0.05, 0.1, 0.05], 0, (UNSEEN, UNSEEN)),
        ([THRESHOLD, MELTING], 1, (SOLID, MELTED)),  # the thresholds belong to the phases
        ([0.6, 0.05, 0.01], 1, (SOLID, MELTED)),  # between the thresholds it keeps its phase
    ],
)
def test_meltings_are_counted_with_hysteresis(
    course: list[float], meltings: int, ends: tuple[float, float]
) -> None:
    record = fresh()
    for phi in course:
        ALONE.see_phase(record, 0, phi, THRESHOLD, MELTING, 1.0, True)
        ALONE.see_phase(record, 0, 0.6 if phi < 0.1 else 0.0, THRESHOLD, MELTING, 1.0, False)
    assert record[MELTINGS] == meltings
    assert (record[FIRST_PHASE], record[LAST_PHASE]) == ends
    assert record[PHI_MAX] == max(course)


def test_the_times_in_the_solid_and_before_the_first_phase_add_up() -> None:
    record = fresh()
    for phi, duration in ((0.05, 1.0), (0.6, 2.0), (0.05, 4.0), (0.01, 8.0), (0.05, 16.0)):
        ALONE.see_phase(record, 0, phi, THRESHOLD, MELTING, duration, True)
        ALONE.see_phase(record, 0, 0.6, THRESHOLD, MELTING, 32.0, False)
    assert record[[SOLID_TIME, UNSEEN_TIME]].tolist() == [6.0, 1.0]


@pytest.mark.parametrize(
    ("phis", "changes", "first", "last"),
    [
        ([0.05, 0.0, 0.05], 0, LIQUID, LIQUID),
        ([0.2, 0.3, 0.45, 0.3], 0, SOFT, SOFT),  # between the two it keeps its phase
        ([0.6, 0.45, 0.3, 0.45, 0.6], 2, HARD, HARD),
        ([0.6, 0.3, 0.0, 0.6], 1, HARD, HARD),  # changes through the liquid do not count
    ],
)
def test_changes_between_two_solids_are_counted(
    phis: list[float], changes: int, first: float, last: float
) -> None:
    record = fresh()
    for phi in phis:
        soft, hard = 0.12 <= phi <= 0.4, phi >= 0.5
        ALONE.see_solid(record, 0, phi <= 0.012, soft, hard, True)
        ALONE.see_solid(record, 0, soft, hard, soft, False)  # a rejected step
    assert record[[SOLID_CHANGES, FIRST_SOLID, LAST_SOLID]].tolist() == [changes, first, last]
