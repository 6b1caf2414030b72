"""The figures of a page: charts, borders on maps, and the motion at a point."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from bokeh.models import (
    BasicTickFormatter,
    ColorBar,
    ColorMapper,
    ColumnDataSource,
    DataRange1d,
    FixedTicker,
    HoverTool,
    Legend,
    LegendItem,
    LinearColorMapper,
    LogAxis,
    Range1d,
    Span,
)
from bokeh.palettes import Viridis256
from bokeh.plotting import figure

from stickslip.symbols import plain
from sweeps.charts.axes import STRIP, Axis, ends_of
from sweeps.charts.chart import (
    BORDER_STYLES,
    Cells,
    Chart,
    Cloud,
    Curve,
    Curves,
    border_parts,
)
from sweeps.charts.colours import (
    BLACK,
    CURVES,
    GREY,
    VERMILLION,
    Colours,
    CurveStyle,
    Palette,
    code_name,
)
from sweeps.charts.courses import ALONE
from sweeps.charts.labels import shown
from sweeps.page.turns import COURSES, DRAWN

_DECADES = 4  # a longer logarithmic axis has no ticks at 2 and 5
_TEN = 9.9  # the ratio of neighbouring ticks is at least this if they are powers of ten
_PIXELS = 96.0 / 72.0  # of a screen, per point of a printed picture


def new_figure(**settings: Any) -> figure:
    """Return an empty figure in the style of the pages, as wide as its host."""
    empty = figure(
        sizing_mode="stretch_width",
        tools="pan,box_zoom,wheel_zoom,reset,save",
        toolbar_location="right",
        output_backend="canvas",
        min_border_left=60,  # aligns panels above one another
        **settings,
    )
    empty.toolbar.update(logo=None, autohide=True)
    empty.grid.grid_line_alpha = 0.4
    for axis in empty.axis:
        axis.update(axis_label_text_font_style="normal", axis_label_text_font_size="14px")
        axis.update(major_label_text_font_size="12px", axis_label_standoff=4)
        axis.update(minor_tick_line_color=None)
        if not isinstance(axis, LogAxis):
            axis.formatter = BasicTickFormatter(power_limit_low=-4, power_limit_high=7)
    for ends in (empty.x_range, empty.y_range):
        if isinstance(ends, DataRange1d):
            ends.only_visible = True
    return empty


def line_style(style: CurveStyle) -> dict[str, Any]:
    """Return the look of a printed curve on a screen; its dashes are in units of the line width."""
    width = style.width * _PIXELS
    pattern = () if isinstance(style.dashes, str) else style.dashes[1]
    dashes = [max(1, round(part * width)) for part in pattern]
    return {"line_color": style.colour, "line_width": width, "line_dash": dashes}


def palette_of(colours: Colours) -> list[str]:
    """Return a colour for each code, or the colours of a scale of values from low to high."""
    if colours.is_named and colours.codes:
        return colours.kinds
    count = len(colours.codes) or len(Viridis256)
    return [shade(place) for place in np.linspace(0.0, 1.0, count).tolist()]


def shade(place: float) -> str:
    """Return the colour of a value between 0 and 1."""
    return str(Viridis256[min(int(place * len(Viridis256)), len(Viridis256) - 1)])


PALETTE = Palette([style.colour for style in CURVES], shade)


def add_colour_bar(drawn: figure, mapper: ColorMapper) -> None:
    """Put a colour bar beside a figure."""
    bar = ColorBar(color_mapper=mapper, width=12, padding=6)
    drawn.add_layout(bar, "right")


def _put_above(drawn: figure, legend: Legend, columns: int, spacing: int) -> None:
    """Put a legend above the frame of a figure."""
    legend.update(label_text_font_size="11px", border_line_alpha=0, padding=2, spacing=spacing)
    legend.update(ncols=columns, location="left", glyph_height=16, label_height=16)
    drawn.add_layout(legend, "above")


# --- charts ---------------------------------------------------------------------------------------

_LOW = 200  # pixels: the height of a strip
_DOT, _FEW = 4.0, 40  # pixels by which dots exceed the line, if there are at most this many
_SMALL_DOT = 2.0  # pixels: the smallest size if there are more
_POINT, _MARK = 7.0, 15.0  # pixels
CROSSES = 0.97
"""The height at which missing points of curves are marked, as a part of the panel's."""


