"""Statistics of single drive periods, for orbits that close after several periods, or never."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stickslip.measure.accumulate import (
    BLOCK_WORK,
    FIRST_PHASE,
    FIRST_SOLID,
    FORCE_MAX,
    FORCE_MIN,
    HIGHEST,
    INTEGRALS,
    LARGEST,
    LAST_PHASE,
    LAST_SOLID,
    LOSS,
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

# Periods per batch, and the smallest number of batches from which the deviation is known. Longer
# batches are more independent, but there are fewer of them.
_BATCH_LENGTHS = (5, 10, 20)
_FEWEST_BATCHES = 4

# The error of a mean, in standard deviations.
_SIGMAS = 3.0

_HIGHEST, _LOWEST = list(slots_of(HIGHEST, LARGEST)), list(slots_of(LOWEST))
_SUMS = list(slots_of(SUM))


def amplitudes_of(records: np.ndarray) -> np.ndarray:
    """Return the amplitudes (n, 2) of stress and force from records (n, RECORD), in their units."""
    return 0.5 * (records[:, [STRESS_MAX, FORCE_MAX]] - records[:, [STRESS_MIN, FORCE_MIN]])


def integrals_of(records: np.ndarray) -> np.ndarray:
    """Return the INTEGRALS (n, 5) of stretches of motion, with the whole work of the drive."""
    integrals = records[:, list(INTEGRALS)]
    integrals[:, INTEGRALS.index(LOSS)] += records[:, BLOCK_WORK]
    return np.asarray(integrals)


class Window:
    """Consecutive drive periods of n motions, added one by one.

    `record` (n, RECORD) covers all periods so far, in SI units.
    """

    def __init__(self, count: int) -> None:
        self.record = np.zeros((count, RECORD))
        self.record[:, list(slots_of(HIGHEST))] = -math.inf
        self.record[:, _LOWEST] = math.inf
        self._amplitudes: list[np.ndarray] = []
        self._integrals: list[np.ndarray] = []

    def add(self, records: np.ndarray) -> None:
        """Add a period of each motion, from its `records` (n, RECORD) in SI units."""
        whole, before = self.record, self.record[:, LAST_PHASE].copy()
        begin, end = records[:, FIRST_PHASE], records[:, LAST_PHASE]
        self._amplitudes.append(amplitudes_of(records))
        self._integrals.append(integrals_of(records))
        whole[:, _HIGHEST] = np.maximum(whole[:, _HIGHEST], records[:, _HIGHEST])
        whole[:, _LOWEST] = np.minimum(whole[:, _LOWEST], records[:, _LOWEST])
        whole[:, _SUMS] += records[:, _SUMS]
        whole[:, MELTINGS] += (before == SOLID) & (begin == MELTED)  # between two periods
        kind, first = whole[:, LAST_SOLID].copy(), records[:, FIRST_SOLID]
        whole[:, SOLID_CHANGES] += (kind >= SOFT) & (first >= SOFT) & (kind != first)
        whole[:, LAST_SOLID] = np.where(first == UNSEEN, kind, records[:, LAST_SOLID])
        known = before != UNSEEN  # the film keeps its phase from one period to the next
        whole[known, UNSEEN_TIME] -= records[known, UNSEEN_TIME]
        frozen = before == SOLID
        whole[frozen, SOLID_TIME] += records[frozen, UNSEEN_TIME]
        first = whole[:, FIRST_PHASE]
        whole[:, FIRST_PHASE] = np.where(first == UNSEEN, begin, first)
        whole[:, LAST_PHASE] = np.where(end == UNSEEN, before, end)

    @property
    def amplitudes(self) -> np.ndarray:
        """The amplitudes of stress [Pa] and force [N] of single periods, (periods, n, 2)."""
        return np.array(self._amplitudes)

    @property
    def integrals(self) -> np.ndarray:
        """The INTEGRALS of single periods, from `integrals_of`, (periods, n, 5)."""
        return np.array(self._integrals)


def mean_in_order(values: Sequence[np.ndarray]) -> np.ndarray:
    """Return the mean (n,) of values (n,), added one by one.

    NumPy would add the values of a single motion in pairs, so that the last bit would depend on the
    number of motions.
    """
    return np.asarray(np.cumsum(values, axis=0)[-1] / len(values))


def statistics_of(singles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return means, errors and standard deviations, each (n, m), of `singles` (n, m, periods)."""
    moments = np.empty((3, *singles.shape[:2]))
    for i, motion in enumerate(singles):
        for j, values in enumerate(motion):
            # A separate array, because NumPy's order of addition depends on the memory layout.
            own = np.ascontiguousarray(values)
            moments[:, i, j] = own.mean(), error_of_mean(own[None]), own.std()
    means, errors, deviations = moments
    return means, errors, deviations


def error_of_mean(values: np.ndarray) -> float:
    """Return the error of the mean of `values` (paths, periods), which are correlated along a path.

    It has the confidence of three standard deviations, and follows from the means of batches of
    consecutive periods, with Student's distribution for their number. It is the largest of the
    errors for several batch lengths, because no length is known to be sufficient. It is infinite if
    there are too few batches.
    """
    paths, periods = values.shape
    errors = [
        _error_by_batches(values, periods // length)
        for length in _BATCH_LENGTHS
        if paths * (periods // length) >= _FEWEST_BATCHES
    ]
    return max(errors, default=math.inf)


def _error_by_batches(values: np.ndarray, batches: int) -> float:
    """Return the error from this many batches per path, whose lengths differ by up to a period."""
    from scipy.special import ndtr, stdtrit  # the import takes 0.1 s, and few points need it

    parts = np.array_split(values, batches, axis=1)
    lengths = np.array([part.shape[1] for part in parts])
    # (batches, paths)
    means = np.array([np.ascontiguousarray(part).mean(axis=1) for part in parts])
    away = np.ascontiguousarray(lengths[:, None] * (means - values.mean()) ** 2).sum()
    freedom = means.size - 1
    # The weights are there because the variance of a mean over `length` periods goes as 1/length.
    variance = float(away) / freedom / values.size
    return math.sqrt(variance) * float(stdtrit(freedom, ndtr(_SIGMAS)))
