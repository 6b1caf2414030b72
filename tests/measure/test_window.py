"""Statistics of single drive periods, on artificial data with known statistics."""

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
from stickslip.measure.window import Window, error_of_mean, statistics_of

Phases = tuple[float, float, float, float, float]


def period(
    stress: tuple[float, float] = (1.0, -1.0), phases: Phases = (UNSEEN, UNSEEN, 0.0, 0.0, 2.0)
) -> np.ndarray:
    """A record (1, RECORD) of a period; `phases`: first, last, meltings, times solid and unseen."""
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


def test_phases_at_the_ends_are_the_first_and_the_last_known_ones() -> None:
    unseen = (UNSEEN, UNSEEN, 0.0, 0.0, 2.0)
    record = window(
        period(phases=unseen), period(phases=(MELTED, SOLID, 0.0, 1.0, 0.0)), period(phases=unseen)
    ).record[0]
    assert record[[FIRST_PHASE, LAST_PHASE]].tolist() == [MELTED, SOLID]


def test_the_error_of_a_mean_is_three_standard_errors_of_independent_values() -> None:
    values = np.random.default_rng(3).normal(size=(500, 1, 2000))
    errors = np.array([error_of_mean(each) for each in values])
    # Of the batches tried the largest error counts.
    assert 1.0 < np.mean(errors) * math.sqrt(2000) / 3.0 < 1.2
    assert np.mean(abs(values.mean(axis=(1, 2))) > errors) < 0.01


@pytest.mark.parametrize("periods", [20, 32, 37, 64, 200])
def test_the_error_of_a_mean_holds_for_few_periods_too(periods: int) -> None:
    # Correlated over three periods, like single periods of an orbit that never closes.
    noise = np.random.default_rng(periods).normal(size=(2000, periods + 2))
    values = noise[:, :-2] + noise[:, 1:-1] + noise[:, 2:]
    covered = [abs(each.mean()) <= error_of_mean(each[None]) for each in values]
    assert np.mean(covered) > 0.97


def test_all_periods_count() -> None:
    values = np.zeros((1, 32))
    values[0, 0] = 1.0  # not a multiple of any batch
    assert error_of_mean(values) > 0.0
    (means,), (errors,), _ = statistics_of(np.concatenate([values, values])[None])
    assert means.tolist() == [1.0 / 32.0] * 2
    assert errors[0] == error_of_mean(values)


def test_the_error_counts_correlation() -> None:
    values = np.repeat(np.random.default_rng(4).normal(size=(200, 400)), 10, axis=1)
    errors = [error_of_mean(each[None]) for each in values]
    assert np.mean(errors) == pytest.approx(3.0 / math.sqrt(400), rel=0.15)


@pytest.mark.parametrize("periods", [1, 2, 19])
def test_the_error_of_too_few_periods_is_unknown(periods: int) -> None:
    assert error_of_mean(np.ones((1, periods))) == math.inf


def test_statistics_do_not_depend_on_other_motions_to_the_bit() -> None:
    singles = np.random.default_rng(5).normal(size=(7, 2, 200))
    together = statistics_of(singles.transpose(2, 0, 1).copy().transpose(1, 2, 0))
    for i in range(7):
        alone = statistics_of(singles[i : i + 1])
        for ours, theirs in zip(alone, together, strict=True):
            np.testing.assert_array_equal(ours[0], theirs[i])
