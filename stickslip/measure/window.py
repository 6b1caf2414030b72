"""Statistics of single drive periods, for orbits that close after several of them, or never."""

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

# Periods per batch: longer batches are more nearly independent, but there are fewer of them. With
# fewer than this number the deviation is unknown.
_BATCH_LENGTHS = (5, 10, 20)
_FEWEST_BATCHES = 4

# Number of standard deviations taken as the error of a mean.
_SIGMAS = 3.0

_HIGHEST, _LOWEST = list(slots_of(HIGHEST, LARGEST)), list(slots_of(LOWEST))
_SUMS = list(slots_of(SUM))


def amplitudes_of(records: np.ndarray) -> np.ndarray:
    """Return the amplitudes (n, 2) of stress and force in records (n, RECORD), in their units."""
    return 0.5 * (records[:, [STRESS_MAX, FORCE_MAX]] - records[:, [STRESS_MIN, FORCE_MIN]])


def integrals_of(records: np.ndarray) -> np.ndarray:
    """Return the INTEGRALS (n, 3) of stretches of motion, with all the work of the drive."""
    integrals = records[:, list(INTEGRALS)]
    integrals[:, INTEGRALS.index(LOSS)] += records[:, BLOCK_WORK]
    return np.asarray(integrals)


class Window:
    """Consecutive drive periods of n motions, added one after another.

    `record` (n, RECORD) is that of all periods so far, in SI units.
    """

    def __init__(self, count: int) -> None:
        self.record = np.zeros((count, RECORD))
        self.record[:, list(slots_of(HIGHEST))] = -math.inf
        self.record[:, _LOWEST] = math.inf
        self._amplitudes: list[np.ndarray] = []
        self._integrals: list[np.ndarray] = []

    def add(self, records: np.ndarray) -> None:
        """Add a period of each motion: `records` (n, RECORD) of stretches, in SI units."""
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

    @property
    def integrals(self) -> np.ndarray:
        """The INTEGRALS of single periods as of `integrals_of`, (periods, n, 3)."""
        return np.array(self._integrals)


def mean_in_order(values: Sequence[np.ndarray]) -> np.ndarray:
    """Return the mean (n,) of values (n,), added one after another.

    NumPy adds those of a single motion in pairs, so its last bit would depend on its company.
    """
    return np.asarray(np.cumsum(values, axis=0)[-1] / len(values))


def statistics_of(singles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return means, errors and standard deviations, each (n, m), of `singles` (n, m, periods)."""
    moments = np.empty((3, *singles.shape[:2]))
    for i, motion in enumerate(singles):
        for j, values in enumerate(motion):
            # NumPy's order of addition depends on the memory layout: each motion has its own array.
            own = np.ascontiguousarray(values)
            moments[:, i, j] = own.mean(), error_of_mean(own[None]), own.std()
    means, errors, deviations = moments
    return means, errors, deviations


def error_of_mean(values: np.ndarray) -> float:
    """Return the error of the mean of `values` (paths, periods), which are correlated along a path.

    At the confidence of three standard deviations, from the means of batches of consecutive
    periods, with Student's distribution for their number. Batches of several lengths are tried and
    the largest error is taken, since none is known to be long enough. Infinite if there are too few
    batches.
    """
    paths, periods = values.shape
    errors = [
        _error_by_batches(values, periods // length)
        for length in _BATCH_LENGTHS
        if paths * (periods // length) >= _FEWEST_BATCHES
    ]
    return max(errors, default=math.inf)


def _error_by_batches(values: np.ndarray, batches: int) -> float:
    """Return the same error from this many batches per path, whose lengths differ by a period."""
    from scipy.special import ndtr, stdtrit  # a tenth of a second, needed by few points

    parts = np.array_split(values, batches, axis=1)
    lengths = np.array([part.shape[1] for part in parts])
    means = np.array(
        [np.ascontiguousarray(part).mean(axis=1) for part in parts]
    )  # (batches, paths)
    away = np.ascontiguousarray(lengths[:, None] * (means - values.mean()) ** 2).sum()
    freedom = means.size - 1
    # The variance of a mean over `length` periods goes as 1/length, hence the weights.
    variance = float(away) / freedom / values.size
    return math.sqrt(variance) * float(stdtrit(freedom, ndtr(_SIGMAS)))
