"""An axis: the points of a dimension in order, their shown values, names, scale and cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from sweeps.charts.labels import Array, Quantity, legend_label, parameters_along, shown
from sweeps.charts.styles import CURVES
from sweeps.grid import CASE

MANY = len(CURVES)  # an axis is long when its points would need more curves than there are styles
NAMED = ("rheological_index", CASE)  # what has names rather than places on a scale, if it is short

STRIP = "strip"
"""The axis without extent of kinds along a single axis."""

_FINEST = 800  # pixels of a map whose cells are not all of one size


@dataclass(frozen=True)
class Axis:
    """A dimension as an axis: the order of its points, their shown values, names, and its scale.

    `names` are those of points that are no numbers, or too few to lie on a scale.
    """

    dim: str
    order: np.ndarray[tuple[int], np.dtype[np.int_]]
    quantity: Quantity
    label: str
    geometric: bool
    names: tuple[str, ...] = ()

    @property
    def middles(self) -> Array:
        """The middles between neighbours, on the axis's own scale."""
        below, above = self.quantity.values[:-1], self.quantity.values[1:]
        return np.sqrt(below * above) if self.geometric else (below + above) / 2

    @property
    def steps(self) -> Array:
        """The distances between neighbours, on the axis's own scale."""
        values = np.log(self.quantity.values) if self.geometric else self.quantity.values
        return np.diff(values)


def axis_of(ds: xr.Dataset, dim: str, *, log: bool = False, named: bool = False) -> Axis:
    """The axis of a dimension; linked cases lie along the first parameter that tells them apart.

    `log` asks for a logarithmic scale, and `named` for the names of the points of a short axis.
    """
    coordinate = coordinate_of(ds, dim)
    few = named and ds.sizes[dim] <= MANY
    if coordinate.dtype.kind not in "fiu" or (few and dim in NAMED):
        return _named_axis(ds, dim)
    order = np.argsort(shown(coordinate).values, kind="stable")
    quantity = shown(coordinate[order])
    if log and quantity.values[0] <= 0:
        raise ValueError(f"a logarithmic scale needs numbers above 0, {coordinate.name} has others")
    geometric = log or is_geometric(quantity.values)
    return Axis(dim, order, quantity, _axis_label(ds, coordinate), geometric)


def _named_axis(ds: xr.Dataset, dim: str) -> Axis:
    places = np.arange(ds.sizes[dim])
    labels = [legend_label(ds, dim, place) for place in range(places.size)]
    names = tuple(label.replace(", ", ",\n", 1) for label in labels)
    return Axis(dim, places, Quantity(places.astype(float), "", ""), "", False, names)


def coordinate_of(ds: xr.Dataset, dim: str) -> xr.DataArray:
    """Return the coordinate that tells the points of a dimension apart."""
    for name in parameters_along(ds, dim):
        if name == dim or np.unique(ds[name].values).size == ds.sizes[dim]:
            return ds[name]
    return ds[dim]


def _axis_label(ds: xr.Dataset, coordinate: xr.DataArray) -> str:
    label = shown(coordinate).label
    along = parameters_along(ds, str(coordinate.dims[0]))
    others = [shown(ds[name]).symbol for name in along if name != coordinate.name]
    return f"{label}, linked with {', '.join(others)}" if others else label


def is_geometric(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    """Tell whether sorted values have a common ratio, hence even steps on a log axis."""
    if values.size < 3 or values[0] <= 0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps.mean(), rtol=1e-6, atol=0))


def is_scattered(ds: xr.Dataset, dim: str) -> bool:
    """Tell whether linked cases are in order along none of their parameters."""
    steps = [np.diff(ds[name].values) for name in parameters_along(ds, dim)]
    return bool(steps) and not any((step > 0).all() or (step < 0).all() for step in steps)


def cell_edges(axis: Axis) -> Array:
    """The borders between the points of an axis, halfway on its own scale."""
    values, middles = axis.quantity.values, axis.middles
    if values.size == 1:
        middles = values + 0.5
    ends, inner = values[[0, -1]], middles[[0, -1]]
    first, last = ends**2 / inner if axis.geometric else 2 * ends - inner
    if values.size == 1:
        return np.array([first, middles[0]])
    return np.concatenate([[first], middles, [last]])


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
