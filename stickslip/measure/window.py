"""Statistics of single drive periods: of orbits that close after several, or never."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FIRST_PHASE,
    FIRST_SOLID,
    FORCE_MAX,
    FORCE_MIN,
    LAST_PHASE,
    LAST_SOLID,
    MELTED,
    MELTINGS,
    PHI_MAX,
    RECORD,
    SOFT,
    SOLID,
    SOLID_CHANGES,
    SOLID_TIME,
    STRESS_MAX,
    STRESS_MIN,
    UNSEEN,
    UNSEEN_TIME,
)

# Batches of periods, long enough to be independent and enough of them for a deviation.
_BATCHES = 20

_HIGHEST, _LOWEST = [STRESS_MAX, FORCE_MAX, PHI_MAX], [STRESS_MIN, FORCE_MIN]
_SUMS = [BLOCK_WORK, ABSOLUTE_WORK, MELTINGS, SOLID_TIME, UNSEEN_TIME, SOLID_CHANGES]


def amplitudes_of(records: np.ndarray) -> np.ndarray:
    """Amplitudes (n, 2) of stress and force in records (n, RECORD), in their units."""
    return 0.5 * (records[:, [STRESS_MAX, FORCE_MAX]] - records[:, [STRESS_MIN, FORCE_MIN]])


class Window:
    """Consecutive drive periods of n motions, taken in one after the other.

    `record` (n, RECORD) is that of all periods so far, in SI units.
    """

    def __init__(self, count: int) -> None:
        self.record = np.zeros((count, RECORD))
        self.record[:, [STRESS_MAX, FORCE_MAX]] = -math.inf
        self.record[:, [STRESS_MIN, FORCE_MIN]] = math.inf
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


def ensemble_standard_error(values: np.ndarray) -> float:
    """Standard error of the mean of `values` (realizations, periods), correlated along a path.

    By the means of realizations, or of batches of theirs where there are few.
    """
    paths, periods = values.shape
    batches = min(-(-_BATCHES // paths), periods)
    length = periods // batches
    used = values[:, periods - batches * length :]
    means = np.ascontiguousarray(used).reshape(paths * batches, length).mean(axis=1)
    return float(means.std(ddof=1) / math.sqrt(len(means))) if len(means) > 1 else math.inf


def standard_errors(values: np.ndarray) -> np.ndarray:
    """Standard errors of the means over the first axis, whose entries may be correlated.

    By the means of batches. `values` (periods, ...); (...), infinite for fewer than two periods.
    """
    if len(values) < 2:
        return np.full(values.shape[1:], math.inf)
    batches = min(_BATCHES, len(values))
    length = len(values) // batches
    used = values[len(values) - batches * length :]
    means = used.reshape(batches, length, *values.shape[1:]).mean(axis=1)
    return np.asarray(means.std(axis=0, ddof=1) / math.sqrt(batches))
