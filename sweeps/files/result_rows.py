"""Result rows, the counts of their statuses, and the chunks in which files hold them.

A result row has a float64 number for each column of `RESULT_COLUMNS`; a row of NaN is a point that
was not computed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

Rows = NDArray[np.float64]

STATUS = RESULT_COLUMNS.index("status")
STATUS_CODES = int(Status.PENDING) + 1  # counts have a place for every code, used or not

# A megabyte of each variable: the unit of reading, filling, compressing and writing.
CHUNK_POINTS = 131_072


def status_counts(codes: NDArray[np.generic]) -> NDArray[np.int64]:
    """Return the number of points of each status (STATUS_CODES,); `codes` has any shape."""
    return np.bincount(np.asarray(codes).ravel().astype(np.int64), minlength=STATUS_CODES)


def failures(statuses: NDArray[np.int64]) -> int:
    """Return the number of finished points without a result, from the count of each status."""
    others = [Status.PENDING, *(status for status in Status if status.is_result)]
    return int(statuses.sum() - statuses[others].sum())


def tally(statuses: NDArray[np.int64]) -> dict[str, Any]:
    """Return the counts of `statuses` (128,) by name, and their sums."""
    named = {s.name.lower(): int(statuses[s]) for s in Status if statuses[s]}
    pending, points = named.pop("pending", 0), int(statuses.sum())
    return {
        "points": points,
        "done": points - pending,
        "failed": failures(statuses),
        "pending": pending,
        "statuses": named,
    }


class Memory:
    """Keeps the finished points of a grid of `size` points in an array."""

    def __init__(self, size: int) -> None:
        self._rows = np.full((size, len(RESULT_COLUMNS)), np.nan)
        self.done = np.zeros(size, dtype=bool)
        self.statuses = np.zeros(STATUS_CODES, dtype=np.int64)

    def append(self, indices: NDArray[np.int64], rows: Rows) -> None:
        """Keep points: their numbers (n,) and result rows (n, columns); known points stay."""
        fresh = ~self.done[indices]
        indices, rows = indices[fresh], rows[fresh]
        self._rows[indices], self.done[indices] = rows, True
        self.statuses += status_counts(rows[:, STATUS])

    def rows(self) -> Rows:
        """Return the result rows (size, columns) of all points, NaN for missing points."""
        return self._rows


class Chunks:
    """Cuts the points 0 ... size - 1 of a grid into chunks, numbered in order.

    A chunk is both a contiguous range of points and a box of the array, so a file can be written
    and read with only one chunk in memory.
    """

    def __init__(self, shape: tuple[int, ...], most: int = CHUNK_POINTS) -> None:
        self._shape = shape
        self.size = math.prod(shape)
        inner, split = 1, max(len(shape) - 1, 0)
        while split > 0 and inner * shape[split] <= most:
            inner *= shape[split]
            split -= 1
        self._inner = inner
        self._length = shape[split] if shape else 1
        self._thickness = min(self._length, max(1, most // inner))
        self._per_length = -(-self._length // self._thickness)
        self._outer = math.prod(shape[:split])
        whole = (1,) * split + (self._thickness, *shape[split + 1 :])
        # The shape of a whole chunk; those at the end of an axis may be smaller.
        self.extent = whole[: len(shape)]

    def __len__(self) -> int:
        return self._outer * self._per_length

    def range(self, number: int) -> tuple[int, int]:
        """Return the first point of a chunk, and the one after its last."""
        outer, part = divmod(number, self._per_length)
        begin = part * self._thickness
        end = min(begin + self._thickness, self._length)
        offset = outer * self._length
        return (offset + begin) * self._inner, (offset + end) * self._inner

    def box(self, number: int) -> tuple[slice, ...]:
        """Return the chunk as an index into the array."""
        first = np.unravel_index(self.range(number)[0], self._shape)
        along = zip(map(int, first), self.extent, self._shape, strict=True)
        return tuple(slice(begin, min(begin + most, end)) for begin, most, end in along)

    def shape(self, number: int) -> tuple[int, ...]:
        """Return the shape of this chunk."""
        return tuple(part.stop - part.start for part in self.box(number))
