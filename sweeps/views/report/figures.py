"""The empty figures of a page, which its scripts fill: maps, curves, points, orbits.

Sources and renderers are found by their names.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Literal

import numpy as np
import xarray as xr
from bokeh.layouts import column
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    FixedTicker,
    Legend,
    LinearColorMapper,
    LogColorMapper,
    Model,
    Span,
)

from sweeps.figures.curves import way_style
from sweeps.figures.labels import DIRECTIONS, shown
from sweeps.figures.layout import Axis
from sweeps.figures.style import BLACK, VERMILLION, CurveStyle, curve_style
from sweeps.views.report.frames import PIXELS, empty_source, lay_along, new_figure
from sweeps.views.report.payload import axis_label, palette
from sweeps.views.report.views import is_uniform
from sweeps.views.symbols import plain

Scale = Literal["linear", "log", "kinds"]

SCALES: tuple[Scale, ...] = ("linear", "log", "kinds")
"""Of the variable that goes up; kinds have names instead of numbers."""

COURSES = ("lower_displacement", "lower_velocity", "elastic_stress", "friction_force")
"""What is drawn of an orbit, against the time."""

_MAP, _CURVES, _ALONG, _PORTRAIT, _COURSE, _LABELS = 560, 480, 276, 440, 136, 32  # pixels high
_CELL = ("left", "right", "bottom", "top")
_MARK, _SMALL_MARK, _POINT, _CROSS, _RING = 5, 4, 6, 8, 12  # pixels


def map_figure(x: Axis, y: Axis) -> Model:
    """A map over two axes, with an outline around the cell that is pinned."""
    log = [way for way, axis in (("x", x), ("y", y)) if axis.geometric]
    drawn = new_figure(_MAP, (axis_label(x), axis_label(y)), log=log)
    lay_along(drawn, "x", x)
    lay_along(drawn, "y", y)
    if is_uniform(x) and is_uniform(y):
        one = {"x": [0.0], "y": [0.0], "dw": [1.0], "dh": [1.0]}
        image = [np.zeros((1, 1), dtype=np.uint32)]  # the scripts make others of its class
        cells = ColumnDataSource({**one, "image": image}, name="cells")
        drawn.image_rgba("image", "x", "y", "dw", "dh", source=cells)
    else:
        cells = empty_source("cells", *_CELL, "colour")
        drawn.quad(*_CELL, source=cells, color="colour")
    _add_outline(drawn)
    _add_orbits(drawn, _MARK)
    _add_colour_bars(drawn)
    return drawn


def _add_outline(drawn: Any) -> None:
    source = empty_source("pinned", *_CELL)
    for colour, width in (("white", 4.0), (BLACK, 2.0)):  # seen on any colour
        drawn.quad(*_CELL, source=source, fill_alpha=0.0, line_color=colour, line_width=width)


def _add_orbits(drawn: Any, size: int, fill: str | None = "white") -> None:
    """Marks of the points that have an orbit in the page."""
    source = empty_source("orbits", "x", "y")
    drawn.scatter("x", "y", source=source, size=size, fill_color=fill, line_color=BLACK)


def _add_colour_bars(drawn: Any) -> None:
    """One for each scale; the scripts show the one that is needed and set its range."""
    for name, mapper in (("linear", LinearColorMapper), ("log", LogColorMapper)):
        colours = mapper(palette=palette(), low=1.0, high=10.0)
        bar = ColorBar(color_mapper=colours, name=f"{name} bar", width=14, visible=False)
        drawn.add_layout(bar, "right")


def curves_figure(
    axis: Axis, scale: Scale, names: Sequence[str] = (), *, ways: bool = False, tall: bool = False
) -> Model:
    """A variable along an axis: a curve for each name or the only one, up and down for `ways`."""
    log = ["x"] * axis.geometric + ["y"] * (scale == "log")
    drawn = new_figure(_CURVES if tall else _ALONG, (axis_label(axis), ""), log=log)
    lay_along(drawn, "x", axis)
    _prepare_height(drawn, scale)
    styles = [curve_style(place, max(1, len(names))) for place in range(max(1, len(names)))]
    directions = list(DIRECTIONS) if ways else ["up"]
    curves = [(style, way) for style in styles for way in directions]
    lines = [_add_curve(drawn, number, way_style(*curve)) for number, curve in enumerate(curves)]
    drawn.add_layout(Span(dimension="height", name="pinned", line_color="#555555", visible=False))
    _add_ring(drawn)
    _add_orbits(drawn, _SMALL_MARK)
    if len(lines) > 1:
        drawn.add_layout(_legend(lines, names, directions), "above")
    return drawn


def _prepare_height(drawn: Any, scale: Scale) -> None:
    drawn.yaxis.name = "height"
    if scale == "kinds":
        drawn.yaxis.ticker = FixedTicker(ticks=[])


def _add_curve(drawn: Any, number: int, style: CurveStyle) -> Any:
    """A curve with gaps at its jumps, dotted lines there, dots, crosses for missing points."""
    line, dots = (empty_source(f"{part} {number}", "x", "y") for part in ("line", "dots"))
    drawn.segment(
        "x",
        "below",
        "x",
        "above",
        line_color=style.colour,
        line_dash="dotted",
        source=empty_source(f"jumps {number}", "x", "below", "above"),
    )
    drawn.scatter(
        "x",
        "y",
        marker="x",
        size=_CROSS,
        line_color=style.colour,
        source=empty_source(f"crosses {number}", "x", "y"),
    )
    size = 3.0 + 1.5 * style.width
    drawn.scatter("x", "y", source=dots, size=size, color=style.colour)
    width = style.width * PIXELS
    return drawn.line(
        "x", "y", source=line, line_color=style.colour, line_width=width, line_dash=_dashes(style)
    )


def _dashes(style: CurveStyle) -> list[int]:
    """The dash pattern in pixels; printed ones are in widths of the line."""
    pattern = () if isinstance(style.dashes, str) else style.dashes[1]
    return [max(1, round(part * style.width * PIXELS)) for part in pattern]


def _add_ring(drawn: Any) -> None:
    """A ring around the point of a curve, or of a cloud, that is pinned."""
    source, style = empty_source("ring", "x", "y"), {"fill_alpha": 0.0, "line_width": 2.0}
    drawn.scatter("x", "y", source=source, size=_RING, line_color=VERMILLION, **style)


def _legend(lines: Sequence[Any], names: Sequence[str], directions: Sequence[str]) -> Legend:
    """A name for each curve; where they go both ways, which is which."""
    each = len(directions)
    items = [(name, [*lines[each * at : each * (at + 1)]]) for at, name in enumerate(names)]
    if each > 1:
        items += [(DIRECTIONS[way], [line]) for way, line in zip(directions, lines, strict=False)]
    legend = Legend(items=items, orientation="horizontal", border_line_color=None)
    legend.update(click_policy="hide", label_text_font_size="12px", spacing=12, margin=2)
    return legend


def points_figure(
    x: xr.DataArray, y: xr.DataArray | None, scale: Scale, log: Sequence[str]
) -> Model:
    """Cases over a parameter and a variable, on this scale, or over two parameters."""
    up = "" if y is None else plain(shown(y).label)
    drawn = new_figure(_MAP, (plain(shown(x).label), up), log=log)
    if y is None:
        _prepare_height(drawn, scale)
    cloud = empty_source("cells", "x", "y", "colour")
    drawn.scatter("x", "y", source=cloud, size=_POINT, color="colour")
    _add_ring(drawn)
    _add_orbits(drawn, _CROSS, fill=None)
    _add_colour_bars(drawn)
    return drawn


def orbit_figures() -> Iterator[tuple[str, Model]]:
    """The phase portrait of an orbit, and its time courses one below the other."""
    labels = {name: _label(name) for name in ("elapsed_time", *COURSES)}
    x, v = COURSES[:2]
    portrait = new_figure(_PORTRAIT, (labels[x], labels[v]))
    portrait.line(x, v, source=empty_source("orbit", *labels), line_color=BLACK, line_width=1.4)
    yield "portrait", portrait
    source, courses = empty_source("orbit", *labels), []
    for name in (x, *COURSES[2:]):
        drawn = new_figure(_COURSE, ("", labels[name]))
        drawn.line("elapsed_time", name, source=source, line_color=BLACK, line_width=1.4)
        courses.append(drawn)
    for drawn in courses[1:]:
        drawn.x_range = courses[0].x_range
    for drawn in courses[:-1]:
        drawn.xaxis.major_label_text_font_size = "0px"
    courses[-1].update(height=_COURSE + _LABELS)
    courses[-1].xaxis.axis_label = labels["elapsed_time"]
    yield "courses", column(*courses, sizing_mode="stretch_width")


def _label(name: str) -> str:
    return plain(shown(xr.DataArray(0.0, name=name)).label)
