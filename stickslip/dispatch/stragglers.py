"""Points that take far longer than most, gathered until they fill the lanes of a kernel.

One busy lane costs as much time as all lanes together, and an orbit that never closes takes
thousands of times as long as others. One such orbit in each block would cost most of a sweep. Even
among late points only one in ten never closes, so a larger group keeps the lanes fuller.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.simd import LANES
from stickslip.dispatch.blocks import Costs
from stickslip.measure.results import STATUS
from stickslip.status import Status

_PATIENCE = 64  # drive periods; fewer than one point in a hundred needs more

# A group of late points should take this long, since a user who stops the sweep waits for it. It
# must also be large enough for its endless orbits to fill most lanes, and no larger than it takes
# to fill all.
_SECONDS = 10.0
_FEWEST, _MOST = 256, 1024
_LEAST_SHARE = 4 * LANES

# If a larger part of the points is late, blocks are full of such points anyway.
_SELDOM = 0.125
_FEW = 64  # points; with fewer late ones the part is not known yet


class Stragglers:
    """The late points of a sweep, taken out of finished blocks to be computed together.

    A group has no more than `most` points. With `ever` false no point counts as late, as on lines,
    whose points need each other.
    """

    def __init__(self, most: int | None = None, *, ever: bool = True) -> None:
        self._ever, self._most = ever, min(most or _MOST, _MOST)
        self._costs = Costs()
        self._waiting: list[int] = []
        self._tried, self._late = 0, 0

    @property
    def patience(self) -> int:
        """The drive periods that points of a block may take; 0 means no limit."""
        seldom = self._late <= _FEW + _SELDOM * self._tried
        return _PATIENCE if seldom and self._ever else 0

    def finished(self, indices: NDArray[np.int64], rows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Keep the late points of a block with rows (n, columns); return which (n,) are in time."""
        late = rows[:, STATUS] == Status.PENDING
        self._tried += len(late)
        self._late += int(np.count_nonzero(late))
        self._waiting += indices[late].tolist()
        return np.asarray(~late)

    def learn(self, points: int, seconds: float) -> None:
        """Take note of the cost of a group of late points."""
        self._costs.learn(points, seconds)

    def together(self) -> NDArray[np.int64] | None:
        """Return a group of points to compute without a limit; None while there are too few."""
        enough = min(max(self._costs.points_in(_SECONDS), _FEWEST), self._most)
        return self._taken(enough) if len(self._waiting) >= enough else None

    def rest(self, slots: int) -> list[NDArray[np.int64]]:
        """Share out all waiting points among the slots, when no others can come.

        Each share keeps the lanes of a kernel busy: two smaller ones would each take as long as
        both together.
        """
        shares = min(max(slots, 1), max(len(self._waiting) // _LEAST_SHARE, 1))
        share = max(1, min(self._most, -(-len(self._waiting) // shares)))
        return [self._taken(share) for _ in range(0, len(self._waiting), share)]

    def _taken(self, count: int) -> NDArray[np.int64]:
        taken, self._waiting = self._waiting[:count], self._waiting[count:]
        return np.sort(np.array(taken, dtype=np.int64))
