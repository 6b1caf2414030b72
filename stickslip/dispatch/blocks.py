"""Blocks of points, their order, and their cost."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

_FIRST_BLOCK = 256  # points, while their cost is unknown
# Fewer points do not keep the lanes of a kernel busy; more take memory and gain nothing.
SMALLEST_BLOCK, _LARGEST_BLOCK = 64, 16_384

# A large grid is dealt in runs of neighbours, so that a block touches few slabs of the result.
_RUNS, _LONGEST_RUN = 16_384, 4096
_DEALT_AT_ONCE = 8192

_UNKNOWN = 0.25  # the uncertainty of a cost that is known from one block

PILOT_BLOCKS = 8
"""Blocks of a pilot: enough to show how much their costs differ."""


class Blocks:
    """Cuts the points that are not done into blocks of a few seconds, and learns their cost.

    The order is shuffled, in the same way for every grid of the same size. Any stretch of it is
    spread over the grid. Therefore blocks cost about the same, the remaining points cost as much as
    the finished ones, and no core is left with an expensive corner at the end. Neither order nor
    size ever changes a result, as every point is computed from its parameters alone.

    `done` (size,) marks points that need not be computed; it is not changed. `slots` blocks are
    computed at the same time. A block should take `seconds` on one core, unless `block_points`
    fixes its size. `defers` says whether late points may be computed later.
    """

    line: ClassVar[int] = 1
    """Each point is independent."""

    def __init__(
        self,
        done: NDArray[np.bool_],
        slots: int,
        *,
        seconds: float = 1.0,
        block_points: int | None = None,
        defers: bool = True,
    ) -> None:
        self._taken = done.copy()
        self.left = len(done) - int(np.count_nonzero(done))
        self._slots, self._seconds, self._fixed = slots, seconds, block_points
        self.defers = defers
        self._seconds_per_point: float | None = None

    def __iter__(self) -> Iterator[Indices]:
        dealt, waiting = _dealt(self._taken), np.empty(0, dtype=np.int64)
        while self.left:
            wanted = min(self._next_size(), self.left)
            while len(waiting) < wanted:
                waiting = np.concatenate([waiting, next(dealt)])
            block, waiting = np.sort(waiting[:wanted]), waiting[wanted:]
            self._taken[block] = True
            self.left -= len(block)
            yield block

    def learn(self, points: int, seconds: float) -> None:
        """Take note of the cost of a finished block."""
        cost, known = seconds / points, self._seconds_per_point
        self._seconds_per_point = cost if known is None else 0.5 * (known + cost)

    def _next_size(self) -> int:
        if self._fixed is not None:
            return self._fixed
        cost = self._seconds_per_point
        wanted = _FIRST_BLOCK if cost is None else int(self._seconds / max(cost, 1e-9))
        fair = self.left // (2 * self._slots)
        return max(SMALLEST_BLOCK, min(wanted, fair, _LARGEST_BLOCK))


@dataclass(frozen=True)
class Given:
    """Blocks that are already cut, of lines of `line` points."""

    blocks: Sequence[Indices]
    line: int = 1
    defers: ClassVar[bool] = False

    def __iter__(self) -> Iterator[Indices]:
        return iter(self.blocks)

    def learn(self, points: int, seconds: float) -> None:
        """Do nothing, as all blocks are cut."""


class Costs:
    """The cost of finished blocks, which predicts the cost of others.

    The cost of a point is a ratio of totals, which gives large and small, cheap and expensive
    blocks their proper weight. Blocks in flight do not enter: a rate over the time since the start
    would count them as idle time. The number of workers does not enter either.
    """

    def __init__(self) -> None:
        self.points, self.seconds = 0, 0.0
        self._each: list[float] = []  # seconds a point, of each block

    def learn(self, points: int, seconds: float) -> None:
        """Take note of a finished block, which took its worker so many seconds."""
        self.points += points
        self.seconds += seconds
        self._each.append(seconds / max(points, 1))

    def estimate(self, points: int, slots: int) -> float:
        """Estimate the seconds that `slots` workers need for `points`; 0 before the first block."""
        return self.seconds / max(self.points, 1) * points / slots

    @property
    def uncertainty(self) -> float:
        """The relative standard error of the cost of a point, from the scatter of the blocks."""
        count = len(self._each)
        if count < 2 or self.seconds == 0.0:
            return _UNKNOWN
        return float(np.std(self._each, ddof=1) / math.sqrt(count) / np.mean(self._each))

    def points_in(self, seconds: float) -> int:
        """Return how many points a worker computes in this time; 0 before the first block."""
        return int(seconds * self.points / max(self.seconds, 1e-9))


def pilot_points(left: int) -> int:
    """Return the size of a pilot block: as costly as other blocks, yet few of the `left` points."""
    return min(max(left // 64, _FIRST_BLOCK), 2048)


def pilot_blocks(done: NDArray[np.bool_], points: int) -> list[Indices]:
    """Return `PILOT_BLOCKS` blocks, a stratified random sample of the points that are not done.

    One point is drawn from each of many equal strata of the grid, and each block has points from
    all over the grid. The same grid gives the same sample.
    """
    size = len(done)
    strata = min(size, points * PILOT_BLOCKS)
    borders = np.arange(strata + 1, dtype=np.int64) * size // strata
    drawn = np.random.default_rng(size).integers(borders[:-1], borders[1:])
    blocks = (drawn[first::PILOT_BLOCKS] for first in range(PILOT_BLOCKS))
    return [block[~done[block]] for block in blocks if not done[block].all()]


def _dealt(taken: NDArray[np.bool_]) -> Iterator[Indices]:
    """Yield each point once, unless it is taken when its turn comes."""
    size = len(taken)
    run = min(max(size // _RUNS, 1), _LONGEST_RUN)
    runs = -(-size // run)
    at_once = max(_DEALT_AT_ONCE // run, 1)
    shuffled = np.random.default_rng(size).permutation(runs)
    for first in range(0, runs, at_once):
        turns = shuffled[first : first + at_once]
        points = (turns[:, None] * run + np.arange(run)).ravel()
        points = points[points < size]
        yield points[~taken[points]]
