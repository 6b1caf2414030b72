"""The figure of a chart. What may change on it is found by the names of its renderers.

They are `cells` of a map or of points; of curve 0 `curve 0` with its points, `jumps 0` and
`missing 0`; and `mark`, the ring around the point that is open.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure

from stickslip.symbols import plain
from sweeps.charts.axes import STRIP, Axis, ends_of
from sweeps.charts.chart import Cells, Chart, Cloud, Curves
from sweeps.charts.colours import Colours
from sweeps.charts.curves import Curve
from sweeps.charts.jumps import break_line
from sweeps.charts.styles import BLACK
from sweeps.page.scales import (
    PALETTE,
    add_colour_bar,
    line_style,
    mapper_of,
    name_ticks,
    new_figure,
    put_legend_above,
    put_round_ticks,
)

_HEIGHT, _LOW = 460, 200  # pixels; a strip is low
_DOT, _SMALL_DOT, _FEW = 4.0, 2.0, 40  # pixels: of few points beyond the line, and of more
_POINT, _MARK = 7.0, 15.0  # pixels
CROSSES = 0.97
"""How far up missing points of curves are marked, as a part of the height."""


def draw(chart: Chart, height: int = _HEIGHT) -> figure:
    """Return the figure of a chart; what its colours are the page around it says: it may change."""
    drawn = _DRAWN_BY[type(chart)](chart, height)
    source = ColumnDataSource({"x": [], "y": []})
    for colour, width in (("white", 5.0), (BLACK, 2.5)):  # seen on any colour
        ring = {"fill_color": None, "line_color": colour, "line_width": width, "size": _MARK}
        drawn.scatter("x", "y", source=source, name="mark", **ring)
    return drawn


def _draw_cells(chart: Cells, height: int) -> figure:
    drawn = _figure(chart.across, chart.up, height)
    (left, right), (bottom, top) = ends_of(chart.across), ends_of(chart.up)
    mapper = mapper_of(chart.colours)
    drawn.image(
        image=[chart.image()], x=left, y=bottom, dw=right - left, dh=top - bottom,
        color_mapper=mapper, name="cells",
    )  # fmt: skip
    _add_scale(drawn, chart.colours, mapper)
    return drawn


def _draw_curves(chart: Curves, height: int) -> figure:
    drawn = _figure(chart.across, None, height, log=chart.log, y_range=Range1d(*chart.ends))
    drawn.extra_y_ranges = {"height": Range1d(0.0, 1.0)}
    for number, curve in enumerate(chart.curves):
        _draw_curve(drawn, chart.across, number, curve)
    drawn.yaxis.axis_label = plain(chart.label)
    if len(chart.curves) > 1:
        put_legend_above(drawn, columns=len(chart.curves), spacing=14)
        drawn.legend.click_policy = "hide"
    return drawn


def _draw_curve(drawn: figure, axis: Axis, number: int, curve: Curve) -> None:
    """Draw a curve with gaps at its jumps, dotted lines there, crosses for missing points."""
    style, across = curve.style(PALETTE), axis.quantity.values
    colour = {"color": style.colour}
    named = {"legend_label": plain(curve.label)} if curve.label else {}
    x, y = break_line(axis, curve.values, curve.jumps)
    source, look = ColumnDataSource({"x": x, "y": y}), line_style(style)
    drawn.line("x", "y", source=source, name=f"curve {number}", **look, **named)
    size = look["line_width"] + (_DOT if across.size <= _FEW else 0.0)
    dots = {"size": max(size, _SMALL_DOT), "fill_color": style.colour, "line_color": None}
    drawn.scatter("x", "y", source=source, **dots, **named)
    at = np.flatnonzero(curve.jumps)
    ends = {"x": axis.middles[at], "below": curve.values[at], "above": curve.values[at + 1]}
    drawn.segment(
        "x", "below", "x", "above", source=ColumnDataSource(ends), line_dash="dotted",
        name=f"jumps {number}", **colour,
    )  # fmt: skip
    lost = across[np.isnan(curve.values)]
    crosses = ColumnDataSource({"x": lost, "y": np.full(lost.size, CROSSES)})
    drawn.scatter(
        "x", "y", source=crosses, marker="x", size=8, y_range_name="height",
        name=f"missing {number}", **colour,
    )  # fmt: skip


def _draw_cloud(chart: Cloud, height: int) -> figure:
    kinds = ["log" if log else "linear" for log in chart.log]
    ends = {"y_range": Range1d(*chart.ends)} if chart.ends else {}
    drawn = new_figure(height=height, x_axis_type=kinds[0], y_axis_type=kinds[1], **ends)
    values = np.ma.filled(chart.values.astype(float), np.nan)
    data = {"x": chart.x, "y": chart.y, "value": values}
    mapper = mapper_of(chart.colours) if chart.colours else None
    colour = {"field": "value", "transform": mapper} if mapper else BLACK
    drawn.scatter(
        "x", "y", source=data, size=_POINT, fill_color=colour, line_color=None, name="cells"
    )
    drawn.xaxis.axis_label, drawn.yaxis.axis_label = map(plain, chart.labels)
    across_up = ((drawn.xaxis, chart.x), (drawn.yaxis, chart.y))
    for (side, numbers), log in zip(across_up, chart.log, strict=True):
        if log and not (side is drawn.yaxis and chart.ends):
            put_round_ticks(side, numbers.min(), numbers.max())
    if chart.colours:
        _add_scale(drawn, chart.colours, mapper)
    return drawn


def _add_scale(drawn: figure, colours: Colours, mapper: Any) -> None:
    """Put a scale of values beside a figure; kinds are named by the page around it (`legends`)."""
    if not colours.codes:
        add_colour_bar(drawn, mapper)


_DRAWN_BY: dict[type, Callable[[Any, int], figure]] = {
    Cells: _draw_cells,
    Curves: _draw_curves,
    Cloud: _draw_cloud,
}


def _figure(
    across: Axis, up: Axis | None, height: int, *, log: bool = False, **settings: Any
) -> figure:
    """Return an empty figure with the axes of a chart."""
    kinds = {"x_axis_type": "log" if across.geometric else "linear"}
    kinds["y_axis_type"] = "log" if log or (up is not None and up.geometric) else "linear"
    if up is not None:
        height = min(height, _LOW) if up.dim == STRIP else height
        settings["y_range"] = ends_of(up)
    drawn = new_figure(height=height, x_range=ends_of(across), **kinds, **settings)
    for axis, side in ((across, drawn.xaxis), (up, drawn.yaxis)):
        if axis is not None:
            name_ticks(side, axis)
    return drawn
