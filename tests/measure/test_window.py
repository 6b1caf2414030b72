"""Statistics of single drive periods, against what is plainly true of made-up ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FIRST_PHASE,
    FORCE_MAX,
    FORCE_MIN,
    LAST_PHASE,
    MELTED,
    MELTINGS,
    PHI_MAX,
    RECORD,
    SOLID,
    SOLID_TIME,
    STRESS_MAX,
    STRESS_MIN,
    UNSEEN,
    UNSEEN_TIME,
)
from stickslip.measure.window import Window, standard_errors

Phases = tuple[float, float, float, float, float]


def period(
    stress: tuple[float, float] = (1.0, -1.0), phases: Phases = (UNSEEN, UNSEEN, 0.0, 0.0, 2.0)
) -> np.ndarray:
    """A record (1, RECORD) of a period; `phases`: first, last, meltings, time solid and unseen."""
    record = np.zeros((1, RECORD))
    record[0, [STRESS_MAX, STRESS_MIN]] = stress
    record[0, [FORCE_MAX, FORCE_MIN]] = 2.0 * np.array(stress)
    record[0, [BLOCK_WORK, ABSOLUTE_WORK, PHI_MAX]] = 1.0, 2.0, 0.5
    record[0, [FIRST_PHASE, LAST_PHASE, MELTINGS, SOLID_TIME, UNSEEN_TIME]] = phases
    return record


def window(*periods: np.ndarray) -> Window:
    whole = Window(1)
    for record in periods:
        whole.add(record)
    return whole


def test_extrema_work_and_amplitudes() -> None:
    whole = window(period((3.0, -1.0)), period((2.0, -4.0)), period((1.0, 0.0)))
    record = whole.record[0]
    assert record[[STRESS_MAX, STRESS_MIN, FORCE_MAX, FORCE_MIN]].tolist() == [3.0, -4.0, 6.0, -8.0]
    assert record[[BLOCK_WORK, ABSOLUTE_WORK, PHI_MAX]].tolist() == [3.0, 6.0, 0.5]
    assert whole.amplitudes[:, 0].tolist() == [[2.0, 4.0], [3.0, 6.0], [0.5, 1.0]]


@pytest.mark.parametrize(
    ("periods", "meltings", "solid", "unseen"),
    [
        ([(SOLID, SOLID, 1, 1.0, 0.0), (SOLID, SOLID, 2, 1.5, 0.0)], 3, 2.5, 0.0),
        # It melts on the border of two periods.
        ([(SOLID, SOLID, 0, 2.0, 0.0), (MELTED, MELTED, 0, 0.0, 0.0)], 1, 2.0, 0.0),
        # A period that begins between the thresholds begins in the phase of the one before.
        ([(SOLID, SOLID, 0, 2.0, 0.0), (MELTED, MELTED, 0, 0.0, 0.5)], 1, 2.5, 0.0),
        ([(MELTED, MELTED, 0, 0.0, 0.0), (SOLID, SOLID, 0, 1.0, 0.5)], 0, 1.0, 0.0),
        ([(SOLID, SOLID, 0, 2.0, 0.0), (UNSEEN, UNSEEN, 0, 0.0, 2.0)], 0, 4.0, 0.0),
        ([(UNSEEN, UNSEEN, 0, 0.0, 2.0), (SOLID, SOLID, 0, 1.0, 0.5)], 0, 1.0, 2.5),
    ],
    ids=str,
)
def test_the_film_keeps_its_phase_from_one_period_to_the_next(
    periods: list[Phases], meltings: float, solid: float, unseen: float
) -> None:
    record = window(*(period(phases=phases) for phases in periods)).record[0]
    assert record[MELTINGS] == meltings
    assert record[[SOLID_TIME, UNSEEN_TIME]].tolist() == [solid, unseen]


def test_phases_of_the_ends_are_the_first_and_the_last_that_were_seen() -> None:
    unseen = (UNSEEN, UNSEEN, 0.0, 0.0, 2.0)
    record = window(
        period(phases=unseen), period(phases=(MELTED, SOLID, 0.0, 1.0, 0.0)), period(phases=unseen)
    ).record[0]
    assert record[[FIRST_PHASE, LAST_PHASE]].tolist() == [MELTED, SOLID]


def test_the_standard_error_is_that_of_independent_values() -> None:
    values = np.random.default_rng(3).normal(size=(4000, 500))
    errors = standard_errors(values)
    assert np.mean(errors) == pytest.approx(1.0 / math.sqrt(4000), rel=0.05)
    # A mean is three of its standard errors off once in 100 (20 batches).
    assert np.mean(abs(values.mean(axis=0)) > 3.0 * errors) < 0.02


def test_the_standard_error_counts_correlation() -> None:
    values = np.repeat(np.random.default_rng(4).normal(size=(400, 200)), 10, axis=0)
    assert np.mean(standard_errors(values)) == pytest.approx(1.0 / math.sqrt(400), rel=0.1)


def test_one_period_tells_nothing_of_the_error() -> None:
    assert standard_errors(np.ones((1, 2))).tolist() == [math.inf, math.inf]
