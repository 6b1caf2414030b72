"""Parts of a sweep, for the jobs of an array: each computes its points and leaves the others."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sweeps.grid import Grid

_PART = re.compile(r"(\d+)/(\d+)")
_MOST = 1_000_000


@dataclass(frozen=True)
class Part:
    """Part `number` of `of`, counted from 1: every `of`-th point, or line of a followed axis."""

    number: int
    of: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the part of a text such as `2/16`; raises ValueError."""
        found = _PART.fullmatch(text.strip())
        part = cls(int(found[1]), int(found[2])) if found else None
        if part is None or not 1 <= part.number <= part.of <= _MOST:
            raise ValueError(f"{text!r} is no part; write for example 1/16 to 16/16")
        return part

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    @property
    def suffix(self) -> str:
        """The part as a suffix of a file name."""
        return f"part-{self.number}-of-{self.of}"

    def points(self, grid: Grid) -> NDArray[np.bool_]:
        """Return which points of a grid (grid.size,) belong to it.

        The points of a followed line need each other and stay together.
        """
        if not grid.followed:
            return np.asarray(np.arange(grid.size) % self.of == self.number - 1)
        chosen = np.zeros(grid.size, dtype=bool)
        chosen[grid.lines()[self.number - 1 :: self.of]] = True
        return chosen
