"""Records: extrema of odd cycles, differences of two, and units."""

from __future__ import annotations

import numpy as np
import pytest
from support.records import SI, record_of

from stickslip import Parameters
from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FORCE_MAX,
    FORCE_MIN,
    MELTED,
    MELTINGS,
    PHI_MAX,
    RECORD,
    SOLID,
    STRESS_MAX,
    STRESS_MIN,
)
from stickslip.measure.results import (
    RecordUnits,
    full_force,
    relative_difference,
    write_whole_orbit,
)

P = Parameters()
SPRING = 2 * 3000.0 * 0.8e-6
"""Force of both springs at the amplitude of the drive [N]."""


# --- differences of records -----------------------------------------------------------------------


def difference(cycle: int = 2, **slots: float) -> float:
    """The difference of two records of `cycle` half periods."""
    one, other = np.empty(RECORD), np.empty(RECORD)
    write_whole_orbit(record_of(**slots), SI, cycle, one)
    write_whole_orbit(record_of(), SI, cycle, other)
    return relative_difference(P, one, other)


def test_a_record_does_not_differ_from_itself() -> None:
    assert difference() == 0.0


@pytest.mark.parametrize(
    ("slots", "expected"),
    [
        ({"STRESS_MAX": 3e6 + 20.0}, 20.0 / 2e6),
        ({"STRESS_MAX": 3e6 + 20.0, "STRESS_MIN": -1e6 + 20.0}, 40.0 / 2e6),  # nothing cancels
        ({"FORCE_MIN": -1e-3 - 3e-9}, 3e-9 / 1.5e-3),
        ({"FORCE_MIN": -1e-3 - 3e-9, "STRESS_MAX": 3e6 + 20.0}, 20.0 / 2e6),  # the worse of the two
    ],
    ids=str,
)
def test_a_difference_is_relative_to_the_amplitude(
    slots: dict[str, float], expected: float
) -> None:
    assert difference(**slots) == pytest.approx(expected, rel=1e-6)


def test_the_difference_of_an_odd_cycle_is_taken_over_the_whole_orbit() -> None:
    # The minimum of the measured half has no effect, because the mirror image goes lower.
    assert difference(cycle=1, STRESS_MIN=-2e6) == 0.0
    assert difference(cycle=1, STRESS_MAX=3e6 + 30.0) == pytest.approx(2 * 30.0 / 3e6, rel=1e-6)


def test_small_amplitudes_count_against_a_hundredth_of_the_full_force() -> None:
    assert full_force(P) == pytest.approx(SPRING, rel=1e-15)
    assert full_force(Parameters(drive_amplitude=-0.8e-6)) == full_force(P)
    heavy = Parameters(spring_stiffness=0.0, angular_frequency=20.0)  # free: its inertia alone
    assert full_force(heavy) == pytest.approx(heavy.block_mass * 20.0**2 * 0.8e-6, rel=1e-15)
    none = {"STRESS_MAX": 0.0, "STRESS_MIN": 0.0, "FORCE_MAX": 0.0, "FORCE_MIN": 0.0}
    stress = relative_difference(P, record_of(**none | {"STRESS_MAX": 8.0}), record_of(**none))
    assert stress == pytest.approx(8.0 / (0.01 * SPRING / 0.6e-9), rel=1e-12)
    force = relative_difference(P, record_of(**none | {"FORCE_MAX": 1e-9}), record_of(**none))
    assert force == pytest.approx(1e-9 / (0.01 * SPRING), rel=1e-12)


def test_without_springs_and_force_there_is_no_difference() -> None:
    none = record_of(STRESS_MAX=0.0, STRESS_MIN=0.0, FORCE_MAX=0.0, FORCE_MIN=0.0)
    assert relative_difference(Parameters(spring_stiffness=0.0), none, none) == 0.0


# --- units ----------------------------------------------------------------------------------------


def test_negative_units_exchange_maximum_and_minimum() -> None:
    units = RecordUnits(length=-2.0, stress=-10.0, force=-0.5, time=1.0)
    target = np.empty(RECORD)
    write_whole_orbit(record_of(), units, 2, target)
    assert target[[STRESS_MAX, STRESS_MIN]].tolist() == [1e7, -3e7]
    assert target[[FORCE_MAX, FORCE_MIN]].tolist() == [5e-4, -1e-3]
    assert target[ABSOLUTE_WORK] > 0.0


def test_the_record_of_an_odd_cycle_is_extended_to_the_whole_orbit() -> None:
    target = np.empty(RECORD)
    phases = {"MELTINGS": 2.0, "FIRST_PHASE": MELTED, "LAST_PHASE": SOLID}
    deep = {"FORCE_MAX": 1e-3, "FORCE_MIN": -2e-3}  # the mirror image has the maximum
    write_whole_orbit(record_of(BLOCK_WORK=4.0, **phases, **deep), SI, 3, target)
    extrema = target[[STRESS_MAX, STRESS_MIN, FORCE_MAX, FORCE_MIN]]
    assert extrema.tolist() == [3e6, -3e6, 2e-3, -2e-3]
    assert target[[BLOCK_WORK, ABSOLUTE_WORK, PHI_MAX]].tolist() == [8.0, 2e-8, 0.6]
    assert target[MELTINGS] == 6.0  # two and the one across the end, and their mirror images
