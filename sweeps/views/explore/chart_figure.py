"""The figure of a chart, and the mark on it that shows which point is open."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.events import Tap
from bokeh.models import (
    ColorBar,
    ColorMapper,
    FixedTicker,
    HoverTool,
    LinearColorMapper,
    LogColorMapper,
)
from bokeh.plotting import figure
from matplotlib.colors import to_hex

from stickslip.orbit import Orbit
from stickslip.variables import PARAMETERS
from sweeps.figures.colours import Colours, code_name
from sweeps.figures.labels import shown_number
from sweeps.figures.layout import Axis
from sweeps.figures.maps import cell_edges
from sweeps.figures.style import GREY
from sweeps.views.explore.beginning import Opened
from sweeps.views.explore.chart import (
    STRIP,
    Cells,
    Chart,
    Cloud,
    Curves,
    Place,
)
from sweeps.views.explore.pictures import new_figure
from sweeps.views.symbols import plain

_HEIGHT, _LOW = 460, 200  # pixels
_DECADES = 4  # of a logarithmic axis on which 2 and 5 are named too
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
    image = drawn.image(
        image=[chart.image()],
        x=cell_edges(chart.across)[0],
        y=cell_edges(chart.up)[0],
        dw=np.ptp(cell_edges(chart.across)),
        dh=np.ptp(cell_edges(chart.up)),
        color_mapper=_mapper(chart.colours),
    )
    _explain(drawn, chart.colours, image.glyph.color_mapper)
    if not chart.colours.codes:
        drawn.add_tools(
            HoverTool(renderers=[image], tooltips=[(plain(chart.colours.label), "@image")])
        )
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
        _put_legend_above(drawn, columns=1)
    return drawn


def _draw_cloud(chart: Cloud) -> figure:
    drawn = new_figure(height=_HEIGHT)
    values = np.ma.filled(chart.values.astype(float), np.nan)
    data = {"x": chart.x, "y": chart.y, "value": values}
    colour = {"field": "value", "transform": _mapper(chart.colours)}
    drawn.scatter("x", "y", source=data, size=1.4 * _DOT, fill_color=colour, line_color=None)
    drawn.xaxis.axis_label, drawn.yaxis.axis_label = chart.labels
    _explain(drawn, chart.colours, colour["transform"])
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
    ends = {"x_range": _ends(across)} | ({"y_range": _ends(up)} if up is not None else {})
    drawn = new_figure(height=height, **kinds, **ends)
    for axis, side in ((across, drawn.xaxis), (up, drawn.yaxis)):
        if axis is not None:
            side.axis_label = plain(axis.label)
            _name_ticks(side, axis)
    return drawn


def _ends(axis: Axis) -> tuple[float, float]:
    edges = cell_edges(axis)
    return float(edges[0]), float(edges[-1])


def _name_ticks(side: Any, axis: Axis) -> None:
    if axis.geometric:
        side.ticker = FixedTicker(ticks=_round_numbers(*_ends(axis)))
    if axis.dim == STRIP:
        side.axis_label = None
        side.ticker = FixedTicker(ticks=[])
    if axis.names:
        places = axis.quantity.values.tolist()
        side.ticker = FixedTicker(ticks=places)
        names = [plain(name).replace(",\n", "\n") for name in axis.names]
        side.major_label_overrides = dict(zip(places, names, strict=True))


def _round_numbers(low: float, high: float) -> list[float]:
    """1, 2, 5, 10 ... over a range; powers of ten where it is long."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    mantissas = (1, 2, 5) if last - first <= _DECADES else (1,)
    numbers = [mantissa * 10.0**power for power in range(first, last + 1) for mantissa in mantissas]
    return [number for number in numbers if low <= number <= high]


def _mapper(colours: Colours) -> ColorMapper:
    count = len(colours.codes) or 256
    palette = [to_hex(colours.cmap(i / max(count - 1, 1))) for i in range(count)]
    grey = to_hex(GREY)
    if colours.codes:
        palette = [to_hex(colours.cmap(i)) for i in range(count)]
        return LinearColorMapper(palette=palette, low=-0.5, high=count - 0.5, nan_color=grey)
    kind = LogColorMapper if type(colours.norm).__name__ == "LogNorm" else LinearColorMapper
    low, high = float(colours.norm.vmin or 0.0), float(colours.norm.vmax or 1.0)
    return kind(palette=palette, low=low, high=high, nan_color=grey)


def _explain(drawn: figure, colours: Colours, mapper: ColorMapper) -> None:
    """A legend of the kinds or counts, or a scale of the values."""
    if colours.codes:
        for place, code in enumerate(colours.codes):
            drawn.scatter(
                [np.nan], [np.nan], marker="square", size=10, color=mapper.palette[place],
                legend_label=code_name(colours.name, code),
            )  # fmt: skip
        _put_legend_above(drawn, columns=3)
        return
    bar = ColorBar(color_mapper=mapper, title=plain(colours.label), width=12, padding=6)
    bar.update(title_text_font_style="normal", title_text_font_size="11px")
    drawn.add_layout(bar, "right")


def _put_legend_above(drawn: figure, columns: int) -> None:
    legend = drawn.legend[0]
    legend.update(label_text_font_size="11px", border_line_alpha=0, padding=2, spacing=0)
    legend.update(ncols=columns, location="left", glyph_height=16, label_height=16)
    drawn.add_layout(legend, "above")


def _spot(
    chart: Chart, variable: str, opened: Opened, orbit: Orbit | None
) -> tuple[float | None, float | None]:
    """Where a point lies in a chart; None for what the chart does not tell."""
    parameters = opened.point.parameters._asdict()
    if isinstance(chart, Cloud):
        return _shown(chart.names[0], parameters[chart.names[0]]), _shown(
            chart.names[1], parameters[chart.names[1]]
        )
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
