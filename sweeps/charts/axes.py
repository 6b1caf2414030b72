"""Axes: the points of a dimension in order, and the roles of dimensions in a picture."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS, canonical_name
from sweeps.charts.choice import ROLES, Choice, named_roles
from sweeps.charts.colours import CURVES
from sweeps.charts.labels import Array, Quantity, legend_label, parameters_along, shown, slice_label
from sweeps.grid import CASE, DIRECTION

MANY = len(CURVES)  # an axis is long if its points would need more curves than there are styles
NAMED = ("rheological_index", CASE)  # short axes whose points have names, not places on a scale

STRIP = "strip"
"""The vertical axis, without extent, of kinds along a single axis."""

_FINEST = 800  # pixels of a map whose cells differ in size


@dataclass(frozen=True)
class Axis:
    """A dimension as an axis: the order of its points, their shown values, names, and its scale.

    Points have `names` if they are not numbers, or are too few to lie on a scale.
    """

    dim: str
    order: np.ndarray[tuple[int], np.dtype[np.int_]]
    quantity: Quantity
    label: str
    geometric: bool
    names: tuple[str, ...] = ()

    @property
    def middles(self) -> Array:
        """The midpoints between neighbours, on the scale of the axis."""
        below, above = self.quantity.values[:-1], self.quantity.values[1:]
        return np.sqrt(below * above) if self.geometric else (below + above) / 2

    @property
    def steps(self) -> Array:
        """The distances between neighbours, on the scale of the axis."""
        values = np.log(self.quantity.values) if self.geometric else self.quantity.values
        return np.diff(values)


def axis_of(ds: xr.Dataset, dim: str, *, log: bool = False, named: bool = False) -> Axis:
    """Return the axis of a dimension; cases lie along the first parameter that differs in each.

    `log` makes the scale logarithmic, and `named` names the points of a short axis.
    """
    coordinate = coordinate_of(ds, dim)
    few = named and ds.sizes[dim] <= MANY
    if coordinate.dtype.kind not in "fiu" or (few and dim in NAMED):
        places = np.arange(ds.sizes[dim])
        labels = [legend_label(ds, dim, place) for place in range(places.size)]
        names = tuple(label.replace(", ", ",\n", 1) for label in labels)
        return Axis(dim, places, Quantity(places.astype(float), "", ""), "", False, names)
    order = np.argsort(shown(coordinate).values, kind="stable")
    quantity = shown(coordinate[order])
    if log and quantity.values[0] <= 0:
        raise ValueError(f"a logarithmic scale needs numbers above 0; {coordinate.name} has others")
    label = shown(coordinate).label
    along = parameters_along(ds, str(coordinate.dims[0]))
    if others := [shown(ds[name]).symbol for name in along if name != coordinate.name]:
        label = f"{label}, linked with {', '.join(others)}"
    # A short range is even on both scales, and only the ticks of a linear one separate its points.
    geometric = is_geometric(quantity.values) and not is_even(quantity.values)
    return Axis(dim, order, quantity, label, log or geometric)


def coordinate_of(ds: xr.Dataset, dim: str) -> xr.DataArray:
    """Return the coordinate that has a different value at each point of a dimension."""
    for name in parameters_along(ds, dim):
        if name == dim or np.unique(ds[name].values).size == ds.sizes[dim]:
            return ds[name]
    return ds[dim]


def is_geometric(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    """Return True if sorted values have a common ratio, hence even steps on a log axis."""
    return values.size > 2 and bool(values[0] > 0) and is_even(np.log(values))


def is_even(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    """Return True if sorted values, at least three of them, have a common step."""
    steps = np.diff(values)
    return values.size > 2 and bool(np.allclose(steps, steps.mean(), rtol=1e-6, atol=0.0))


def is_scattered(ds: xr.Dataset, dim: str) -> bool:
    """Return True if linked cases are in order along none of their parameters."""
    steps = [np.diff(ds[name].values) for name in parameters_along(ds, dim)]
    return bool(steps) and not any((step > 0).all() or (step < 0).all() for step in steps)


def cell_edges(axis: Axis) -> Array:
    """Return the edges of the cells around the points of an axis, halfway on its scale."""
    values, middles = axis.quantity.values, axis.middles
    if values.size == 1:
        middles = values + 0.5
    ends, inner = values[[0, -1]], middles[[0, -1]]
    first, last = ends**2 / inner if axis.geometric else 2 * ends - inner
    if values.size == 1:
        return np.array([first, middles[0]])
    return np.concatenate([[first], middles, [last]])


def ends_of(axis: Axis) -> tuple[float, float]:
    """Return the outer edges of the first and the last cell of an axis."""
    edges = cell_edges(axis)
    return float(edges[0]), float(edges[-1])


def cells_of_pixels(axis: Axis) -> Array:
    """Return the cell that each pixel lies in, for pixels spread evenly over the scale."""
    edges = np.log(cell_edges(axis)) if axis.geometric else cell_edges(axis)
    widths = np.diff(edges)
    if np.allclose(widths, widths[0], rtol=1e-6, atol=0.0):
        return np.arange(len(widths))
    count = max(_FINEST, len(widths))
    middles = edges[0] + (np.arange(count) + 0.5) * (edges[-1] - edges[0]) / count
    return np.asarray(np.clip(np.searchsorted(edges, middles) - 1, 0, len(widths) - 1))


# --- the roles of dimensions: x, y, curve, row, column, or none -----------------------------------

MOST_FACETS = 4  # columns that still fit on a page


@dataclass(frozen=True)
class Layout:
    """The dimensions by role: no axis for a single point, x for curves, x and y for maps.

    With `both_ways` each curve is followed upward and downward.
    """

    x: str | None = None
    y: str | None = None
    hue: str | None = None
    row: str | None = None
    col: str | None = None
    both_ways: bool = False

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimensions that have a role."""
        ways = DIRECTION if self.both_ways else None
        dims = (self.x, self.y, self.hue, self.row, self.col, ways)
        return tuple(dim for dim in dims if dim is not None)


