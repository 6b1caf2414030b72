"""Variables along one axis (Figs. 7-9): a row of panels each, one curve per lubricant."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from stickslip.variables import PARAMETERS
from sweeps.charts.axes import MANY, Axis, axis_of
from sweeps.charts.curves import Curve, axis_limits, curves_of, range_with_spread
from sweeps.charts.jumps import break_line
from sweeps.charts.labels import DIRECTIONS, Array, legend_label, shown
from sweeps.charts.layout import Layout, thinned
from sweeps.charts.missing import missing_notes, missing_points
from sweeps.charts.styles import SINGLE, CurveStyle, hue_of, way_style
from sweeps.figures.data import draw_measured
from sweeps.figures.panels import Panel, facet_panels, label_axes
from sweeps.figures.style import (
    has_small_print,
    line_at,
    line_of,
    make_logarithmic,
    palette,
    put_legend,
    put_note,
)
from sweeps.grid import DIRECTION
from sweeps.human import counted

if TYPE_CHECKING:
    from sweeps.measurements import Measurements

_FEW = 20  # points that are worth a marker each
_ROW = 0.035  # of a panel's height: one row of crosses for missing points
_UP_AT, _HEAD = 0.6, 9.0  # part of a curve at which its arrow stands; the size of that, in points
_BAND = 0.2  # opacity
_MARGIN = 0.02  # beside a curve, in parts of its length; markers need more


def draw_curves(
    ds: xr.Dataset,
    layout: Layout,
    variables: Sequence[str],
    scales: frozenset[str] = frozenset(),
    data: Measurements | None = None,
) -> Figure:
    """A row of panels for each variable, which share the x axis, and a column for each facet.

    A missing point is a gap in its curve and a cross in the curve's colour at the panel's top.
    Measured points lie over the curve of their parameters.
    """
    ds, note = thinned(ds, layout.hue, MANY)
    axis = axis_of(ds, str(layout.x), log="x" in scales)
    ds = ds.isel({axis.dim: axis.order})
    drawn = facet_panels(ds, layout, variables, of_axes=False)
    crosses = _rows_of_crosses(drawn.dataset, layout.hue, variables)
    log = bool(scales & {"y", "z"})
    for panel in drawn.panels:
        _draw_panel(panel, axis, layout, variables, crosses)
        panel.axes.set_xmargin(_MARGIN if axis.order.size > _FEW else 2 * _MARGIN)
        panel.axes.update_datalim([(x, 0.0) for x in axis.quantity.values[[0, -1]]], updatey=False)
        make_logarithmic(panel.axes, ["x"] * axis.geometric + ["y"] * log)
        low, high = range_with_spread(drawn.dataset, panel.variable, log=log)
        panel.axes.set(ylim=axis_limits(low, high, 1.0 / (1.0 - _ROW * crosses[-1]), log=log))
    elsewhere = 0
    if data is not None:
        for panel in drawn.panels:
            elsewhere += draw_measured(panel, axis, layout, data)
    label_axes(drawn, axis.label, [shown(ds[name]).label for name in variables])
    if handles := _legend(ds, layout):
        put_legend(drawn.figure, handles, short=_legend(ds, layout, short=True))
    missing = missing_notes(drawn.dataset, variables, "× ", log=variables if log else ())
    others = counted(elsewhere, "measured value")
    apart = f"Not drawn: {others} of other parameters." if elsewhere else ""
    put_note(drawn.figure, [*missing, note, *drawn.notes, apart])
    if apart and not has_small_print():
        warnings.warn(apart, stacklevel=6)  # the line that called the accessor's `plot`
    return drawn.figure


def _draw_panel(
    panel: Panel, axis: Axis, layout: Layout, variables: Sequence[str], rows: list[int]
) -> None:
    axes, colours = panel.axes, palette()
    for curve in curves_of(panel.dataset, layout, axis, panel.variable):
        style = curve.style(colours)
        x, y = break_line(axis, curve.values, curve.jumps)
        axes.plot(x, y, marker="o", markevery=_marked(y), **line_of(style))
        draw_jumps(axes, axis, curve, style.colour)
        _draw_arrow(axes, axis.quantity.values, curve, style.colour)
        if curve.spread is not None:
            ends = curve.values - curve.spread, curve.values + curve.spread
            look: dict[str, Any] = {"color": style.colour, "alpha": _BAND, "linewidth": 0.0}
            axes.fill_between(axis.quantity.values, *ends, **look)
        missing = missing_points(panel.dataset.isel(curve.places), variables).values
        row = rows[curve.places.get(str(layout.hue), 0)]
        _draw_crosses(axes, axis.quantity.values[missing], row, style)
    if axis.names:
        axes.set_xticks(axis.quantity.values, labels=axis.names)
    if panel.dataset[panel.variable].dtype.kind in "iu":
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def draw_jumps(axes: Axes, axis: Axis, curve: Curve, colour: str) -> None:
    """A thin dotted vertical line in the middle of each jump."""
    for i in np.flatnonzero(curve.jumps):
        middle = [axis.middles[i]] * 2
        axes.plot(middle, curve.values[i : i + 2], ":", color=colour, linewidth=0.7, gid="jump")


def _draw_arrow(axes: Axes, x: Array, curve: Curve, colour: str) -> None:
    """Draw the head of an arrow along a curve, where no jump is: it tells the way."""
    steps = np.flatnonzero(np.isfinite(curve.values[:-1] + curve.values[1:]) & ~curve.jumps)
    if not curve.way or not steps.size:
        return
    upward = curve.way == "up"
    step = steps[int((_UP_AT if upward else 1.0 - _UP_AT) * (steps.size - 1))]
    ends = [(x[place], curve.values[place]) for place in (step, step + 1)]
    tail, head = ends if upward else reversed(ends)
    arrow = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", head, tail, arrowprops=arrow | {"mutation_scale": _HEAD}, zorder=4)


def _marked(values: Array) -> list[int]:
    """Points with a marker: all where there are few, and those that no line reaches."""
    marked = np.isfinite(values)
    if values.size > _FEW:
        padded = np.pad(marked, 1)
        marked &= ~padded[:-2] & ~padded[2:]
    return np.flatnonzero(marked).tolist()


def _draw_crosses(axes: Axes, x: Array, row: int, style: CurveStyle) -> None:
    if x.size == 0:
        return
    heights = np.full(x.size, 1.0 - _ROW * (row - 0.3))
    (crosses,) = axes.plot(
        x, heights, "x", transform=axes.get_xaxis_transform(), color=style.colour, markersize=3.0
    )
    crosses.set_gid("missing")


def _rows_of_crosses(ds: xr.Dataset, curve: str | None, variables: Sequence[str]) -> list[int]:
    """The row of each curve's crosses: from the top, curves without a missing point skipped."""
    missing = missing_points(ds, variables)
    gaps = missing.any([dim for dim in missing.dims if dim != curve]).values
    return [int(row) for row in np.cumsum(np.atleast_1d(gaps))]


def _legend(ds: xr.Dataset, layout: Layout, *, short: bool = False) -> list[Line2D]:
    """Return a line and a label for each curve; `short` labels share a symbol and a unit."""
    ways = [str(way) for way in ds[DIRECTION].values] if layout.both_ways else []
    handles: list[Line2D] = []
    if layout.hue is not None:
        count = ds.sizes[layout.hue]
        labels = [legend_label(ds, layout.hue, index) for index in range(count)]
        if short and layout.hue in PARAMETERS:
            handles.append(
                Line2D([], [], linestyle="none", label=f"{shown(ds[layout.hue]).label}:")
            )
            labels = [shown(value).number for value in ds[layout.hue]]
        for index, label in enumerate(labels):
            style = line_at(hue_of(layout.hue, index, count))
            line = line_of(way_style(style, "up" if ways else ""))
            handles.append(Line2D([], [], **line, label=label))
    for way in ways:
        line = line_of(way_style(SINGLE, way))
        handles.append(Line2D([], [], **line, label=DIRECTIONS.get(way, way)))
    return handles
