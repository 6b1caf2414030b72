"""Ticks, colours and legends of a chart."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from bokeh.models import ColorBar, ColorMapper, FixedTicker, LinearColorMapper, LogColorMapper
from bokeh.plotting import figure
from matplotlib.colors import LogNorm, to_hex

from sweeps.figures.colours import Colours, code_name
from sweeps.figures.layout import Axis
from sweeps.figures.style import GREY
from sweeps.views.explore.chart.kinds import STRIP, ends_of
from sweeps.views.symbols import plain
from sweeps.views.ticks import round_numbers

_SHADES = 256


def name_ticks(side: Any, axis: Axis) -> None:
    """Ticks on a side of a figure: at round numbers, or with the names of points."""
    side.axis_label = None if axis.dim == STRIP else plain(axis.label)
    if axis.dim == STRIP:
        side.ticker = FixedTicker(ticks=[])
    elif axis.geometric:
        side.ticker = FixedTicker(ticks=round_numbers(*ends_of(axis)))
    if axis.names:
        places = axis.quantity.values.tolist()
        side.ticker = FixedTicker(ticks=places)
        names = [plain(name).replace(",\n", "\n") for name in axis.names]
        side.major_label_overrides = dict(zip(places, names, strict=True))


def mapper_of(colours: Colours) -> ColorMapper:
    """The colours of values, or of the places of codes, in the browser."""
    grey, count = to_hex(GREY), len(colours.codes)
    if count:
        kinds = [to_hex(colours.cmap(place)) for place in range(count)]
        return LinearColorMapper(palette=kinds, low=-0.5, high=count - 0.5, nan_color=grey)
    shades = [to_hex(colours.cmap(shade)) for shade in np.linspace(0.0, 1.0, _SHADES)]
    kind = LogColorMapper if isinstance(colours.norm, LogNorm) else LinearColorMapper
    low, high = colours.norm.vmin, colours.norm.vmax
    return kind(palette=shades, low=low, high=high, nan_color=grey)


def explain(drawn: figure, colours: Colours, mapper: ColorMapper) -> None:
    """A legend of the kinds or counts, or a scale of the values."""
    if not colours.codes:
        bar = ColorBar(color_mapper=mapper, title=plain(colours.label), width=12, padding=6)
        bar.update(title_text_font_style="normal", title_text_font_size="11px")
        drawn.add_layout(bar, "right")
        return
    nowhere = [math.nan]
    for colour, code in zip(mapper.palette, colours.codes, strict=True):
        name = code_name(colours.name, code)
        drawn.scatter(nowhere, nowhere, marker="square", size=10, color=colour, legend_label=name)
    put_legend_above(drawn, columns=3)


def put_legend_above(drawn: figure, columns: int) -> None:
    """Move the legend of a figure out of its frame, where it hides nothing."""
    legend = drawn.legend[0]
    legend.update(label_text_font_size="11px", border_line_alpha=0, padding=2, spacing=0)
    legend.update(ncols=columns, location="left", glyph_height=16, label_height=16)
    drawn.add_layout(legend, "above")