@dataclass(frozen=True)
class Selection:
    """One slice of a dataset, and its label."""

    label: str
    dataset: xr.Dataset


def layout_of(
    ds: xr.Dataset, choice: Choice | None = None, *, discrete: bool = False, rows: int = 2
) -> Layout:
    """Return the layout: curves along one long axis, maps over two, facets for further axes.

    A single point has no axis. `discrete` values are drawn as maps. If the variables fill only one
    of the `rows` of panels, a short axis may fill more. A dimension without room has no role.
    """
    named = named_roles(ds, choice or Choice())
    if "y" in named and "hue" in named:
        raise ValueError("y makes a map and hue makes curves; choose one of them")
    if discrete and "hue" in named:
        # Kinds are not curves: each fluid or case gets a strip of colour.
        strips = named["y"] = named.pop("hue")
        if ds[strips].dtype.kind in "fiu" and strips not in NAMED:
            raise ValueError(
                f"kinds and counts are drawn as maps, not curves; use {strips} as y, not as hue"
            )
    free = [str(dim) for dim in ds.sizes if ds.sizes[dim] > 1 and dim not in named.values()]
    x, y, hue, row, col = (named.get(role) for role in ROLES)
    layout = _place_axes(ds, Layout(x, y, hue, row, col), free, discrete)
    if layout.x is None and layout.dims:
        raise ValueError("no axis is left for x; use fewer of the other roles")
    free = [dim for dim in free if dim not in layout.dims]
    if layout.y is None and not discrete and DIRECTION in free:
        layout = replace(layout, both_ways=True)
        free.remove(DIRECTION)
    return _place_facets(ds, layout, free, rows)


