"""Which role each dimension of a result plays in its picture: x axis, y axis, curve or facet."""

from __future__ import annotations

import itertools
import math
from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS
from sweeps.figures.labels import Quantity, shown
from sweeps.figures.style import CURVES

MANY = len(CURVES)  # an axis is long when its points would need more curves than there are styles
MOST_FACETS = 4  # columns that still fit on a page


@dataclass(frozen=True)
class Layout:
    """The dimensions by role: no axis for a single point, one for curves, two for maps."""

    axes: tuple[str, ...] = ()
    curve: str | None = None
    facets: tuple[str, ...] = ()


@dataclass(frozen=True)
class Axis:
    """A dimension as an axis: the order of its points, their shown values, and its scale."""

    dim: str
    order: np.ndarray[tuple[int], np.dtype[np.int_]]
    quantity: Quantity
    label: str
    geometric: bool


@dataclass(frozen=True)
class Selection:
    """One slice of a dataset, and what to call it."""

    label: str
    dataset: xr.Dataset


def layout_of(ds: xr.Dataset) -> Layout:
    """Curves along one long axis, maps over two, facets beyond; a single point has no axis."""
    dims = [str(dim) for dim, size in ds.sizes.items() if size > 1]
    if not dims:
        return Layout()
    ranked = sorted(dims, key=lambda dim: _rank(ds, dim))
    if len(ranked) > 1 and ds.sizes[ranked[1]] > MANY:
        axes = tuple(dim for dim in dims if dim in ranked[:2])
        return Layout(axes, facets=tuple(dim for dim in dims if dim not in axes))
    others = [dim for dim in dims if dim != ranked[0]]
    return Layout((ranked[0],), others[0] if others else None, tuple(others[1:]))


def _rank(ds: xr.Dataset, dim: str) -> tuple[bool, bool, int]:
    """Long axes first, then parameters before linked cases, then by length."""
    size = ds.sizes[dim]
    return size <= MANY, dim not in PARAMETERS, -size


def axis_of(ds: xr.Dataset, dim: str) -> Axis:
    """The axis of a dimension; linked cases lie along the first parameter that tells them apart."""
    coordinate = _coordinate(ds, dim)
    order = np.argsort(shown(coordinate).values, kind="stable")
    quantity = shown(coordinate[order])
    label = _axis_label(ds, coordinate)
    return Axis(dim, order, quantity, label, is_geometric(quantity.values))


def _coordinate(ds: xr.Dataset, dim: str) -> xr.DataArray:
    for name in _linked(ds, dim):
        if np.unique(ds[name].values).size == ds.sizes[dim]:
            return ds[name]
    return ds[dim]


def _linked(ds: xr.Dataset, dim: str) -> list[Hashable]:
    """The parameters that vary along a dimension which is none itself."""
    if dim in PARAMETERS:
        return []
    return [name for name in ds.coords if name in PARAMETERS and ds[name].dims == (dim,)]


def _axis_label(ds: xr.Dataset, coordinate: xr.DataArray) -> str:
    label = shown(coordinate).label
    linked = _linked(ds, str(coordinate.dims[0]))
    others = [shown(ds[name]).symbol for name in linked if name != coordinate.name]
    return f"{label}, linked with {', '.join(others)}" if others else label


def is_geometric(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    """Whether sorted values have one common ratio, hence even steps on a log axis."""
    if values.size < 3 or values[0] <= 0:
        return False
    steps = np.diff(np.log(values))
    return bool(np.allclose(steps, steps.mean(), rtol=1e-6, atol=0))


def selections(ds: xr.Dataset, dims: tuple[str, ...], most: int) -> tuple[list[Selection], str]:
    """The slices over `dims`, at most `most` of them, and a note where that leaves some out."""
    indices = list(itertools.product(*(range(ds.sizes[dim]) for dim in dims)))
    kept = _evenly(len(indices), most)
    chosen = []
    for i in kept:
        index = dict(zip(dims, indices[i], strict=True))
        labels = [point_label(ds, dim, place) for dim, place in index.items()]
        chosen.append(Selection(", ".join(labels), ds.isel(index)))
    if len(kept) == len(indices):
        return chosen, ""
    names = ", ".join(shown(_coordinate(ds, dim)).symbol for dim in dims)
    return chosen, f"{len(kept)} of {len(indices)} values of {names} are drawn."


def _evenly(count: int, most: int) -> list[int]:
    """At most `most` indices below `count`, evenly spread, with both ends."""
    if count <= most:
        return list(range(count))
    return [math.floor(i * (count - 1) / (most - 1) + 0.5) for i in range(most)]


def point_label(ds: xr.Dataset, dim: str, index: int) -> str:
    """What to call one point of a dimension: the value of its parameter, or of all linked ones."""
    names = _linked(ds, dim) or [dim]
    return ", ".join(shown(ds[name].isel({dim: index})).equation for name in names)
