"""Variables over two axes, or kinds of motion along one: coloured cells, legends and borders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.charts.axes import STRIP, Axis, Layout, axis_of, cell_edges
from sweeps.charts.chart import (
    BORDER_STYLES,
    Cells,
    border_axes,
    border_parts,
    cells_of,
    place_elsewhere,
)
from sweeps.charts.colours import BLACK, GREY, Colours, colours_of, is_discrete
from sweeps.charts.labels import Array
from sweeps.charts.missing import missing_notes
from sweeps.figures.panels import Panel, facet_panels, label_axes
from sweeps.figures.style import SMALL, make_logarithmic, name_ticks, put_legend, put_note

_BORDER_WIDTH = 1.0  # points: well above the 0.4 of the lines between cells


def shades_of(colours: Colours) -> dict[str, Any]:
    """Return the colours of a variable as arguments of `pcolormesh` and `scatter`.

    They follow the settings of matplotlib. Everything on one scale has the same norm.
    """
    cmap: Colormap = colormaps[mpl.rcParams["image.cmap"]]
    if not colours.codes:
        norm = (LogNorm if colours.log else Normalize)(colours.low, colours.high)
        return {"cmap": cmap.with_extremes(bad=GREY), "norm": norm}
    count = len(colours.codes)
    kinds = colours.kinds if colours.is_named else list(cmap(np.linspace(0.0, 1.0, count)))
    return {
        "cmap": ListedColormap(kinds),
        "norm": BoundaryNorm(np.arange(count + 1) - 0.5, count),
    }


def legend_of(colours: Colours) -> list[Line2D]:
    """Return a square and a name for each kind; nothing for numbers, which get a colour bar."""
    if not colours.is_named:
        return []
    squares = zip(colours.kinds, colours.names, strict=True)
    return [
        Line2D([], [], linestyle="none", marker="s", color=colour, label=label, markersize=6.0)
        for colour, label in squares
    ]


def draw_scale(
    colours: Colours, shades: Mapping[str, Any], figure: Figure, beside: Sequence[Axes]
) -> None:
    """Draw a colour bar beside some panels, unless the colours are kinds."""
    if colours.is_named:
        return
    bar = figure.colorbar(ScalarMappable(**shades), ax=list(beside), pad=0.02, aspect=25)
    bar.set_label(colours.label)
    if colours.log:
        name_ticks(bar.ax.yaxis)
    bar.ax.tick_params(direction="in", which="both")
    bar.ax.yaxis.get_offset_text().set_fontsize(SMALL)
    if colours.codes:
        bar.set_ticks(list(range(len(colours.codes))), labels=colours.names)
        bar.ax.tick_params(which="both", length=0)


def draw_maps(
    ds: xr.Dataset,
    layout: Layout,
    variables: Sequence[str],
    scales: frozenset[str] = frozenset(),
    borders: xr.Dataset | None = None,
) -> Figure:
    """Draw a map of each variable, all on the same axes, and a column of maps for each facet.

    Missing points are grey. A line separates cells of different kinds or counts, unless there are
    computed `borders`. Raises ValueError if these belong to another map.
    """
    if layout.y is None:
        ds = ds.expand_dims(STRIP)
    across = axis_of(ds, str(layout.x), log="x" in scales)
    # Borders lie between the values of an axis, and names have no place there.
    up = axis_of(
        ds, layout.y or STRIP, log="y" in scales and layout.y is not None, named=borders is None
    )
    _require_cells(across, up)
    _require_scales(ds, layout, variables, scales, across, up)
    drawn = facet_panels(ds, layout, variables, of_axes=True)
    kinds: list[Line2D] = []
    logarithmic: list[str] = []
    for name in variables:
        colours = colours_of(drawn.dataset, name, log="z" in scales)
        shades = shades_of(colours)
        for panel in drawn.of(name):
            chart = cells_of(panel.dataset, across, up, colours)
            _draw_map(panel, chart, shades, parted=borders is None)
        draw_scale(colours, shades, drawn.figure, [panel.axes for panel in drawn.of(name)])
        kinds += legend_of(colours)
        if colours.log:  # kinds and counts have no scale
            logarithmic.append(name)
    if borders is not None:
        kinds += _draw_borders(drawn.panels, borders, across, up)
    if kinds:
        put_legend(drawn.figure, kinds, above=True)
    label_axes(drawn, across.label, [up.label if layout.y else ""])
    missing = missing_notes(drawn.dataset, variables, "Grey: ", log=logarithmic)
    put_note(drawn.figure, [*missing, *drawn.notes])
    return drawn.figure


def _require_cells(*axes: Axis) -> None:
    """Raise ValueError if points of an axis would share a cell, so that some would not be seen."""
    for axis in axes:
        if (axis.steps == 0.0).any():
            raise ValueError(
                f"several points have the same {axis.dim}, but a map would show only one; "
                "choose another axis"
            )


def _require_scales(
    ds: xr.Dataset,
    layout: Layout,
    variables: Sequence[str],
    scales: frozenset[str],
    across: Axis,
    up: Axis,
) -> None:
    """Raise ValueError for a logarithmic scale of something that has no scale."""
    if "z" in scales and all(is_discrete(ds, name) for name in variables):
        raise ValueError("kinds and counts have no scale, so log z does not apply")
    if "y" in scales and layout.y is None:
        raise ValueError("kinds along a single axis have no vertical axis, so log y does not apply")
    for letter, axis in (("x", across), ("y", up)):
        if letter in scales and axis.names:
            raise ValueError(
                f"the points of {axis.dim} have names here, so log {letter} does not apply"
            )


def _draw_map(panel: Panel, chart: Cells, shades: Mapping[str, Any], *, parted: bool) -> None:
    across, up = chart.across, chart.up
    edges = cell_edges(across), cell_edges(up)
    panel.axes.pcolormesh(
        *edges,
        chart.values,
        **shades,
        rasterized=True,  # thousands of cells as vectors make a slow file with hairlines
    )
    if chart.colours.codes and parted:
        borders = _edges(np.ma.filled(chart.values, -1.0), *edges)
        panel.axes.add_collection(borders, autolim=False)
    panel.axes.tick_params(direction="out", which="both", top=False, right=False)
    make_logarithmic(panel.axes, ["x"] * across.geometric + ["y"] * up.geometric)
    if across.names:
        panel.axes.set_xticks(across.quantity.values, labels=across.names)
    if up.names or up.dim == STRIP:
        panel.axes.set_yticks(up.quantity.values if up.names else [], labels=up.names)
        panel.axes.tick_params(axis="y", length=0)


def _edges(codes: Array, x: Array, y: Array) -> LineCollection:
    """Return the edges between cells (y, x) of different codes."""
    rows, columns = np.nonzero(codes[:, 1:] != codes[:, :-1])
    upright = [[(x[j + 1], y[i]), (x[j + 1], y[i + 1])] for i, j in zip(rows, columns, strict=True)]
    rows, columns = np.nonzero(codes[1:] != codes[:-1])
    level = [[(x[j], y[i + 1]), (x[j + 1], y[i + 1])] for i, j in zip(rows, columns, strict=True)]
    return LineCollection(upright + level, colors="black", linewidths=0.4, capstyle="projecting")


def _draw_borders(
    panels: Sequence[Panel], borders: xr.Dataset, across: Axis, up: Axis
) -> list[Line2D]:
    """Draw the borders on the panels whose other parameters they have.

    Return a line and a label for each type of border; nothing if all have one type. Raises
    ValueError for borders over other axes, or that belong to no panel.
    """
    over = border_axes(borders)
    if {across.dim, up.dim} != set(over) or across.names or up.names:
        raise ValueError(
            f"these borders were computed over {' and '.join(over)}; choose those axes"
        )
    parts = list(border_parts(borders, across.dim, up.dim))
    lines = [places for places, _, _ in parts]
    look: dict[str, Any] = {"linestyles": [BORDER_STYLES[name] for _, _, name in parts]}
    look |= {"colors": BLACK, "linewidths": _BORDER_WIDTH}
    obstacles = [place_elsewhere(panel.dataset, borders) for panel in panels]
    if all(obstacles):
        raise ValueError(obstacles[-1])
    for panel, obstacle in zip(panels, obstacles, strict=True):
        if not obstacle:
            panel.axes.add_collection(LineCollection(lines, **look), autolim=False)
    present = {name for _, _, name in parts}
    line: dict[str, Any] = {"color": BLACK, "linewidth": _BORDER_WIDTH}
    legend = [
        Line2D([], [], label=f"border: {name}", **line | {"linestyle": style})
        for name, style in BORDER_STYLES.items()
        if name in present
    ]
    return legend if len(legend) > 1 else []
