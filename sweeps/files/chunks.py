"""Chunks of a large result: ranges of points that are boxes of its array."""

from __future__ import annotations

import math

import numpy as np

# A megabyte of each variable: the unit that is read, filled, compressed and written.
CHUNK_POINTS = 131_072


class Chunks:
    """Cuts the points 0 ... size - 1 of a grid into chunks, numbered in order.

    A chunk is both a contiguous range of points and a box of the array, so that a file can be
    written and read chunk by chunk, with memory for only one.
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
