"""What is drawn of a result, and which of its points is meant by a place in the picture.

A chart is a map of cells, some curves, or a cloud of points; all numbers are in shown units.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import xarray as xr

from sweeps.figures.colours import Colours, colours_of, is_discrete
from sweeps.figures.labels import (
    DIRECTION,
    DIRECTIONS,
    Array,
    legend_label,
    parameters_along,
    shown,
)
from sweeps.figures.layout import Axis, Layout, axis_of, layout_of
from sweeps.figures.maps import cell_edges
from sweeps.figures.missing import trusted
from sweeps.figures.options import PlotOptions
from sweeps.figures.scatter import cases_to_scatter
from sweeps.figures.style import CurveStyle, curve_style, styled
from sweeps.grid import CASE
from sweeps.views.symbols import plain

Place: TypeAlias = dict[str, int]

STRIP = "strip"  # the axis without extent of kinds along a single axis
_FINEST = 800  # pixels of a map whose cells are not all of one size


@dataclass(frozen=True)
class Choice:
    """What of a result is to be drawn; `places` are those along the axes that find no room."""

    variable: str
    across: str | None = None
    up: str | None = None
    log: bool = False
    places: Mapping[str, int] = field(default_factory=dict)

    @property
    def options(self) -> PlotOptions:
        """The same as an option of `plot`."""
        return PlotOptions(variable=self.variable, x=self.across, y=self.up)


@dataclass(frozen=True)
class Cells:
    """A map: a cell for each point of two axes."""

    across: Axis
    up: Axis
    colours: Colours
    values: Array
    places: Place

    def place_at(self, x: float, y: float) -> Place | None:
        """The place of the point whose cell is there."""
        place = dict(self.places)
        for axis, value in ((self.across, x), (self.up, y)):
            index = int(np.searchsorted(cell_edges(axis), value)) - 1
            if not 0 <= index < len(axis.order):
                return None
            if axis.dim != STRIP:
                place[axis.dim] = int(axis.order[index])
        return place

    def image(self) -> Array:
        """The values (up, across) on pixels of one size on the scales of the axes."""
        rows, columns = (_cells_of_pixels(axis) for axis in (self.up, self.across))
        values = np.ma.filled(self.values.astype(np.float32), np.nan)
        return np.asarray(values[np.ix_(rows, columns)])


@dataclass(frozen=True)
class Curve:
    """One curve: values over the axis, and its place along the other axes."""

    label: str
    style: CurveStyle
    values: Array
    places: Place


@dataclass(frozen=True)
class Curves:
    """Curves over one axis."""

    across: Axis
    label: str
    curves: tuple[Curve, ...]
    log: bool

    def place_at(self, x: float, y: float) -> Place | None:
        """The place of the point of the nearest curve at the nearest value of the axis."""
        index = _nearest(self.across, x)
        heights = np.array([curve.values[index] for curve in self.curves])
        distances = np.abs(np.nan_to_num(heights, nan=np.inf) - y)
        if not np.isfinite(distances).any():
            return None
        curve = self.curves[int(np.argmin(distances))]
        return curve.places | {self.across.dim: int(self.across.order[index])}


@dataclass(frozen=True)
class Cloud:
    """Linked cases in no order: points over two parameters."""

    names: tuple[str, str]
    x: Array
    y: Array
    labels: tuple[str, str]
    colours: Colours
    values: Array
    places: Place

    def place_at(self, x: float, y: float) -> Place | None:
        """The place of the nearest point, as it is seen: both ranges are of one length."""
        near = [(values - value) / np.ptp(values) for values, value in ((self.x, x), (self.y, y))]
        return {**self.places, CASE: int(np.argmin(np.hypot(*near)))}


Chart: TypeAlias = Cells | Curves | Cloud


def chart_of(result: xr.Dataset, choice: Choice) -> Chart:
    """The chart of a result; raises ValueError for axes that cannot be drawn so."""
    with styled():  # the colours of the house, whatever the settings of matplotlib
        return _chart_of(result, choice)


def _chart_of(result: xr.Dataset, choice: Choice) -> Chart:
    further = further_axes(result, choice)
    places = {dim: choice.places.get(dim, 0) for dim in further}
    part = result.isel(places)
    if is_cloud(result, choice):
        return _cloud(result, part, choice, places)
    layout = _layout(result, choice)
    if layout.y or is_discrete(result, choice.variable):
        return _cells(result, part, layout, choice, places)
    return _curves(part, layout, choice, places)


def further_axes(result: xr.Dataset, choice: Choice) -> list[str]:
    """The axes of a result that have no room in its chart, and are cut somewhere."""
    if is_cloud(result, choice):
        taken: tuple[str, ...] = (CASE,)
    else:
        layout = _layout(result, choice)
        ways = (DIRECTION,) if layout.both_ways else ()
        taken = tuple(dim for dim in (layout.x, layout.y, layout.hue, *ways) if dim)
    return [str(dim) for dim, size in result.sizes.items() if size > 1 and dim not in taken]


def axes_to_choose(result: xr.Dataset) -> list[str]:
    """What may lie across or upward; nothing where there is no choice."""
    if is_cloud(result, Choice("status")):
        names = parameters_along(result, CASE)
    else:
        names = [str(dim) for dim, size in result.sizes.items() if size > 1 and dim != DIRECTION]
    return names if len(names) > 2 else []


def is_cloud(result: xr.Dataset, choice: Choice) -> bool:
    """Whether the chart is one of points: linked cases in no order, of two parameters or more."""
    if CASE not in result.sizes or len(parameters_along(result, CASE)) < 2:
        return False
    return cases_to_scatter(result, PlotOptions(x=choice.across, y=choice.up))


def _layout(result: xr.Dataset, choice: Choice) -> Layout:
    discrete = is_discrete(result, choice.variable)
    return layout_of(result, choice.options, discrete=discrete)


def _cells(
    result: xr.Dataset, part: xr.Dataset, layout: Layout, choice: Choice, places: Place
) -> Cells:
    if layout.y is None:
        part = part.expand_dims(STRIP)
    across = axis_of(part, str(layout.x))
    up = axis_of(part, layout.y or STRIP, named=True)
    colours = colours_of(result, choice.variable, log=choice.log)
    part = part.isel({across.dim: across.order, up.dim: up.order})
    values = colours.placed(part.transpose(up.dim, across.dim))
    return Cells(across, up, colours, values, places)


def _curves(part: xr.Dataset, layout: Layout, choice: Choice, places: Place) -> Curves:
    axis = axis_of(part, str(layout.x))
    part = part.isel({axis.dim: axis.order})
    hues = range(part.sizes[layout.hue]) if layout.hue else [None]
    ways = range(part.sizes[DIRECTION]) if layout.both_ways else [None]
    curves = []
    for hue, way in itertools.product(hues, ways):
        own: Place = {} if hue is None else {str(layout.hue): hue}
        own |= {} if way is None else {DIRECTION: way}
        values = shown(trusted(part.isel(own), choice.variable)).values
        label, style = _called(part, layout, own), curve_style(hue or 0, len(hues))
        style = style._replace(dashes=(0, (4.0, 3.0)) if way else "solid")
        curves.append(Curve(label, style, values, places | own))
    return Curves(axis, plain(shown(part[choice.variable]).label), tuple(curves), choice.log)


def _called(part: xr.Dataset, layout: Layout, own: Place) -> str:
    names = [legend_label(part, layout.hue, own[layout.hue])] if layout.hue in own else []
    if DIRECTION in own:
        way = str(part[DIRECTION].values[own[DIRECTION]])
        names.append(DIRECTIONS.get(way, way))
    return plain(", ".join(names))


def _cloud(result: xr.Dataset, part: xr.Dataset, choice: Choice, places: Place) -> Cloud:
    along = parameters_along(result, CASE)
    across = choice.across or next(name for name in along if name != choice.up)
    up = choice.up or next(name for name in along if name != across)
    if across == up:
        raise ValueError(f"{across} lies across already; choose another parameter upward")
    x, y = shown(part[across]), shown(part[up])
    colours = colours_of(result, choice.variable, log=choice.log)
    labels = plain(x.label), plain(y.label)
    values = colours.placed(part)
    return Cloud((across, up), x.values, y.values, labels, colours, values, places)


def _nearest(axis: Axis, value: float) -> int:
    """The place on an axis that is nearest to a value, on its own scale."""
    return int(np.clip(np.searchsorted(axis.middles, value), 0, len(axis.order) - 1))


def _cells_of_pixels(axis: Axis) -> Array:
    """The cell that each pixel belongs to, of pixels that are evenly spread on the axis's scale."""
    edges = np.log(cell_edges(axis)) if axis.geometric else cell_edges(axis)
    widths = np.diff(edges)
    if np.allclose(widths, widths[0], rtol=1e-6, atol=0.0):
        return np.arange(len(widths))
    count = max(_FINEST, len(widths))
    middles = edges[0] + (np.arange(count) + 0.5) * (edges[-1] - edges[0]) / count
    return np.asarray(np.clip(np.searchsorted(edges, middles) - 1, 0, len(widths) - 1))
