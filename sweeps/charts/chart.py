"""A chart of a result: cells, curves or points.

All numbers are in shown units.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
import xarray as xr

from stickslip.variables import RESULTS
from sweeps.charts.axes import STRIP, Axis, axis_of, cells_of_pixels
from sweeps.charts.choice import Choice
from sweeps.charts.clouds import cases_to_scatter, fits_log
from sweeps.charts.colours import Colours, colours_of, is_discrete
from sweeps.charts.curves import Curve, axis_limits, curves_of
from sweeps.charts.labels import Array, parameters_along, shown
from sweeps.charts.layout import Layout, layout_of
from sweeps.charts.missing import trusted, value_range
from sweeps.grid import CASE, DIRECTION

Place: TypeAlias = dict[str, int]


@dataclass(frozen=True)
class Cells:
    """A map: a cell for each point of two axes."""

    across: Axis
    up: Axis
    colours: Colours
    values: Array
    places: Place

    def image(self) -> Array:
        """Return the values (up, across) on pixels of one size on the scales of the axes."""
        rows, columns = (cells_of_pixels(axis) for axis in (self.up, self.across))
        values = np.ma.filled(self.values.astype(np.float32), np.nan)
        return np.asarray(values[np.ix_(rows, columns)])


@dataclass(frozen=True)
class Curves:
    """Curves over one axis; `ends` are those of the axis that goes up."""

    across: Axis
    label: str
    curves: tuple[Curve, ...]
    ends: tuple[float, float]
    log: bool


@dataclass(frozen=True)
class Cloud:
    """Linked cases in no order: points over two parameters, or over one and a variable.

    `ends` are those of the axis of a variable, on which what is drawn may change.
    """

    names: tuple[str, str]
    x: Array
    y: Array
    labels: tuple[str, str]
    log: tuple[bool, bool]
    ends: tuple[float, float] | None
    colours: Colours | None
    values: Array
    places: Place


Chart: TypeAlias = Cells | Curves | Cloud


def chart_of(
    result: xr.Dataset,
    choice: Choice,
    places: Mapping[str, int] = MappingProxyType({}),
    *,
    of_values: bool = False,
) -> Chart:
    """Return the chart of one variable of a result.

    Axes that find no room are cut at `places`, or at their first point. The ends of scales are
    those of the whole result, the same for every cut. Of cases in no order `of_values` puts the
    variable itself up, over a parameter. Raises ValueError for axes that cannot be drawn so.
    """
    (name,) = choice.variables
    cut = {dim: places.get(dim, 0) for dim in further_axes(result, choice)}
    part, log = result.isel(cut), bool(choice.scales & {"y", "z"})
    if is_cloud(result, choice):
        return _cloud_of_result(result, part, choice, cut, of_values=of_values)
    layout = _layout(result, choice)
    across = axis_of(part, str(layout.x), named=True)
    if layout.y or is_discrete(result, name):
        if layout.y is None:
            part = part.expand_dims(STRIP)
        up = axis_of(part, layout.y or STRIP, named=True)
        return cells_of(part, across, up, colours_of(result, name, log=log), cut)
    ends = axis_limits(*value_range(result, name, log=log), log=log)
    part = part.isel({across.dim: across.order})
    curves = [
        # A logarithm has no place for what is not above 0.
        replace(curve, values=np.where(curve.values > 0.0, curve.values, np.nan)) if log else curve
        for curve in curves_of(part, layout, across, name)
    ]
    placed = tuple(replace(curve, places=cut | curve.places) for curve in curves)
    return Curves(across, shown(part[name]).label, placed, ends, log)


def cells_of(
    part: xr.Dataset, across: Axis, up: Axis, colours: Colours, places: Mapping[str, int]
) -> Cells:
    """Return the map of a variable over two axes of a slice, which lies at `places`."""
    ordered = part.isel({across.dim: across.order, up.dim: up.order})
    values = colours.placed(ordered.transpose(up.dim, across.dim, ...))
    return Cells(across, up, colours, values, dict(places))


def cloud_of(
    part: xr.Dataset,
    names: tuple[str, str],
    colours: Colours | None,
    scales: frozenset[str] = frozenset(),
) -> Cloud:
    """Return the points of a slice over two parameters, or over one and a variable.

    A parameter has the scale that fits its values, unless `scales` asks for a logarithmic one.
    """
    up = names[1]
    is_height = up in RESULTS
    x, y = (shown(trusted(part, name) if name in RESULTS else part[name]) for name in names)
    log_up = bool(scales & {"y", "z"}) if is_height else "y" in scales or fits_log(y.values)
    return Cloud(
        names=names,
        x=x.values,
        y=y.values,
        labels=(x.label, y.label),
        log=("x" in scales or fits_log(x.values), log_up),
        ends=None,
        colours=colours,
        values=colours.placed(part) if colours else np.zeros(x.values.size),
        places={},
    )


def _cloud_of_result(
    result: xr.Dataset, part: xr.Dataset, choice: Choice, places: Place, *, of_values: bool
) -> Cloud:
    along, (variable,) = parameters_along(result, CASE), choice.variables
    across = choice.x or next(name for name in along if name != choice.y)
    others = (name for name in along if name != across)
    up = variable if of_values else choice.y or next(others, variable)
    if across == up:
        raise ValueError(f"{across} lies across already; choose another parameter upward")
    is_height, log = up in RESULTS, bool(choice.scales & {"y", "z"})
    coloured = "regime" if is_height else variable
    colours = None
    if coloured in result:
        colours = colours_of(result, coloured, log=log and not is_height)
    scales = frozenset("z") if log and is_height else frozenset()
    cloud = cloud_of(part, (across, up), colours, scales)
    ends = axis_limits(*value_range(result, variable, log=log), log=log) if is_height else None
    return replace(cloud, ends=ends, places=places)


def further_axes(result: xr.Dataset, choice: Choice) -> list[str]:
    """Return the axes of a result that have no room in its chart, and are cut somewhere."""
    if is_cloud(result, choice):
        taken: tuple[str, ...] = (CASE,)
    else:
        layout = _layout(result, choice)
        ways = (DIRECTION,) if layout.both_ways else ()
        taken = tuple(dim for dim in (layout.x, layout.y, layout.hue, *ways) if dim)
    return [str(dim) for dim, size in result.sizes.items() if size > 1 and dim not in taken]


def is_cloud(result: xr.Dataset, choice: Choice) -> bool:
    """Return whether the chart is one of points: linked cases in no order."""
    return CASE in result.sizes and cases_to_scatter(result, choice)


def _layout(result: xr.Dataset, choice: Choice) -> Layout:
    discrete = is_discrete(result, choice.variables[0])
    layout = layout_of(result, choice, discrete=discrete)
    if discrete and layout.x and layout.y is None and result.sizes.get(DIRECTION, 1) > 1:
        return replace(layout, y=DIRECTION)  # a strip of kinds for each way
    return layout
