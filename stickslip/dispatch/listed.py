"""Points that lie on no grid; more may be added while the first are computed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import Parameters

Indices = NDArray[np.int64]

# Fewer points do not keep the lanes of a kernel busy; with more, the last would come back late.
_FEWEST, _MOST = 64, 1024


class Listed:
    """A list of points that grows, with the interface of `Blocks`.

    The points that are not finished are shared out among the `slots`; a block is one such share.
    """

    line: ClassVar[int] = 1
    defers: ClassVar[bool] = True

    def __init__(self, slots: int) -> None:
        self._points = np.empty((0, len(Parameters._fields)))
        self._slots, self._begun, self._finished = slots, 0, 0

    def __len__(self) -> int:
        return len(self._points)

    def add(self, points: NDArray[np.float64]) -> None:
        """Add points (n, parameters), which are numbered on from the last one."""
        self._points = np.concatenate([self._points, points])

    def rows(self, indices: Indices) -> NDArray[np.float64]:
        """Return the parameters (n, parameters) of points by their numbers (n,)."""
        return self._points[indices]

    def __iter__(self) -> Iterator[Indices]:
        return self

    def __next__(self) -> Indices:
        """Return the numbers of the next block; raises StopIteration while no points wait."""
        first = self._begun
        if first == len(self):
            raise StopIteration
        fair = -(-(len(self) - self._finished) // self._slots)
        share = min(max(fair, _FEWEST), _MOST)
        self._begun = min(first + share, len(self))
        return np.arange(first, self._begun)

    def learn(self, points: int, seconds: float) -> None:  # noqa: ARG002 - of Blocks
        """Take note of a block that has come back."""
        self._finished += points