def draw(chart: Chart, height: int, mapper: ColorMapper) -> figure:
    """Return the figure of a chart without its values, which the script of the page inserts.

    The script finds the renderers by name: `cells` of a map or of points; `curve 0` with its
    points, `jumps 0` and `missing 0` of curve 0, and so on; and `mark`, the ring around the open
    point. The script sets the colours of the `mapper`, except that points with a variable as their
    height keep the colours of their kinds. The page shows the legend.
    """
    if isinstance(chart, Cells):
        drawn = _draw_cells(chart, height, mapper)
    elif isinstance(chart, Curves):
        drawn = _draw_curves(chart, height)
    else:
        drawn = _draw_cloud(chart, height, mapper)
    source = ColumnDataSource({"x": [], "y": []})
    for colour, width in (("white", 5.0), (BLACK, 2.5)):  # visible on any colour
        ring = {"fill_color": None, "line_color": colour, "line_width": width, "size": _MARK}
        drawn.scatter("x", "y", source=source, name="mark", **ring)
    return drawn


def _draw_cells(chart: Cells, height: int, mapper: ColorMapper) -> figure:
    up = chart.up
    ends = {"x_range": ends_of(chart.across), "y_range": ends_of(up)}
    kinds = {"x_axis_type": _scale(chart.across.geometric), "y_axis_type": _scale(up.geometric)}
    drawn = new_figure(height=min(height, _LOW) if up.dim == STRIP else height, **ends, **kinds)
    _name_ticks(drawn.xaxis, chart.across)
    _name_ticks(drawn.yaxis, up)
    (left, right), (bottom, top) = ends.values()
    nothing, size = np.zeros((1, 1), np.float32), {"dw": right - left, "dh": top - bottom}
    drawn.image(image=[nothing], x=left, y=bottom, **size, color_mapper=mapper, name="cells")
    if not chart.colours.codes:
        add_colour_bar(drawn, mapper)
    return drawn


def _draw_curves(chart: Curves, height: int) -> figure:
    kinds = {"x_axis_type": _scale(chart.across.geometric), "y_axis_type": _scale(chart.log)}
    ends = {"x_range": ends_of(chart.across), "y_range": Range1d(*chart.ends)}
    drawn = new_figure(height=height, **ends, **kinds)
    _name_ticks(drawn.xaxis, chart.across)
    drawn.extra_y_ranges = {"height": Range1d(0.0, 1.0)}
    for number, curve in enumerate(chart.curves):
        _draw_curve(drawn, chart.across, number, curve)
    drawn.yaxis.axis_label = plain(chart.label)
    if len(chart.curves) > 1:
        _put_above(drawn, drawn.legend[0], len(chart.curves), 14)  # where it hides nothing
        drawn.legend.click_policy = "hide"
    return drawn


def _draw_curve(drawn: figure, axis: Axis, number: int, curve: Curve) -> None:
    """Draw a curve with its points, dotted lines at its jumps, crosses for missing points."""
    style = curve.style(PALETTE)
    colour = {"color": style.colour}
    named = {"legend_label": plain(curve.label)} if curve.label else {}
    source, look = ColumnDataSource({"x": [], "y": []}), line_style(style)
    drawn.line("x", "y", source=source, name=f"curve {number}", **look, **named)
    size = look["line_width"] + (_DOT if axis.order.size <= _FEW else 0.0)
    dots = {"size": max(size, _SMALL_DOT), "fill_color": style.colour, "line_color": None}
    drawn.scatter("x", "y", source=source, **dots, **named)
    jumps = ColumnDataSource({"x": [], "below": [], "above": []})
    dotted = {"line_dash": "dotted", "name": f"jumps {number}"}
    drawn.segment("x", "below", "x", "above", source=jumps, **dotted, **colour)
    crosses = {"marker": "x", "size": 8, "y_range_name": "height", "name": f"missing {number}"}
    drawn.scatter("x", "y", source=ColumnDataSource({"x": [], "y": []}), **crosses, **colour)


