"""The figure of a chart, and the mark on it that shows which point is open."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.events import Tap
from bokeh.models import FixedTicker, HoverTool
from bokeh.plotting import figure

from stickslip.orbit import Orbit
from stickslip.variables import PARAMETERS
from sweeps.figures.labels import shown_number
from sweeps.figures.layout import Axis
from sweeps.views.explore.beginning import Opened
from sweeps.views.explore.chart.kinds import (
    STRIP,
    Cells,
    Chart,
    Cloud,
    Curves,
    Place,
    ends_of,
)
from sweeps.views.explore.chart.scales import (
    explain,
    mapper_of,
    name_ticks,
    put_legend_above,
)
from sweeps.views.explore.orbit_figures import new_figure
from sweeps.views.symbols import plain
from sweeps.views.ticks import round_numbers

_HEIGHT, _LOW = 460, 200  # pixels
_DOT, _SMALL_DOT, _FEW = 5.0, 2.0, 40  # pixels: of few points, and of more


class ChartFigure:
    """A figure of one chart; a click is told as the place of a point."""

    def __init__(self, chart: Chart, variable: str, clicked: Callable[[Place], None]) -> None:
        self.chart, self._variable = chart, variable
        self.figure = _DRAWN_BY[type(chart)](chart)
        self._mark = self.figure.scatter(
            [], [], size=15, fill_color=None, line_color="white", line_width=5, name="mark"
        )
        self._ring = self.figure.scatter(
            [], [], size=15, fill_color=None, line_color="black", line_width=2.5
        )
        self._ring.data_source = self._mark.data_source

        def tap(event: Tap) -> None:
            if event.x is not None and event.y is not None:
                place = chart.place_at(float(event.x), float(event.y))
                if place is not None:
                    clicked(place)

        self.figure.on_event(Tap, tap)

    def mark(self, opened: Opened, orbit: Orbit | None) -> None:
        """Mark the place of a point, dashed where it is none of the file."""
        spot = _spot(self.chart, self._variable, opened, orbit)
        known = all(value is not None and np.isfinite(value) for value in spot)
        x, y = ([value] if known else [] for value in spot)
        self._mark.data_source.data = {"x": x, "y": y}
        self._ring.glyph.line_dash = [] if opened.place is not None else [3, 2]


def _draw_cells(chart: Cells) -> figure:
    drawn = _figure(chart.across, chart.up)
    (left, right), (bottom, top) = ends_of(chart.across), ends_of(chart.up)
    mapper = mapper_of(chart.colours)
    image = drawn.image(
        image=[chart.image()], x=left, y=bottom, dw=right - left, dh=top - bottom,
        color_mapper=mapper,
    )  # fmt: skip
    explain(drawn, chart.colours, mapper)
    if not chart.colours.codes:
        tips = [(plain(chart.colours.label), "@image")]
        drawn.add_tools(HoverTool(renderers=[image], tooltips=tips))
    return drawn


def _draw_curves(chart: Curves) -> figure:
    drawn = _figure(chart.across, None, log=chart.log)
    for curve in chart.curves:
        dashes = [] if curve.style.dashes == "solid" else [5, 4]
        line: dict[str, Any] = {"line_color": curve.style.colour, "line_dash": dashes}
        named = {"legend_label": curve.label} if curve.label else {}
        x = chart.across.quantity.values
        drawn.line(x, curve.values, line_width=1.4 * curve.style.width, **line, **named)
        size = _DOT if x.size <= _FEW else _SMALL_DOT
        drawn.scatter(x, curve.values, size=size, color=curve.style.colour)
    drawn.yaxis.axis_label = chart.label
    if len(chart.curves) > 1:
        put_legend_above(drawn, columns=1)
    return drawn


def _draw_cloud(chart: Cloud) -> figure:
    kinds = ["log" if geometric else "linear" for geometric in chart.geometric]
    drawn = new_figure(height=_HEIGHT, x_axis_type=kinds[0], y_axis_type=kinds[1])
    values = np.ma.filled(chart.values.astype(float), np.nan)
    data = {"x": chart.x, "y": chart.y, "value": values}
    mapper = mapper_of(chart.colours)
    colour = {"field": "value", "transform": mapper}
    drawn.scatter("x", "y", source=data, size=1.4 * _DOT, fill_color=colour, line_color=None)
    drawn.xaxis.axis_label, drawn.yaxis.axis_label = chart.labels
    for side, values, log in zip(drawn.axis, (chart.x, chart.y), chart.geometric, strict=True):
        if log:
            side.ticker = FixedTicker(ticks=round_numbers(values.min(), values.max()))
    explain(drawn, chart.colours, mapper)
    return drawn


_DRAWN_BY: dict[type, Callable[[Any], figure]] = {
    Cells: _draw_cells,
    Curves: _draw_curves,
    Cloud: _draw_cloud,
}


def _figure(across: Axis, up: Axis | None, *, log: bool = False) -> figure:
    """An empty figure with the axes of a chart."""
    kinds = {"x_axis_type": "log" if across.geometric else "linear"}
    kinds["y_axis_type"] = "log" if log or (up is not None and up.geometric) else "linear"
    height = _HEIGHT if up is None or up.dim != STRIP else _LOW
    ends = {"x_range": ends_of(across)} | ({"y_range": ends_of(up)} if up is not None else {})
    drawn = new_figure(height=height, **kinds, **ends)
    for axis, side in ((across, drawn.xaxis), (up, drawn.yaxis)):
        if axis is not None:
            name_ticks(side, axis)
    return drawn


def _spot(
    chart: Chart, variable: str, opened: Opened, orbit: Orbit | None
) -> tuple[float | None, float | None]:
    """Where a point lies in a chart; None for what the chart does not tell."""
    parameters = opened.point.parameters._asdict()
    if isinstance(chart, Cloud):
        across, up = chart.names
        return _shown(across, parameters[across]), _shown(up, parameters[up])
    x = _coordinate(chart.across, opened)
    if isinstance(chart, Curves):
        return x, None if orbit is None else _shown(variable, getattr(orbit, variable))
    return x, _coordinate(chart.up, opened)


def _coordinate(axis: Axis, opened: Opened) -> float | None:
    if axis.dim in PARAMETERS and not axis.names:
        return _shown(axis.dim, opened.point.parameters._asdict()[axis.dim])
    if axis.dim not in (opened.place or {}):
        return 0.0 if axis.quantity.values.size == 1 else None
    index = axis.order.tolist().index((opened.place or {})[axis.dim])
    return float(axis.quantity.values[index])


def _shown(name: str, value: float) -> float:
    return float(shown_number(name, value).values)
