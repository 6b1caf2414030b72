"""Empty figures, their ticks, colours and legends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from bokeh.models import (
    BasicTickFormatter,
    ColorBar,
    ColorMapper,
    DataRange1d,
    FixedTicker,
    Legend,
    LinearColorMapper,
    LogAxis,
    LogColorMapper,
)
from bokeh.palettes import Viridis256
from bokeh.plotting import figure

from stickslip.symbols import plain
from sweeps.charts.axes import STRIP, Axis, ends_of
from sweeps.charts.colours import Colours
from sweeps.charts.labels import shown
from sweeps.charts.styles import CURVES, GREY, CurveStyle, Palette

_DECADES = 4  # of an axis on which 2 and 5 are named too
_TEN = 9.9  # powers of ten alone follow one another by no less
_PIXELS = 96.0 / 72.0  # of a screen, in a point of a printed picture


def new_figure(**settings: Any) -> figure:
    """Return an empty figure in the style of the pages, as wide as its place."""
    empty = figure(
        sizing_mode="stretch_width",
        tools="pan,box_zoom,wheel_zoom,reset,save",
        toolbar_location="right",
        output_backend="canvas",
        min_border_left=60,  # panels above one another begin together
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
    """Return the look of a printed curve on a screen; its dashes are in widths of the line."""
    width = style.width * _PIXELS
    pattern = () if isinstance(style.dashes, str) else style.dashes[1]
    dashes = [max(1, round(part * width)) for part in pattern]
    return {"line_color": style.colour, "line_width": width, "line_dash": dashes}


def name_ticks(side: Any, axis: Axis) -> None:
    """Put ticks on a side of a figure: at round numbers, or with the names of points."""
    side.axis_label = None if axis.dim == STRIP else plain(axis.label)
    if axis.dim == STRIP:
        side.ticker = FixedTicker(ticks=[])
    elif axis.geometric:
        put_round_ticks(side, *ends_of(axis))
    if axis.names:
        places = axis.quantity.values.tolist()
        side.ticker = FixedTicker(ticks=places)
        names = [plain(name).replace(",\n", "\n") for name in axis.names]
        side.major_label_overrides = dict(zip(places, names, strict=True))


def put_round_ticks(side: Any, low: float, high: float) -> None:
    """Put ticks on a logarithmic side of a figure; Bokeh would write 20000 as 2.000e+4."""
    numbers = round_numbers(low, high)
    side.ticker = FixedTicker(ticks=numbers)
    if len(numbers) > 1 and numbers[1] / numbers[0] < _TEN:
        side.major_label_overrides = {n: plain(shown(xr.DataArray(n)).value) for n in numbers}


def round_numbers(low: float, high: float) -> list[float]:
    """Return 1, 2, 5, 10 ... over a range; powers of ten where it is long."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    mantissas = (1, 2, 5) if last - first <= _DECADES else (1,)
    numbers = [mantissa * 10.0**power for power in range(first, last + 1) for mantissa in mantissas]
    return [number for number in numbers if low <= number <= high]


def mapper_of(colours: Colours) -> ColorMapper:
    """Return the colours of values, or of the places of codes, in the browser."""
    kind = LogColorMapper if colours.log else LinearColorMapper
    look = {"palette": palette_of(colours), "nan_color": GREY}
    return kind(low=colours.low, high=colours.high, **look)


def palette_of(colours: Colours) -> list[str]:
    """Return a colour for each code, or those of a scale of values from low to high."""
    if colours.is_named and colours.codes:
        return colours.kinds
    count = len(colours.codes) or len(Viridis256)
    return [shade(place) for place in np.linspace(0.0, 1.0, count).tolist()]


def shade(place: float) -> str:
    """Return the colour of a value, from 0 to 1."""
    return str(Viridis256[min(int(place * len(Viridis256)), len(Viridis256) - 1)])


PALETTE = Palette([style.colour for style in CURVES], shade)


def add_colour_bar(drawn: figure, mapper: ColorMapper) -> None:
    """Put a scale of values beside a figure."""
    bar = ColorBar(color_mapper=mapper, width=12, padding=6)
    drawn.add_layout(bar, "right")


def put_legend_above(drawn: figure, columns: int, spacing: int = 0) -> None:
    """Move the legend of a figure out of its frame, where it hides nothing."""
    put_above(drawn, drawn.legend[0], columns, spacing)


def put_above(drawn: figure, legend: Legend, columns: int, spacing: int = 0) -> None:
    """Put a legend above the frame of a figure."""
    legend.update(label_text_font_size="11px", border_line_alpha=0, padding=2, spacing=spacing)
    legend.update(ncols=columns, location="left", glyph_height=16, label_height=16)
    drawn.add_layout(legend, "above")