def _draw_cloud(chart: Cloud, height: int, mapper: ColorMapper) -> figure:
    kinds = dict(zip(("x_axis_type", "y_axis_type"), map(_scale, chart.log), strict=True))
    ends = {"y_range": Range1d(*chart.ends)} if chart.ends else {}
    drawn = new_figure(height=height, **kinds, **ends)
    columns = {
        "x": chart.x,
        "y": chart.y,
        "value": np.ma.filled(chart.values.astype(float), np.nan),
    }
    data = {name: np.float32(column) for name, column in columns.items()}
    fill: Any = BLACK
    if chart.colours:
        own = _mapper_of(chart.colours) if chart.ends else mapper
        fill = {"field": "value", "transform": own}
    look = {"size": _POINT, "fill_color": fill, "line_color": None}
    drawn.scatter("x", "y", source=data, **look, name="cells")
    drawn.xaxis.axis_label, drawn.yaxis.axis_label = map(plain, chart.labels)
    sides = (drawn.xaxis, drawn.yaxis), (chart.x, chart.y), chart.log
    for side, numbers, log in zip(*sides, strict=True):
        if log:
            _put_round_ticks(side, numbers.min(), numbers.max())
    if chart.colours and not chart.colours.codes:
        add_colour_bar(drawn, mapper)
    return drawn


def _scale(logarithmic: bool) -> str:
    return "log" if logarithmic else "linear"


def _name_ticks(side: Any, axis: Axis) -> None:
    """Put ticks at round numbers on a side of a figure, or label them with the names of points."""
    side.axis_label = None if axis.dim == STRIP else plain(axis.label)
    if axis.dim == STRIP:
        side.ticker = FixedTicker(ticks=[])
    elif axis.geometric:
        _put_round_ticks(side, *ends_of(axis))
    if axis.names:
        places = axis.quantity.values.tolist()
        side.ticker = FixedTicker(ticks=places)
        names = [plain(name).replace(",\n", "\n") for name in axis.names]
        side.major_label_overrides = dict(zip(places, names, strict=True))


