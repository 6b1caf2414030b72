"""The picture of a sweep result: curves, maps, points, or the table of a single point."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from sweeps.figures.colours import is_discrete
from sweeps.figures.curves import draw_curves
from sweeps.figures.layout import layout_of
from sweeps.figures.maps import draw_maps
from sweeps.figures.plot_options import (
    PlotOptions,
    lie_along,
    slice_at,
    slice_in_the_middle,
    variables_of,
)
from sweeps.figures.scatter import cases_to_scatter, draw_scatter
from sweeps.figures.single_point import draw_point
from sweeps.figures.style import put_note


def amplitudes(ds: xr.Dataset) -> Figure:
    """Curves along one long axis, maps over two, facets beyond, a table for a single point."""
    return draw_results(ds, PlotOptions())


def draw_results(ds: xr.Dataset, options: PlotOptions) -> Figure:
    """The picture that the options ask for; raises ValueError if the dataset has none such."""
    variables = variables_of(ds, options)
    ds, at = slice_at(ds.squeeze(), options.at)
    if not ds.sizes:
        return draw_point(ds)
    if cases_to_scatter(ds, options):
        figure, middle = draw_scatter(ds, variables, options)
    else:
        ds = lie_along(ds, options)
        discrete = all(is_discrete(ds, name) for name in variables)
        layout = layout_of(ds, options, discrete=discrete, rows=len(variables))
        left = [str(dim) for dim in ds.sizes if dim not in layout.dims]
        ds, middle = slice_in_the_middle(ds, left)
        is_map = layout.y is not None or discrete
        draw = draw_maps if is_map else draw_curves
        figure = draw(ds, layout, variables, options.scales)
    put_note(figure, [at, middle])
    return figure
