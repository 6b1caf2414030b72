"""The charts of a page: its views, their figures, and the data that its script needs.

There are three scales: numbers, their logarithms, and kinds, which have colours instead. A map
needs one figure for all scales; other views need one for each. The script of the page inserts the
values of a variable and a slice.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import xarray as xr
from bokeh.models import (
    ColorMapper,
    CrosshairTool,
    LinearColorMapper,
    LogColorMapper,
    Model,
    SingleIntervalTicker,
    Span,
)
from bokeh.palettes import Viridis256

from sweeps.charts.axes import (
    STRIP,
    Axis,
    axis_of,
    cases_to_scatter,
    cell_edges,
    cells_of_pixels,
    is_scattered,
    layout_of,
)
from sweeps.charts.chart import Cells, Chart, Cloud, Curves, chart_of, further_axes
from sweeps.charts.choice import Choice
from sweeps.charts.colours import GREY, Colours
from sweeps.charts.labels import parameters_along
from sweeps.grid import CASE, DIRECTION
from sweeps.page.drawing import add_borders, add_colour_bar, draw
from sweeps.page.script_data import symbol_of

Sheet: TypeAlias = tuple[Model, dict[str, Any]]
"""A figure of a page, and the data that the script needs to fill it."""

SCALES = ("linear", "log", "kinds")
_TALL, _LOW = 540, 276  # pixels: the height of a view, and of a curve through a point of a map
# Pixels, of the mark of a point with an orbit in the page, inside its cell or around its dot.
_MARKS: dict[type, float] = {Cells: 3.0, Curves: 5.0, Cloud: 10.0}


@dataclass(frozen=True)
class View:
    """A way to look at a result; sliders set the axes that do not fit into the picture.

    `across` and `up` are axes or, for points, parameters; None selects the axes of the standard
    picture. With `of_values` the variable itself is on the vertical axis.
    """

    kind: str
    across: str | None = None
    up: str | None = None
    of_values: bool = False

    @property
    def key(self) -> str:
        """The name of the view in the address of the page."""
        return "-".join(name for name in (self.kind, self.across, self.up) if name)

    @property
    def label(self) -> str:
        """The name of the view in the menu."""
        return f"{self.kind} over {' and '.join(symbol_of(n) for n in (self.across, self.up) if n)}"

    def choice(self, variable: str, scale: str) -> Choice:
        """Return what to draw of the result; points of kinds lie over two parameters."""
        return Choice(variable, self.across, self.up, log="z" if scale == "log" else "")


def ordered(ds: xr.Dataset, *, named: bool = True) -> xr.Dataset:
    """Return the result with rising values along its axes and without dimensions of one point.

    Cases in no order stay as they are, and so do the points of short axes if they are `named`.
    """
    ds = ds.squeeze()
    rising = [dim for dim in map(str, ds["status"].dims) if not _is_unordered(ds, dim)]
    return ds.isel({dim: axis_of(ds, dim, named=named).order for dim in rising})


def views_of(ds: xr.Dataset) -> list[View]:
    """Return the views of a result, the standard picture first; a single point has none."""
    if cases_to_scatter(ds, Choice("status")):
        along = parameters_along(ds, CASE)
        maps = [View("points", x, y) for x, y in itertools.combinations(along, 2)]
        return [*(View("points", x, of_values=True) for x in along), *maps]
    layout = layout_of(ds)
    if layout.x is None:
        return []
    long_first = sorted(map(str, ds.sizes), key=lambda dim: -ds.sizes[dim])
    dims = [dim for dim in long_first if dim != DIRECTION and not _is_unordered(ds, dim)]
    pairs = list(itertools.combinations(dims, 2))
    if layout.y is None:
        return [View("curves", layout.x), *(View("map", *pair) for pair in pairs)]
    first = (layout.x, layout.y)
    others = [pair for pair in pairs if set(pair) != set(first)]
    return [View("map", *pair) for pair in (first, *others)]


def _is_unordered(ds: xr.Dataset, dim: str) -> bool:
    return dim == CASE and is_scattered(ds, dim)


def colour_mappers() -> dict[str, ColorMapper]:
    """Return the colour mapper of each scale; the script sets its ends, or the colours of kinds."""
    # With ends, or Bokeh would look for some among values that may have no logarithm.
    look = {"palette": Viridis256, "nan_color": GREY, "low": 1.0, "high": 10.0}
    linear = LinearColorMapper(name="colours linear", **look)
    return {"linear": linear, "log": LogColorMapper(name="colours log", **look), "kinds": linear}


def sheets_of(
    ds: xr.Dataset,
    view: View,
    variables: Mapping[str, Colours],
    mappers: Mapping[str, ColorMapper],
    borders: xr.Dataset | None = None,
) -> Iterator[tuple[str, Sheet]]:
    """Yield the sheet of a view for each scale; the borders are drawn on maps."""
    for scale, variable in _examples(variables):
        choice = view.choice(variable, scale)
        # Borders lie between the values of an axis, and names have no place there.
        named = borders is None or view.kind != "map"
        of_values = view.of_values and scale != "kinds"
        chart = chart_of(ds, choice, of_values=of_values, named=named)
        drawn, about = _sheet(ds, chart, f"{view.label}, {scale}", _TALL, mappers[scale])
        about["sliders"] = [_place(ds, dim) for dim in further_axes(ds, choice)]
        _add_marks(drawn, chart)
        if view.kind == "map":
            if scale == "linear":
                # Bokeh does not repaint an image when its mapper is replaced, so the figure has
                # two images, of which the script shows one.
                cells, *others = drawn.renderers
                glyph = cells.glyph.clone(color_mapper=mappers["log"])
                # Marks lie above both.
                drawn.renderers = [cells, drawn.add_glyph(cells.data_source, glyph), *others]
                add_colour_bar(drawn, mappers["log"])
            if borders is not None and isinstance(chart, Cells):
                add_borders(drawn, chart, borders)
            yield from dict.fromkeys(SCALES, (drawn, about)).items()
            return
        yield scale, (drawn, about)


def sheets_along(
    ds: xr.Dataset, dim: str, variables: Mapping[str, Colours], mappers: Mapping[str, ColorMapper]
) -> Iterator[tuple[str, Sheet]]:
    """Yield, for each scale, the sheet of a curve along an axis through a point of a map."""
    for scale, variable in _examples(variables):
        line = ds.isel({other: [0] for other in ds.sizes if other != dim})
        chart = chart_of(line.squeeze(), Choice(variable, log="z" if scale == "log" else ""))
        yield scale, _sheet(ds, chart, f"along {dim}, {scale}", _LOW, mappers[scale])


def _examples(variables: Mapping[str, Colours]) -> Iterator[tuple[str, str]]:
    """Yield each scale, with a variable that is drawn on it, if there is such a variable."""
    for scale in SCALES:
        of_kinds = scale == "kinds"
        of_scale = [name for name, c in variables.items() if bool(c.codes) == of_kinds]
        if of_scale:
            yield scale, of_scale[0]


def _sheet(ds: xr.Dataset, chart: Chart, name: str, height: int, mapper: ColorMapper) -> Sheet:
    figure = draw(chart, height, mapper)
    figure.name = name
    about: dict[str, Any] = {"figure": name}
    if isinstance(chart, Cells):
        about |= {"kind": "cells", "x": _ruler(ds, chart.across), "y": _ruler(ds, chart.up)}
    elif isinstance(chart, Curves):
        fixed = [[[_place(ds, dim), at] for dim, at in c.places.items()] for c in chart.curves]
        about |= {"kind": "curves", "x": _ruler(ds, chart.across), "curves": fixed}
    else:
        about |= {"kind": "cloud", "axis": _place(ds, CASE), "heights": chart.ends is not None}
        about["log"] = list(chart.log)
        about["names"] = [chart.names[0], "" if chart.ends else chart.names[1]]
        if chart.names[1] in ("regime", "status"):  # kinds as heights have names
            figure.yaxis.ticker = SingleIntervalTicker(interval=1)
    return figure, about


def _ruler(ds: xr.Dataset, axis: Axis) -> dict[str, Any]:
    """Return where the points of an axis are, and the point that each pixel of a map shows."""
    pixels = cells_of_pixels(axis)
    is_even = pixels.size == axis.order.size
    return {
        "axis": -1 if axis.dim == STRIP else _place(ds, axis.dim),
        "places": axis.quantity.values.tolist(),
        "edges": cell_edges(axis).tolist(),
        "pixels": None if is_even else pixels.tolist(),
    }


def _place(ds: xr.Dataset, dim: str) -> int:
    return list(ds["status"].dims).index(dim)


def _add_marks(figure: Any, chart: Chart) -> None:
    """Mark the points that have an orbit in the page."""
    size, fill = _MARKS[type(chart)], None if isinstance(chart, Cloud) else "white"
    figure.scatter([], [], size=size, fill_color=fill, line_color="black", name="orbits")
    if isinstance(chart, Cells):
        look = {"level": "overlay", "line_alpha": 0.5}
        lines = tuple(Span(dimension=way, **look) for way in ("width", "height"))
        figure.add_tools(CrosshairTool(overlay=lines, name="crosshair"))
