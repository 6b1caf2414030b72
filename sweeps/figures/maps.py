"""Variables over two axes, or kinds of motion along one: coloured cells with named colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.charts.axes import STRIP, Axis, axis_of, cell_edges
from sweeps.charts.chart import Cells, cells_of
from sweeps.charts.colours import colours_of
from sweeps.charts.labels import Array
from sweeps.charts.layout import Layout
from sweeps.charts.missing import missing_notes
from sweeps.figures.borders import border_legend, draw_borders
from sweeps.figures.colours import Shades, draw_scale, legend_of, shades_of
from sweeps.figures.panels import Panel, facet_panels, label_axes
from sweeps.figures.style import make_logarithmic, put_legend, put_note


def draw_maps(
    ds: xr.Dataset,
    layout: Layout,
    variables: Sequence[str],
    scales: frozenset[str] = frozenset(),
    borders: xr.Dataset | None = None,
) -> Figure:
    """A map of each variable on the same axes, a column of them for each facet, with one scale.

    A missing point is grey; a line parts cells of different kinds or counts, unless there are
    computed `borders`. Raises ValueError if these are of another map.
    """
    if layout.y is None:
        ds = ds.expand_dims(STRIP)
    across = axis_of(ds, str(layout.x), log="x" in scales)
    up = axis_of(ds, layout.y or STRIP, log="y" in scales, named=True)
    drawn = facet_panels(ds, layout, variables, of_axes=True)
    kinds: list[Line2D] = []
    logarithmic: list[str] = []
    for name in variables:
        colours = colours_of(drawn.dataset, name, log="z" in scales)
        shades = shades_of(colours)
        for panel in drawn.of(name):
            chart = cells_of(panel.dataset, across, up, colours, {})
            _draw_map(panel, chart, shades, parted=borders is None)
        draw_scale(colours, shades, drawn.figure, [panel.axes for panel in drawn.of(name)])
        kinds += legend_of(colours)
        if colours.log:  # kinds and counts have no scale
            logarithmic.append(name)
    if borders is not None:
        draw_borders(drawn.panels, borders, across, up)
        kinds += border_legend(borders)
    if kinds:
        put_legend(drawn.figure, kinds, above=True)
    label_axes(drawn, across.label, [up.label if layout.y else ""])
    missing = missing_notes(drawn.dataset, variables, "Grey: ", log=logarithmic)
    put_note(drawn.figure, [*missing, *drawn.notes])
    return drawn.figure


def _draw_map(panel: Panel, chart: Cells, shades: Shades, *, parted: bool) -> None:
    across, up = chart.across, chart.up
    edges = cell_edges(across), cell_edges(up)
    panel.axes.pcolormesh(
        *edges,
        chart.values,
        **shades.arguments(),
        rasterized=True,  # thousands of cells as vectors make a slow file with hairlines
    )
    if chart.colours.codes and parted:
        borders = _borders(np.ma.filled(chart.values, -1.0), *edges)
        panel.axes.add_collection(borders, autolim=False)
    panel.axes.tick_params(direction="out", which="both", top=False, right=False)
    make_logarithmic(panel.axes, ["x"] * across.geometric + ["y"] * up.geometric)
    _name_points(panel.axes, across, up)


def _name_points(axes: Axes, across: Axis, up: Axis) -> None:
    if across.names:
        axes.set_xticks(across.quantity.values, labels=across.names)
    if up.names or up.dim == STRIP:
        axes.set_yticks(up.quantity.values if up.names else [], labels=up.names)
        axes.tick_params(axis="y", length=0)


def _borders(codes: Array, x: Array, y: Array) -> LineCollection:
    """The edges between cells (y, x) of different codes."""
    rows, columns = np.nonzero(codes[:, 1:] != codes[:, :-1])
    upright = [[(x[j + 1], y[i]), (x[j + 1], y[i + 1])] for i, j in zip(rows, columns, strict=True)]
    rows, columns = np.nonzero(codes[1:] != codes[:-1])
    level = [[(x[j], y[i + 1]), (x[j + 1], y[i + 1])] for i, j in zip(rows, columns, strict=True)]
    return LineCollection(upright + level, colors="black", linewidths=0.4, capstyle="projecting")
