"""What a page can show of a result: along which axes, as curves, maps or points."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import xarray as xr

from sweeps.figures.labels import parameters_along
from sweeps.figures.layout import Axis, Layout, axis_of, is_scattered, layout_of
from sweeps.figures.plot_options import PlotOptions
from sweeps.figures.scatter import cases_to_scatter
from sweeps.grid import CASE, DIRECTION

Kind = Literal["curves", "map", "points", "point map"]


@dataclass(frozen=True)
class View:
    """A way to look at a result; what has no role is chosen with sliders.

    `x` and `y` are dimensions of maps and curves and parameters of points. Of a map y goes up; of
    curves `hue` has one for each value, and `both_ways` says that each goes up and down.
    """

    kind: Kind
    x: str
    y: str | None = None
    hue: str | None = None
    both_ways: bool = False

    @property
    def name(self) -> str:
        """What its figure is called, which differs from all others."""
        return " ".join([self.kind, self.x, *(name for name in (self.y, self.hue) if name)])

    @property
    def dims(self) -> tuple[str, ...]:
        """The dimensions that need no slider."""
        if self.kind in ("points", "point map"):
            return (CASE,)
        ways = DIRECTION if self.both_ways else None
        return tuple(dim for dim in (self.x, self.y, self.hue, ways) if dim)


def ordered(ds: xr.Dataset) -> tuple[xr.Dataset, dict[str, Axis]]:
    """The result with rising values along its axes, and these; cases in no order stay as they are.

    Dimensions of one point are none.
    """
    ds = ds.squeeze()
    axes = {dim: axis_of(ds, dim, named=True) for dim in map(str, ds["status"].dims)}
    if CASE in axes and is_scattered(ds, CASE):
        axes[CASE] = replace(axes[CASE], order=np.arange(ds.sizes[CASE]))
    return ds.isel({dim: axis.order for dim, axis in axes.items()}), axes


def is_uniform(axis: Axis) -> bool:
    """Whether all cells along an axis are equally wide on its own scale."""
    return bool(np.allclose(axis.steps, axis.steps.mean(), rtol=1e-6, atol=0.0))


def views_of(ds: xr.Dataset) -> list[View]:
    """The views of a result, first the one of its standard picture; none of a single point."""
    if cases_to_scatter(ds, PlotOptions()):
        return list(_views_of_points(ds))
    layout = layout_of(ds)
    if layout.x is None:
        return []
    maps = _maps(ds, layout)
    if layout.y is not None:
        return maps
    return [View("curves", layout.x, hue=layout.hue, both_ways=layout.both_ways), *maps]


def _maps(ds: xr.Dataset, layout: Layout) -> list[View]:
    """Maps over all pairs of axes, first that of the layout; the longer axis lies across."""
    long_first = sorted(map(str, ds.sizes), key=lambda dim: -ds.sizes[dim])
    dims = [dim for dim in long_first if dim != DIRECTION and not _is_unordered(ds, dim)]
    pairs = list(itertools.combinations(dims, 2))
    if layout.x is not None and layout.y is not None:
        first = (layout.x, layout.y)
        pairs = [first, *(pair for pair in pairs if set(pair) != set(first))]
    return [View("map", x, y) for x, y in pairs]


def _is_unordered(ds: xr.Dataset, dim: str) -> bool:
    return dim == CASE and is_scattered(ds, dim)


def _views_of_points(ds: xr.Dataset) -> Iterator[View]:
    """The variable over each parameter that cases vary, and in colours over each pair of them."""
    along = parameters_along(ds, CASE)
    yield from (View("points", x) for x in along)
    yield from (View("point map", x, y) for x, y in itertools.combinations(along, 2))