def _put_round_ticks(side: Any, low: float, high: float) -> None:
    """Put ticks at 1, 2, 5, 10 ... on a logarithmic side, or at powers of ten if it is long."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    mantissas = (1, 2, 5) if last - first <= _DECADES else (1,)
    numbers = [mantissa * 10.0**power for power in range(first, last + 1) for mantissa in mantissas]
    numbers = [number for number in numbers if low <= number <= high]
    side.ticker = FixedTicker(ticks=numbers)
    if len(numbers) > 1 and numbers[1] / numbers[0] < _TEN:  # Bokeh would write 2.000e+4
        side.major_label_overrides = {n: plain(shown(xr.DataArray(n)).value) for n in numbers}


def _mapper_of(colours: Colours) -> ColorMapper:
    """Return the mapper from places of kinds to colours in the browser."""
    look = {"palette": palette_of(colours), "nan_color": GREY}
    return LinearColorMapper(low=colours.low, high=colours.high, **look)


# --- borders between kinds of motion on maps ------------------------------------------------------

_BORDER_WIDTH, _APART = 1.5, 24  # pixels: the width of a line; between the types in the legend
_COUNTS = ("orbit_periods", "melting_count")


def add_borders(drawn: figure, chart: Cells, borders: xr.Dataset) -> None:
    """Draw borders on the figure of a map over their axes.

    A click on the legend hides them. Pointing at a line shows the kinds on its two sides.
    """
    parts: dict[str, list[tuple[np.ndarray, str]]] = {name: [] for name in BORDER_STYLES}
    for places, points, name in border_parts(borders, chart.across.dim, chart.up.dim):
        first = borders.isel({borders["line"].dims[0]: points[0]})
        parts[name].append((places, " | ".join(_side(first, side) for side in ("left", "right"))))
    items, shapes = [], []
    for name, own in parts.items():
        if not own:
            continue
        data = {
            "x": [places[:, 0].tolist() for places, _ in own],
            "y": [places[:, 1].tolist() for places, _ in own],
            "between": [words for _, words in own],
            "type": [name] * len(own),
        }
        look = {"line_color": BLACK, "line_width": _BORDER_WIDTH, "line_cap": "round"}
        look["line_dash"] = BORDER_STYLES[name]
        source = ColumnDataSource(data)
        shapes.append(drawn.multi_line("x", "y", source=source, name=f"borders {name}", **look))
        items.append(LegendItem(label=f"border: {name}", renderers=shapes[-1:]))
    if shapes:
        tips = [("between", "@between"), ("border", "@type")]
        drawn.add_tools(HoverTool(renderers=shapes, tooltips=tips, line_policy="interp"))
        _put_above(drawn, Legend(items=items, click_policy="hide"), len(items), _APART)


def _side(point: xr.Dataset, side: str) -> str:
    """Return the kind of motion on one side, with its counts if the file has them."""
    words = [code_name("regime", int(point[f"kind_{side}"]))]
    for count in _COUNTS:
        if f"{count}_{side}" in point:
            name = code_name(count, int(point[f"{count}_{side}"]))
            words.append(f"{count.replace('_', ' ')} {name}")
    return ", ".join(words)


# --- the motion at a point ------------------------------------------------------------------------

_TIME, _X, _V = "elapsed_time", "lower_displacement", "lower_velocity"
_KEPT = CurveStyle(VERMILLION, 0.9)
_NOTHING = {name: np.zeros(2) for name in DRAWN}  # two points, because a browser wants a range

_PANEL_HEIGHT = 140  # pixels
_LEAST_STRESS = 2e-6  # MPa: smaller values are the noise floor of a liquid film
_AXIS = 24  # pixels below the lowest panel for the label of the time axis


def motion_figures(height: int) -> tuple[figure, list[figure]]:
    """Return the phase portrait, `height` pixels high, and the panels of the time courses.

    A motion kept for comparison lies beneath, in red.
    """
    motion = ColumnDataSource(_NOTHING, name="motion")
    kept = ColumnDataSource(_NOTHING, name="kept motion")
    labels = {name: plain(shown(xr.DataArray(0.0, name=name)).label) for name in DRAWN}
    beneath = {"source": kept, "level": "underlay", **line_style(_KEPT)}
    portrait = new_figure(height=height, name="portrait")
    for dimension in ("width", "height"):
        origin = Span(location=0.0, dimension=dimension, line_color="#cccccc", line_width=1)
        portrait.add_layout(origin)
    portrait.line(_X, _V, source=motion, **line_style(ALONE))
    portrait.line(_X, _V, **beneath)
    portrait.xaxis.ticker.desired_num_ticks = 4  # a narrow figure has no room for more
    portrait.xaxis.axis_label = f"displacement {labels[_X]}"
    portrait.yaxis.axis_label = f"velocity {labels[_V]}"
    panels = []
    for traces in COURSES:
        panel = new_figure(height=_PANEL_HEIGHT, name=traces[0].name)
        lines = [
            panel.line(_TIME, trace.name, source=motion, **line_style(trace.style))
            for trace in traces
        ]
        panel.line(_TIME, traces[0].name, **beneath)
        panel.yaxis.axis_label = labels[traces[0].name]
        if len(traces) > 1:
            names = zip(("lower block x", "upper block X"), lines, strict=True)
            items = [LegendItem(label=label, renderers=[line]) for label, line in names]
            legend = Legend(items=items, orientation="horizontal", location="right")
            legend.update(label_text_font_size="11px", border_line_alpha=0, margin=0, padding=0)
            legend.spacing = 16
            panel.add_layout(legend, "above")
            panel.height = _PANEL_HEIGHT + _AXIS
        panels.append(panel)
    for panel in panels[1:]:
        panel.x_range = panels[0].x_range
    for panel in panels[:-1]:
        panel.xaxis.major_label_text_font_size = "0pt"
    panels[-1].update(height=_PANEL_HEIGHT + _AXIS)
    panels[-1].xaxis.axis_label = labels[_TIME]
    panels[0].yaxis.axis_label = f"X, {labels[_X]}"
    panels[0].x_range.range_padding = 0.0
    panels[1].y_range.min_interval = _LEAST_STRESS
    return portrait, panels
