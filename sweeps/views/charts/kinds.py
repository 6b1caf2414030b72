"""The kinds of charts: cells, curves, points; and which point is meant by a place in one.

All numbers are in shown units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from sweeps.figures.colours import Colours
from sweeps.figures.curves import Curve
from sweeps.figures.labels import Array
from sweeps.figures.layout import Axis
from sweeps.figures.maps import STRIP, cell_edges
from sweeps.grid import CASE

Place: TypeAlias = dict[str, int]

_FINEST = 800  # pixels of a map whose cells are not all of one size


@dataclass(frozen=True)
class Cells:
    """A map: a cell for each point of two axes."""

    across: Axis
    up: Axis
    colours: Colours
    values: Array
    places: Place

    def place_at(self, x: float, y: float) -> Place | None:
        """Return the place of the point whose cell is there."""
        place = dict(self.places)
        for axis, value in ((self.across, x), (self.up, y)):
            index = int(np.searchsorted(cell_edges(axis), value)) - 1
            if not 0 <= index < len(axis.order):
                return None
            if axis.dim != STRIP:
                place[axis.dim] = int(axis.order[index])
        return place

    def neighbour(self, place: Place, right: int, up: int) -> Place:
        """Return the place so many cells to the right of another one, and up."""
        steps = ((self.across, right), (self.up, up))
        return place | {a.dim: _along(a, place, step) for a, step in steps if a.dim != STRIP}

    def image(self) -> Array:
        """Return the values (up, across) on pixels of one size on the scales of the axes."""
        rows, columns = (cells_of_pixels(axis) for axis in (self.up, self.across))
        values = np.ma.filled(self.values.astype(np.float32), np.nan)
        return np.asarray(values[np.ix_(rows, columns)])


@dataclass(frozen=True)
class Curves:
    """Curves over one axis; `ends` are those of the axis that goes up."""

    across: Axis
    label: str
    curves: tuple[Curve, ...]
    ends: tuple[float, float]
    log: bool

    def place_at(self, x: float, y: float) -> Place | None:
        """Return the place of the point of the nearest curve at the nearest value of the axis."""
        index = _nearest(self.across, x)
        heights = np.array([curve.values[index] for curve in self.curves])
        distances = np.abs(np.nan_to_num(heights, nan=np.inf) - y)
        if not np.isfinite(distances).any():
            return None
        curve = self.curves[int(np.argmin(distances))]
        return curve.places | {self.across.dim: int(self.across.order[index])}

    def neighbour(self, place: Place, right: int, up: int) -> Place:
        """Return the place so many points to the right, on the curve that is so many higher."""
        place = place | {self.across.dim: _along(self.across, place, right)}
        index = self.across.order.tolist().index(place[self.across.dim])
        places = [c.places for c in sorted(self.curves, key=lambda c: _height(c.values[index]))]
        own = next((n for n, p in enumerate(places) if p.items() <= place.items()), 0)
        return place | places[min(max(own + up, 0), len(places) - 1)]


@dataclass(frozen=True)
class Cloud:
    """Linked cases in no order: points over two parameters, or over one and a variable.

    `ends` are those of the axis of a variable, on which what is drawn may change.
    """

    names: tuple[str, str]
    x: Array
    y: Array
    labels: tuple[str, str]
    log: tuple[bool, bool]
    ends: tuple[float, float] | None
    colours: Colours | None
    values: Array
    places: Place

    def place_at(self, x: float, y: float) -> Place | None:
        """Return the place of the nearest point, as it is seen: both ranges are of one length."""
        across = _distances(self.x, x, log=self.log[0])
        up = _distances(self.y, y, log=self.log[1])
        distances = np.nan_to_num(np.hypot(across, up), nan=np.inf)
        return {**self.places, CASE: int(np.argmin(distances))}

    def neighbour(self, place: Place, right: int, up: int) -> Place:
        """Return the place of the point that comes next to the right, or next higher."""
        order = np.argsort(self.y if up else self.x, kind="stable").tolist()
        own = order.index(place[CASE]) + (up or right)
        return place | {CASE: order[min(max(own, 0), len(order) - 1)]}


Chart: TypeAlias = Cells | Curves | Cloud


def ends_of(axis: Axis) -> tuple[float, float]:
    """Return the outer borders of the first and the last point of an axis."""
    edges = cell_edges(axis)
    return float(edges[0]), float(edges[-1])


def cells_of_pixels(axis: Axis) -> Array:
    """Return the cell of each pixel, of pixels that are evenly spread on the axis's scale."""
    edges = np.log(cell_edges(axis)) if axis.geometric else cell_edges(axis)
    widths = np.diff(edges)
    if np.allclose(widths, widths[0], rtol=1e-6, atol=0.0):
        return np.arange(len(widths))
    count = max(_FINEST, len(widths))
    middles = edges[0] + (np.arange(count) + 0.5) * (edges[-1] - edges[0]) / count
    return np.asarray(np.clip(np.searchsorted(edges, middles) - 1, 0, len(widths) - 1))


def _nearest(axis: Axis, value: float) -> int:
    """Return the place on an axis that is nearest to a value, on its own scale."""
    return int(np.clip(np.searchsorted(axis.middles, value), 0, len(axis.order) - 1))


def _along(axis: Axis, place: Place, step: int) -> int:
    """Return the place along an axis that is so many steps on, at most at its end."""
    order = axis.order.tolist()
    return int(order[min(max(order.index(place[axis.dim]) + step, 0), len(order) - 1)])


def _height(value: float) -> float:
    return value if math.isfinite(value) else -math.inf


def _distances(values: Array, value: float, *, log: bool) -> Array:
    """Return how far values are from one, as parts of their range."""
    if log:
        values, value = np.log(values), math.log(value)
    span = np.nanmax(values) - np.nanmin(values)
    return np.asarray((values - value) / (span or 1.0))
