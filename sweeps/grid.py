"""The numbered points of a sweep: every index stands for a row of parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import Parameters
from sweeps.config.load import Config

_PIECE = 1 << 16  # values of a list that are looked at together

CASE, DIRECTION = "case", "direction"

DIRECTIONS = ("up", "down")
"""The two directions along a followed axis, in the order in which they are computed."""


@dataclass(frozen=True, eq=False)
class Grid:
    """The product of the swept axes and, last, the cases; points are numbered in C order.

    `dims` and `shape` are those of the result. Each parameter is either in `coords`, with its
    dimensions and values, or in `fixed`; with cases there is a further coordinate `case`. If an
    axis is `followed`, upward and downward, `direction` is one more dimension, the last.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coords: Mapping[str, tuple[tuple[str, ...], NDArray[np.generic]]]
    fixed: Mapping[str, float]
    followed: str | None = None

    @classmethod
    def from_config(cls, config: Config) -> Self:
        """Return the grid of a config."""
        lengths = {name: len(values) for name, values in config.sweep.items()}
        coords = {name: ((name,), _frozen(v, np.float64)) for name, v in config.sweep.items()}
        if config.cases:
            count = len(next(iter(config.cases.values())))
            lengths[CASE] = count
            coords[CASE] = ((CASE,), _frozen(range(count), np.int32))
            for name, values in config.cases.items():
                coords[name] = ((CASE,), _frozen(values, np.float64))
        if config.follow:
            lengths[DIRECTION] = len(DIRECTIONS)
            coords[DIRECTION] = ((DIRECTION,), _frozen(DIRECTIONS, np.str_))
        fixed = config.parameters()._asdict()
        return cls(
            dims=tuple(lengths),
            shape=tuple(lengths.values()),
            coords=MappingProxyType(coords),
            fixed=MappingProxyType({n: v for n, v in fixed.items() if n not in coords}),
            followed=config.follow,
        )

    @property
    def size(self) -> int:
        """Number of points; 1 if nothing varies."""
        return math.prod(self.shape)

    def points(self, start: int, stop: int) -> NDArray[np.float64]:
        """Return the parameters of the points from `start` to before `stop`, as `rows` does.

        Raises IndexError if `start` and `stop` are not a range within the grid.
        """
        if not 0 <= start <= stop <= self.size:
            raise IndexError(f"points {start} to {stop} are not within a grid of {self.size}")
        return self.rows(np.arange(start, stop, dtype=np.int64))

    def rows(self, indices: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the parameters of the points with these numbers, (n, parameters), in SI units.

        The columns are those of `Parameters._fields`. Time and memory are those for these points,
        whatever the size of the grid.
        """
        # NumPy has no positions in an array without dimensions.
        positions = np.unravel_index(indices, self.shape) if self.dims else ()
        along = dict(zip(self.dims, positions, strict=True))
        rows = np.empty((len(indices), len(Parameters._fields)))
        for column, name in enumerate(Parameters._fields):
            if name in self.fixed:
                rows[:, column] = self.fixed[name]
            else:
                (dim,), values = self.coords[name]
                rows[:, column] = values[along[dim]]
        return rows

    def values(self, name: str) -> NDArray[np.float64]:
        """Return the distinct values of a parameter over the grid, in increasing order."""
        return np.unique(self.fixed[name] if name in self.fixed else self.coords[name][1])

    def locate(self, rows: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the numbers of the points with these parameters, -1 if the grid has no such point.

        Points are the same if all parameters are equal as floats, whichever of them are swept,
        linked or fixed, here or in the grid that the rows come from.
        """
        columns = dict(zip(Parameters._fields, np.asarray(rows).T, strict=True))
        found = np.ones(len(rows), dtype=bool)
        for name, value in self.fixed.items():
            found &= columns[name] == value
        numbers = np.zeros(len(rows), dtype=np.int64)
        for dim, length in zip(self.dims, self.shape, strict=True):
            if (
                dim == DIRECTION
            ):  # both directions have the same parameters: return the upward point
                numbers *= length
                continue
            tied = [name for name in columns if name in self.coords and dim in self.coords[name][0]]
            position = _position([(self.coords[name][1], columns[name]) for name in tied])
            found &= position >= 0
            numbers = numbers * length + position
        return np.where(found, numbers, -1)

    def counterparts(self, indices: NDArray[np.int64], other: Self) -> NDArray[np.int64]:
        """Return the numbers of points of this grid in another, -1 where it has no such point."""
        found = other.locate(self.rows(indices))
        if self.followed != other.followed:
            return np.full_like(found, -1)
        ways = len(DIRECTIONS) if self.followed else 1
        return np.where(found < 0, -1, found + indices % ways)

    def lines(self) -> NDArray[np.int64]:
        """Return the lines of successive points, (lines, points): up, then down again."""
        axis = self.dims.index(str(self.followed))
        numbers = np.moveaxis(np.arange(self.size).reshape(self.shape), axis, -2)
        numbers = numbers.reshape(-1, self.shape[axis], len(DIRECTIONS))
        return np.concatenate([numbers[:, :, 0], numbers[:, ::-1, 1]], axis=1)


def _position(pairs: list[tuple[NDArray[Any], NDArray[np.float64]]]) -> NDArray[np.int64]:
    """Return the index at which all lists have the wanted values, else -1; pairs (list, wanted)."""
    wanted = len(pairs[0][1])
    likely = np.flatnonzero(_occur(*pairs[0]))
    for values, sought in pairs[1:]:
        likely = likely[_occur(values[likely], sought)]
    codes = np.zeros(len(likely) + wanted, dtype=np.int64)
    for values, sought in pairs:
        distinct, ranks = np.unique(np.concatenate([values[likely], sought]), return_inverse=True)
        # Renumbered after each list, so that many long lists do not overflow an integer.
        _, codes = np.unique(codes * len(distinct) + ranks, return_inverse=True)
    position = np.full(len(codes), -1)
    position[codes[: len(likely)]] = likely
    return position[codes[len(likely) :]]


def _occur(values: NDArray[Any], sought: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which of a list (n,) are among the values sought.

    A list may have as many values as the grid has points, and to sort it would copy it several
    times: it is looked through in pieces, which takes a byte for each value.
    """
    known, found = np.unique(sought), np.zeros(len(values), dtype=bool)
    if len(known):
        for begin in range(0, len(values), _PIECE):
            piece = values[begin : begin + _PIECE]
            places = np.searchsorted(known, piece).clip(max=len(known) - 1)
            found[begin : begin + _PIECE] = known[places] == piece
    return found


def _frozen(values: object, dtype: type[np.generic]) -> NDArray[np.generic]:
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array
