"""The standard picture of a sweep result: curves, maps, or the table of a single point."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from sweeps.figures.curves import draw_curves
from sweeps.figures.layout import layout_of
from sweeps.figures.maps import draw_maps
from sweeps.figures.single_point import draw_point


def amplitudes(ds: xr.Dataset) -> Figure:
    """Curves along one long axis, maps over two, facets beyond, a table for a single point."""
    ds = ds.squeeze()
    layout = layout_of(ds)
    if not layout.axes:
        return draw_point(ds)
    return draw_curves(ds, layout) if len(layout.axes) == 1 else draw_maps(ds, layout)
