"""Statistics of single drive periods: of orbits that close after several, or never."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stickslip.measure.accumulate import (
    FIRST_PHASE,
    FIRST_SOLID,
    FORCE_MAX,
    FORCE_MIN,
    HIGHEST,
    LARGEST,
    LAST_PHASE,
    LAST_SOLID,
    LOWEST,
    MELTED,
    MELTINGS,
    RECORD,
    SOFT,
    SOLID,
    SOLID_CHANGES,
    SOLID_TIME,
    STRESS_MAX,
    STRESS_MIN,
    SUM,
    UNSEEN,
    UNSEEN_TIME,
    slots_of,
)

# Periods of a batch: the longer, the more nearly independent, and the fewer there are. Of fewer
# batches than these the deviation is not known.
_BATCH_LENGTHS = (5, 10, 20)
_FEWEST_BATCHES = 4

# Standard deviations that count as the error of a mean.
_SIGMAS = 3.0

_HIGHEST, _LOWEST = list(slots_of(HIGHEST, LARGEST)), list(slots_of(LOWEST))
_SUMS = list(slots_of(SUM))


def amplitudes_of(records: np.ndarray) -> np.ndarray:
    """Amplitudes (n, 2) of stress and force in records (n, RECORD), in their units."""
    return 0.5 * (records[:, [STRESS_MAX, FORCE_MAX]] - records[:, [STRESS_MIN, FORCE_MIN]])


class Window:
    """Consecutive drive periods of n motions, taken in one after the other.

    `record` (n, RECORD) is that of all periods so far, in SI units.
    """

    def __init__(self, count: int) -> None:
        self.record = np.zeros((count, RECORD))
        self.record[:, list(slots_of(HIGHEST))] = -math.inf
        self.record[:, _LOWEST] = math.inf
        self._amplitudes: list[np.ndarray] = []

    def add(self, records: np.ndarray) -> None:
        """Take in a period of each motion: `records` (n, RECORD) of stretches, in SI units."""
        whole, before = self.record, self.record[:, LAST_PHASE].copy()
        begin, end = records[:, FIRST_PHASE], records[:, LAST_PHASE]
        self._amplitudes.append(amplitudes_of(records))
        whole[:, _HIGHEST] = np.maximum(whole[:, _HIGHEST], records[:, _HIGHEST])
        whole[:, _LOWEST] = np.minimum(whole[:, _LOWEST], records[:, _LOWEST])
        whole[:, _SUMS] += records[:, _SUMS]
        whole[:, MELTINGS] += (before == SOLID) & (begin == MELTED)  # on the border of two periods
        kind, first = whole[:, LAST_SOLID].copy(), records[:, FIRST_SOLID]
        whole[:, SOLID_CHANGES] += (kind >= SOFT) & (first >= SOFT) & (kind != first)
        whole[:, LAST_SOLID] = np.where(first == UNSEEN, kind, records[:, LAST_SOLID])
        known = before != UNSEEN  # a film keeps the phase that it had
        whole[known, UNSEEN_TIME] -= records[known, UNSEEN_TIME]
        frozen = before == SOLID
        whole[frozen, SOLID_TIME] += records[frozen, UNSEEN_TIME]
        first = whole[:, FIRST_PHASE]
        whole[:, FIRST_PHASE] = np.where(first == UNSEEN, begin, first)
        whole[:, LAST_PHASE] = np.where(end == UNSEEN, before, end)

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitudes of stress [Pa] and force [N] of single periods, (periods, n, 2)."""
        return np.array(self._amplitudes)


def mean_in_order(values: Sequence[np.ndarray]) -> np.ndarray:
    """The mean (n,) of values (n,), added one after the other.

    NumPy adds those of a single motion in pairs: its last bit would tell whether it was alone.
    """
    return np.asarray(np.cumsum(values, axis=0)[-1] / len(values))


def statistics_of(singles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means, their errors and standard deviations, each (n, 2), of `singles` (n, 2, periods)."""
    moments = np.empty((3, *singles.shape[:2]))
    for i, motion in enumerate(singles):
        for j, values in enumerate(motion):
            # NumPy adds in an order that depends on the layout: that of each motion is its own.
            own = np.ascontiguousarray(values)
            moments[:, i, j] = own.mean(), error_of_mean(own[None]), own.std()
    means, errors, deviations = moments
    return means, errors, deviations


def error_of_mean(values: np.ndarray) -> float:
    """How far the mean of `values` (paths, periods), correlated along a path, may be off.

    It is so with the probability of three standard deviations: by the means of batches of
    consecutive periods, whose number is taken account of by Student's distribution. Batches of
    several lengths are tried and the largest error counts, since none is known to be long enough.
    Infinite where there is one batch only.
    """
    paths, periods = values.shape
    errors = [
        _error_by_batches(values, periods // length)
        for length in _BATCH_LENGTHS
        if paths * (periods // length) >= _FEWEST_BATCHES
    ]
    return max(errors, default=math.inf)


def _error_by_batches(values: np.ndarray, batches: int) -> float:
    """The same by so many batches of each path (paths, periods), which differ by a period."""
    from scipy.special import ndtr, stdtrit  # a tenth of a second, for those who wander

    parts = np.array_split(values, batches, axis=1)
    lengths = np.array([part.shape[1] for part in parts])
    means = np.array(
        [np.ascontiguousarray(part).mean(axis=1) for part in parts]
    )  # (batches, paths)
    away = np.ascontiguousarray(lengths[:, None] * (means - values.mean()) ** 2).sum()
    freedom = means.size - 1
    # The variance of a mean of `length` periods is that of one over `length`: so they are weighed.
    variance = float(away) / freedom / values.size
    return math.sqrt(variance) * float(stdtrit(freedom, ndtr(_SIGMAS)))
