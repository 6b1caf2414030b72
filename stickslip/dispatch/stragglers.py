"""Points that take far longer than most, gathered until they fill the lanes of a kernel.

A lane that goes on alone costs as much as all of them together, and an orbit that never closes
takes thousands of times what others do: one in each block would cost most of a sweep. Of late
points, too, only one in ten never closes: the more of them go together, the fuller are the lanes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.simd import LANES
from stickslip.dispatch.blocks import Costs
from stickslip.measure.results import STATUS
from stickslip.status import Status

_PATIENCE = 64  # drive periods; of a hundred points less than one needs more

# As many late points go together as take so long, since whoever stops a sweep waits for them: but
# enough that those among them which never close fill most lanes, and not more than fill all.
_SECONDS = 10.0
_FEWEST, _MOST = 256, 1024
_LEAST_SHARE = 4 * LANES

# Where a larger part of the points is late than this, blocks are full of such points anyway.
_SELDOM = 0.125
_FEW = 64  # points, before that can be told


class Stragglers:
    """The late points of a sweep: taken out of finished blocks, and given again together.

    `most` points at a time, where that is given; none are `ever` late where points of a line need
    each other.
    """

    def __init__(self, most: int | None = None, *, ever: bool = True) -> None:
        self._ever, self._most = ever, min(most or _MOST, _MOST)
        self._costs = Costs()
        self._waiting: list[int] = []
        self._tried, self._late = 0, 0

    @property
    def patience(self) -> int:
        """The drive periods that points of a block may take; 0 for as long as it takes."""
        seldom = self._late <= _FEW + _SELDOM * self._tried
        return _PATIENCE if seldom and self._ever else 0

    def finished(self, indices: NDArray[np.int64], rows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which points (n,) of a block, with rows (n, columns), are not late."""
        late = rows[:, STATUS] == Status.PENDING
        self._tried += len(late)
        self._late += int(np.count_nonzero(late))
        self._waiting += indices[late].tolist()
        return np.asarray(~late)

    def learn(self, points: int, seconds: float) -> None:
        """Take in what late points that were computed together have cost."""
        self._costs.learn(points, seconds)

    def together(self) -> NDArray[np.int64] | None:
        """Return points to compute together, as long as it takes; None while they are too few."""
        enough = min(max(self._costs.points_in(_SECONDS), _FEWEST), self._most)
        return self._taken(enough) if len(self._waiting) >= enough else None

    def rest(self, slots: int) -> list[NDArray[np.int64]]:
        """Share out all that wait among so many slots, where no others can come.

        As many as keep the lanes of a kernel busy: of two that do not, each takes as long as both.
        """
        shares = min(max(slots, 1), max(len(self._waiting) // _LEAST_SHARE, 1))
        share = max(1, min(self._most, -(-len(self._waiting) // shares)))
        return [self._taken(share) for _ in range(0, len(self._waiting), share)]

    def _taken(self, count: int) -> NDArray[np.int64]:
        taken, self._waiting = self._waiting[:count], self._waiting[count:]
        return np.sort(np.array(taken, dtype=np.int64))
