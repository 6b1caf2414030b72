"""Amplitudes along one axis (Figs. 7-9): stress above, force below, one curve per lubricant."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.figure_table import AMPLITUDES
from sweeps.figures.labels import Array, shown
from sweeps.figures.layout import MOST_FACETS, Axis, Layout, axis_of, point_label, selections
from sweeps.figures.missing import highest, missing_note, missing_points, trusted
from sweeps.figures.style import (
    STACKED,
    TEXT,
    CurveStyle,
    curve_style,
    name_columns,
    new_panels,
    put_legend,
    put_note,
    set_scale,
    width_of,
)

_FEW = 20  # points that are worth a marker each
_ROW = 0.035  # of a panel's height: one row of crosses for missing points


def draw_curves(ds: xr.Dataset, layout: Layout) -> Figure:
    """Two panels that share the x axis, a column of them for each facet.

    A missing point is a gap in its curve and a cross in the curve's colour at the panel's top.
    """
    axis = axis_of(ds, layout.axes[0])
    ds = ds.isel({axis.dim: axis.order})
    facets, note = selections(ds, layout.facets, MOST_FACETS)
    size = (width_of(len(facets)), STACKED)
    figure, panels = new_panels(2, len(facets), size, sharex=True, sharey="row")
    crosses = _rows_of_crosses(ds, layout.curve)
    for row, name in zip(panels, AMPLITUDES, strict=True):
        for axes, facet in zip(row, facets, strict=True):
            _draw_panel(axes, facet.dataset, name, axis, layout.curve, crosses)
        # From just below zero, so that a curve at zero shows, to above the highest point.
        top, room = highest(ds, name), 1.0 / (1.0 - _ROW * crosses[-1])
        row[0].set_ylim(-0.03 * top, 1.05 * top * room)
        row[0].set_ylabel(shown(ds[name]).label, fontsize=TEXT)
    name_columns(panels, [facet.label for facet in facets], axis.label)
    for axes in panels[1]:
        set_scale(axes, "x", axis.geometric)
        axes.margins(x=0.02)
    figure.align_ylabels()
    if layout.curve is not None:
        put_legend(figure, _legend(ds, layout.curve))
    put_note(figure, [missing_note(ds, "× "), note])
    return figure


def _draw_panel(
    axes: Axes, ds: xr.Dataset, name: str, axis: Axis, curve: str | None, rows: list[int]
) -> None:
    x = axis.quantity.values
    for row, (line, style) in zip(rows, _curves(ds, curve), strict=True):
        values = shown(trusted(line, name)).values
        axes.plot(x, values, marker="o", markevery=_marked(values), **style.line())
        _draw_crosses(axes, x[missing_points(line).values], row, style)


def _curves(ds: xr.Dataset, curve: str | None) -> list[tuple[xr.Dataset, CurveStyle]]:
    if curve is None:
        return [(ds, curve_style(0, 1))]
    count = ds.sizes[curve]
    return [(ds.isel({curve: i}), curve_style(i, count)) for i in range(count)]


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


def _rows_of_crosses(ds: xr.Dataset, curve: str | None) -> list[int]:
    """The row of each curve's crosses: from the top, curves without a missing point skipped."""
    missing = missing_points(ds)
    gaps = missing.any([dim for dim in missing.dims if dim != curve]).values
    return [int(row) for row in np.cumsum(np.atleast_1d(gaps))]


def _legend(ds: xr.Dataset, curve: str) -> list[Line2D]:
    return [
        Line2D([], [], **style.line(), label=point_label(ds, curve, index))
        for index, (_, style) in enumerate(_curves(ds, curve))
    ]
