"""All figures of a page by name, as its scripts take them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import xarray as xr
from bokeh.models import Model

from sweeps.figures.layout import Axis
from sweeps.figures.scatter import fits_log
from sweeps.views.report.figures import (
    SCALES,
    curves_figure,
    map_figure,
    orbit_figures,
    points_figure,
)
from sweeps.views.report.frames import written
from sweeps.views.report.payload import curve_names
from sweeps.views.report.views import View


def drawings(
    ds: xr.Dataset, axes: Mapping[str, Axis], views: list[View], *, orbits: bool
) -> dict[str, Any]:
    """The figures of some views, of the curves through a pixel, and of an orbit."""
    named = [figure for view in views for figure in _of_view(ds, axes, view)]
    along = dict.fromkeys(dim for view in views if view.kind == "map" for dim in view.dims)
    for dim in along:
        named += [(f"along {dim} {scale}", curves_figure(axes[dim], scale)) for scale in SCALES]
    if orbits:
        named += orbit_figures()
    return {name: written(model) for name, model in named}


def _of_view(ds: xr.Dataset, axes: Mapping[str, Axis], view: View) -> Iterator[tuple[str, Model]]:
    """The figures of a view: one, or one for each scale of the variable that goes up."""
    if view.kind == "map":
        yield view.name, map_figure(axes[view.x], axes[str(view.y)])
    elif view.kind == "point map":
        log = [way for way, name in (("x", view.x), ("y", view.y)) if _is_log(ds, str(name))]
        yield view.name, points_figure(ds[view.x], ds[view.y], "linear", log)
    for scale in SCALES if view.kind in ("curves", "points") else ():
        name = f"{view.name} {scale}"
        if view.kind == "curves":
            names = list(curve_names(ds, view))
            yield name, curves_figure(axes[view.x], scale, names, ways=view.both_ways, tall=True)
        else:
            log = ["x"] * _is_log(ds, view.x) + ["y"] * (scale == "log")
            yield name, points_figure(ds[view.x], None, scale, log)


def _is_log(ds: xr.Dataset, name: str) -> bool:
    return fits_log(ds[name].values)
