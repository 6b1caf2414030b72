"""The picture of a sweep result: curves, maps, points, or the table of a single point."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from sweeps.charts.at import slice_at, slice_in_the_middle
from sweeps.charts.borders import require_borders
from sweeps.charts.choice import lie_along, variables_of
from sweeps.charts.clouds import cases_to_scatter
from sweeps.charts.colours import is_discrete
from sweeps.charts.layout import layout_of
from sweeps.figures.curves import draw_curves
from sweeps.figures.maps import draw_maps
from sweeps.figures.plot_options import PlotOptions
from sweeps.figures.scatter import draw_scatter
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
        if options.boundaries is not None:
            require_borders(options.boundaries)
        if is_map:
            figure = draw_maps(ds, layout, variables, options.scales, options.boundaries)
        elif options.boundaries is None:
            figure = draw_curves(ds, layout, variables, options.scales, options.data)
        else:
            raise ValueError("borders are drawn on maps: name the axis -y as well")
        if is_map and options.data is not None:
            raise ValueError(
                f"measured points are drawn over curves, and {', '.join(variables)} would be a "
                "map; name a variable and axes that make curves"
            )
    put_note(figure, [at, middle])
    return figure
