"""Points that lie on no grid, and of which more may come while the first are computed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import Parameters

Indices = NDArray[np.int64]

# Fewer points do not keep the lanes of a kernel busy; of more the last would come back late.
_FEWEST, _MOST = 64, 1024


class Listed:
    """A list of points that grows; of a grid it has what tasks are made of, of `Blocks` the rest.

    The next block is cut of those that wait, a share for each of so many `slots`.
    """

    followed: ClassVar[None] = None

    def __init__(self, slots: int) -> None:
        self._points = np.empty((0, len(Parameters._fields)))
        self._slots, self._begun = slots, 0

    def __len__(self) -> int:
        return len(self._points)

    def add(self, points: NDArray[np.float64]) -> None:
        """Add points (n, parameters), whose numbers follow those of the others."""
        self._points = np.concatenate([self._points, points])

    def rows(self, indices: Indices) -> NDArray[np.float64]:
        """Return the parameters (n, parameters) of points by their numbers (n,)."""
        return self._points[indices]

    def __iter__(self) -> Iterator[Indices]:
        return self

    def __next__(self) -> Indices:
        """Return the numbers of the next block; raises StopIteration while no points wait."""
        first, waiting = self._begun, len(self) - self._begun
        if not waiting:
            raise StopIteration
        share = min(max(-(-waiting // self._slots), _FEWEST), _MOST)
        self._begun = min(first + share, len(self))
        return np.arange(first, self._begun)

    def learn(self, points: int, seconds: float) -> None:
        """Nothing: the size of a block does not depend on what others cost."""
