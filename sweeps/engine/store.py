"""Stores of finished points: the journal of a sweep, or the memory of this process."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip.variables import RESULT_COLUMNS
from sweeps.files.columns import STATUS, STATUS_CODES, Rows, status_counts


class Store(Protocol):
    """Keeps finished points; a `sweeps.files.journal.Journal` does, and so does `Memory`.

    `done` (size,) tells which points it has and `statuses` (128,) how many of them have each
    status. Both are always those of what was appended so far.
    """

    done: NDArray[np.bool_]
    statuses: NDArray[np.int64]

    def append(self, indices: NDArray[np.int64], rows: Rows) -> None:
        """Keep points: their numbers (n,) and result rows (n, columns); what it has stays."""

    def rows(self) -> Rows:
        """Return the result rows (size, columns) of all points, NaN for those it does not have."""


class Memory:
    """Keeps the finished points of a grid of `size` points in an array."""

    def __init__(self, size: int) -> None:
        self._rows = np.full((size, len(RESULT_COLUMNS)), np.nan)
        self.done = np.zeros(size, dtype=bool)
        self.statuses = np.zeros(STATUS_CODES, dtype=np.int64)

    def append(self, indices: NDArray[np.int64], rows: Rows) -> None:
        """Keep points: their numbers (n,) and result rows (n, columns); what it has stays."""
        fresh = ~self.done[indices]
        indices, rows = indices[fresh], rows[fresh]
        self._rows[indices], self.done[indices] = rows, True
        self.statuses += status_counts(rows[:, STATUS])

    def rows(self) -> Rows:
        """Return the result rows (size, columns) of all points, NaN for those it does not have."""
        return self._rows
