"""What all figures of a page share: their look, their axes, and how they are written into it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from bokeh.embed import json_item
from bokeh.models import ColumnDataSource, FixedTicker, Model, Range1d
from bokeh.plotting import figure

from sweeps.figures.layout import Axis
from sweeps.figures.maps import cell_edges
from sweeps.views.symbols import plain
from sweeps.views.ticks import round_numbers

PIXELS = 96.0 / 72.0
"""Of a screen, in a point of a printed picture."""

_TOOLS = "pan,box_zoom,wheel_zoom,reset,save"
_TEXT, _FRAME = "#222222", "#888888"


def new_figure(height: int, labels: tuple[str, str], *, log: Sequence[str] = ()) -> Any:
    """An empty figure, as wide as its place, whose ranges are set later.

    `labels` are those of its axes; `log` names logarithmic ones, of `x` and `y`.
    """
    drawn = figure(
        height=height,
        sizing_mode="stretch_width",
        x_axis_type="log" if "x" in log else "linear",
        y_axis_type="log" if "y" in log else "linear",
        x_range=Range1d(1.0, 10.0),
        y_range=Range1d(1.0, 10.0),
        tools=_TOOLS,
        active_drag=None,
    )
    drawn.toolbar.update(logo=None, autohide=True)
    drawn.outline_line_color = _FRAME
    drawn.grid.visible = False
    for axis, label in zip((drawn.xaxis, drawn.yaxis), labels, strict=True):
        axis.axis_label = label
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "14px"
        axis.major_label_text_font_size = "12px"
        axis.axis_label_text_color = axis.major_label_text_color = _TEXT
        axis.axis_line_color = axis.major_tick_line_color = axis.minor_tick_line_color = _FRAME
    return drawn


def lay_along(drawn: Any, way: str, axis: Axis) -> None:
    """Let an axis of a result be the x or the y axis of a figure."""
    edges = cell_edges(axis)
    getattr(drawn, f"{way}_range").update(start=float(edges[0]), end=float(edges[-1]))
    if axis.geometric:
        ticks = round_numbers(float(edges[0]), float(edges[-1]))
        getattr(drawn, f"{way}axis").ticker = FixedTicker(ticks=ticks)
    if axis.names:
        places = axis.quantity.values.tolist()
        names = dict(zip(places, map(plain, axis.names), strict=True))
        below = getattr(drawn, f"{way}axis")
        below.ticker = FixedTicker(ticks=places)
        below.major_label_overrides = names


def empty_source(name: str, *columns: str) -> ColumnDataSource:
    """A source without values, found by its name."""
    return ColumnDataSource({column: [] for column in columns}, name=name)


def written(model: Model) -> dict[str, Any]:
    """A figure as the script of a page takes it; the same figure is the same text in every run."""
    item: dict[str, Any] = dict(json_item(model))
    return dict(_renumbered(item, {}))


_NUMBER = re.compile(r"p\d+")


def _renumbered(part: Any, numbers: dict[str, str]) -> Any:
    """The same with models numbered from 0: the numbers count all that a process ever made."""
    if isinstance(part, dict):
        return {key: _renumbered_entry(key, value, numbers) for key, value in part.items()}
    if isinstance(part, (list, tuple)):
        return [_renumbered(value, numbers) for value in part]
    return part


def _renumbered_entry(key: str, value: Any, numbers: dict[str, str]) -> Any:
    if key in ("id", "root_id") and isinstance(value, str) and _NUMBER.fullmatch(value):
        return numbers.setdefault(value, f"p{len(numbers)}")
    return _renumbered(value, numbers)
