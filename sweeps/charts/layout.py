"""The roles of a result's dimensions in its picture: x, y, curve, row, column, or none."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import xarray as xr

from stickslip.variables import PARAMETERS
from sweeps.charts.axes import MANY, NAMED, coordinate_of
from sweeps.charts.choice import ROLES, Choice, named_roles
from sweeps.charts.labels import shown, slice_label
from sweeps.grid import DIRECTION

MOST_FACETS = 4  # columns that still fit on a page


@dataclass(frozen=True)
class Layout:
    """The dimensions by role: no axis for a single point, x for curves, x and y for maps.

    `both_ways` says that each curve is followed upward and downward.
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
    """One slice of a dataset, and what to call it."""

    label: str
    dataset: xr.Dataset


def layout_of(
    ds: xr.Dataset, choice: Choice | None = None, *, discrete: bool = False, rows: int = 2
) -> Layout:
    """Curves along one long axis, maps over two, facets beyond; a single point has no axis.

    Values that are `discrete` are drawn as maps. Where the variables take one of the `rows` of
    panels only, a short axis may take others. A dimension that finds no place has no role.
    """
    named = named_roles(ds, choice or Choice())
    if "y" in named and "hue" in named:
        raise ValueError("y makes a map and hue makes curves: choose one of them")
    if discrete and "hue" in named:
        named["y"] = _strips(ds, named.pop("hue"))
    free = [str(dim) for dim in ds.sizes if ds.sizes[dim] > 1 and dim not in named.values()]
    x, y, hue, row, col = (named.get(role) for role in ROLES)
    layout = _place_axes(ds, Layout(x, y, hue, row, col), free, discrete)
    if layout.x is None and layout.dims:
        raise ValueError("no axis is left for x: give another role to fewer axes")
    free = [dim for dim in free if dim not in layout.dims]
    if layout.y is None and not discrete and DIRECTION in free:
        layout = replace(layout, both_ways=True)
        free.remove(DIRECTION)
    return _place_facets(ds, layout, free, rows)


def _strips(ds: xr.Dataset, hue: str) -> str:
    """The hue of kinds, which make no curves: a strip of colour for each fluid or case.

    Raises ValueError for values on a scale, which would make a map.
    """
    if ds[hue].dtype.kind in "fiu" and hue not in NAMED:
        raise ValueError(f"kinds and counts make no curves for hue: a map has {hue} as y")
    return hue


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
    # Both ways of a map side by side; then what takes the fewest panels.
    ranked = sorted(free, key=lambda dim: (dim != DIRECTION, ds.sizes[dim]))
    if layout.col is None and ranked:
        layout = replace(layout, col=ranked.pop(0))
    few = [dim for dim in ranked if ds.sizes[dim] <= MOST_FACETS]
    if layout.row is None and few and rows == 1 and ds.sizes[layout.col] <= MOST_FACETS:
        layout = replace(layout, row=few[0])
    return layout


def _rank(ds: xr.Dataset, dim: str) -> tuple[bool, bool, int]:
    """Long axes first, then parameters before linked cases, then by length."""
    size = ds.sizes[dim]
    return size <= MANY, dim not in PARAMETERS, -size


def selections(ds: xr.Dataset, dims: tuple[str, ...], most: int) -> tuple[list[Selection], str]:
    """The slices over `dims`, at most `most` of them, and a note where that leaves some out."""
    indices = list(itertools.product(*(range(ds.sizes[dim]) for dim in dims)))
    kept = _evenly(len(indices), most)
    places = [dict(zip(dims, indices[at], strict=True)) for at in kept]
    chosen = [Selection(slice_label(ds, place), ds.isel(place)) for place in places]
    return chosen, _left_out(ds, dims, len(kept), len(indices))


def thinned(ds: xr.Dataset, dim: str | None, most: int) -> tuple[xr.Dataset, str]:
    """Return at most `most` evenly chosen points of a dimension, and a note on the omitted ones."""
    if dim is None or ds.sizes[dim] <= most:
        return ds, ""
    note = _left_out(ds, (dim,), most, ds.sizes[dim])
    return ds.isel({dim: _evenly(ds.sizes[dim], most)}), note


def _left_out(ds: xr.Dataset, dims: tuple[str, ...], kept: int, count: int) -> str:
    """Return a note on values that are not drawn; empty where all are."""
    if kept == count:
        return ""
    names = ", ".join(shown(coordinate_of(ds, dim)).symbol for dim in dims)
    return f"{kept} of {count} values of {names} are drawn."


def _evenly(count: int, most: int) -> list[int]:
    """Return at most `most` indices below `count`, evenly spread, with both ends."""
    if count <= most:
        return list(range(count))
    return [math.floor(i * (count - 1) / (most - 1) + 0.5) for i in range(most)]
