"""The grid of a sweep: points with numbers, and the parameters of each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import Parameters
from sweeps.config.load import Config

CASE, DIRECTION = "case", "direction"

QUANTILE = "quantile"
"""The dimension of quantiles over the cases of a result."""

DIRECTIONS = ("up", "down")
"""The two directions along a followed axis, in the order of computation."""


@dataclass(frozen=True, eq=False)
class Grid:
    """The product of the swept axes and, as the last dimension, the cases, in C order.

    The result has the dimensions `dims` and the `shape`. Each parameter is either in `coords`, with
    its dimension and values, or in `fixed`. A grid with cases also has the coordinate `case`. If an
    axis is `followed`, upward and downward, `direction` is the last dimension.
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
        """The number of points, 1 if nothing varies."""
        return math.prod(self.shape)

    def points(self, start: int, stop: int) -> NDArray[np.float64]:
        """Return the parameters of the points from `start` up to `stop`, exclusive, as `rows` does.

        Raises IndexError if the range is not within the grid.
        """
        if not 0 <= start <= stop <= self.size:
            raise IndexError(f"points {start} to {stop} are not within a grid of {self.size}")
        return self.rows(np.arange(start, stop, dtype=np.int64))

    def rows(self, indices: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the parameters of the points with these numbers, (n, parameters), in SI units.

        The columns follow `Parameters._fields`. Time and memory depend on the number of these
        points, not on the size of the grid.
        """
        # NumPy finds no positions in an array without dimensions.
        positions = np.unravel_index(indices, self.shape) if self.dims else ()
        along = dict(zip(self.dims, positions, strict=True))
        rows = np.empty((len(indices), len(Parameters._fields)))
        rows[:] = [self.fixed.get(name, np.nan) for name in Parameters._fields]
        for column, name in enumerate(Parameters._fields):
            if name not in self.fixed:
                (dim,), values = self.coords[name]
                rows[:, column] = values[along[dim]]
        return rows

    def values(self, name: str) -> NDArray[np.float64]:
        """Return the distinct values of a parameter over the grid, in increasing order."""
        return np.unique(self.fixed[name] if name in self.fixed else self.coords[name][1])

    def lines(self) -> NDArray[np.int64]:
        """Return the numbers of the points along each line, (lines, points): up, then down."""
        axis = self.dims.index(str(self.followed))
        numbers = np.moveaxis(np.arange(self.size).reshape(self.shape), axis, -2)
        numbers = numbers.reshape(-1, self.shape[axis], len(DIRECTIONS))
        return np.concatenate([numbers[:, :, 0], numbers[:, ::-1, 1]], axis=1)


def _frozen(values: object, dtype: type[np.generic]) -> NDArray[np.generic]:
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array