def _place_axes(ds: xr.Dataset, layout: Layout, free: list[str], discrete: bool) -> Layout:
    ranked = sorted((dim for dim in free if dim != DIRECTION), key=lambda dim: _rank(ds, dim))
    chosen = layout.x is None
    if chosen and ranked:
        layout = replace(layout, x=ranked.pop(0))
    if layout.x is None or layout.y or layout.hue or not ranked:
        return layout
    if not discrete and ds.sizes[ranked[0]] <= MANY:
        fluids = "rheological_index"
        first = next(dim for dim in free if dim in ranked)
        return replace(layout, hue=fluids if fluids in ranked else first)
    axes = [layout.x, ranked[0]]
    if chosen and ds.sizes[ranked[0]] > MANY:
        axes = [dim for dim in free if dim in axes]
    return replace(layout, x=axes[0], y=axes[1])


def _place_facets(ds: xr.Dataset, layout: Layout, free: list[str], rows: int) -> Layout:
    # First both directions of a map, side by side; then the dimension with the fewest panels.
    ranked = sorted(free, key=lambda dim: (dim != DIRECTION, ds.sizes[dim]))
    if layout.col is None and ranked:
        layout = replace(layout, col=ranked.pop(0))
    few = [dim for dim in ranked if ds.sizes[dim] <= MOST_FACETS]
    if layout.row is None and few and rows == 1 and ds.sizes[layout.col] <= MOST_FACETS:
        layout = replace(layout, row=few[0])
    return layout


def _rank(ds: xr.Dataset, dim: str) -> tuple[bool, bool, int]:
    """Return a sort key: long axes first, then parameters before linked cases, then by length."""
    size = ds.sizes[dim]
    return size <= MANY, dim not in PARAMETERS, -size


def selections(ds: xr.Dataset, dims: tuple[str, ...], most: int) -> tuple[list[Selection], str]:
    """Return up to `most` slices over `dims`, and a note if some are left out."""
    indices = list(itertools.product(*(range(ds.sizes[dim]) for dim in dims)))
    kept = _evenly(len(indices), most)
    places = [dict(zip(dims, indices[at], strict=True)) for at in kept]
    chosen = [Selection(slice_label(ds, place), ds.isel(place)) for place in places]
    return chosen, _left_out(ds, dims, len(kept), len(indices))


def thinned(ds: xr.Dataset, dim: str | None, most: int) -> tuple[xr.Dataset, str]:
    """Return up to `most` evenly chosen points of a dimension, and a note if some are left out."""
    if dim is None or ds.sizes[dim] <= most:
        return ds, ""
    note = _left_out(ds, (dim,), most, ds.sizes[dim])
    return ds.isel({dim: _evenly(ds.sizes[dim], most)}), note


def _left_out(ds: xr.Dataset, dims: tuple[str, ...], kept: int, count: int) -> str:
    """Return a note on the values that are not drawn; empty if all are."""
    if kept == count:
        return ""
    names = ", ".join(shown(coordinate_of(ds, dim)).symbol for dim in dims)
    return f"{kept} of {count} values of {names} are drawn."


def _evenly(count: int, most: int) -> list[int]:
    """Return up to `most` indices below `count`, evenly spread, with both ends if there is room."""
    if count <= most:
        return list(range(count))
    if most == 1:
        return [count // 2]
    return [math.floor(i * (count - 1) / (most - 1) + 0.5) for i in range(most)]


# --- linked cases in no order, such as random ones ------------------------------------------------

_WIDE = 5.0  # the ratio of the largest to the smallest value from which a log axis may fit better


def cases_to_scatter(ds: xr.Dataset, choice: Choice) -> bool:
    """Return True if cases are drawn as points: they are in no order and have no other role."""
    if ds.sizes.get(CASE, 1) == 1 or not is_scattered(ds, CASE):
        return False
    along = {CASE, *parameters_along(ds, CASE)}
    names = (getattr(choice, role) for role in ROLES)
    named = {canonical_name(name) or name for name in names if name}
    return named <= along and (ds.sizes[CASE] > MANY or len(ds.sizes) == 1)


def fits_log(values: Array) -> bool:
    """Return True if the median of the values is nearer to their centre on a logarithmic scale."""
    low, middle, high = np.quantile(values, [0.0, 0.5, 1.0])
    if low <= 0 or high < _WIDE * low:
        return False
    return bool(abs(math.log(middle**2 / (low * high))) < abs(math.log(2 * middle / (low + high))))
