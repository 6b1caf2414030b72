"""The choice of what to draw of a result, and as which kind of chart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr

from stickslip.symbols import plain
from stickslip.variables import RESULTS
from sweeps.figures.colours import colours_of, is_discrete
from sweeps.figures.curves import axis_limits, curves_of
from sweeps.figures.labels import parameters_along, shown
from sweeps.figures.layout import Layout, axis_of, layout_of
from sweeps.figures.maps import STRIP
from sweeps.figures.missing import trusted, value_range
from sweeps.figures.plot_options import PlotOptions
from sweeps.figures.scatter import cases_to_scatter, fits_log
from sweeps.figures.style import styled
from sweeps.grid import CASE, DIRECTION
from sweeps.views.charts.kinds import Cells, Chart, Cloud, Curves, Place


@dataclass(frozen=True)
class Choice:
    """A choice of what to draw; `places` are positions on the axes that are not shown.

    Of cases in no order `up` may be the variable itself: its values over a parameter.
    """

    variable: str
    across: str | None = None
    up: str | None = None
    log: bool = False
    places: Mapping[str, int] = field(default_factory=dict)

    @property
    def options(self) -> PlotOptions:
        """Return the same as an option of `plot`."""
        up = None if self.up == self.variable else self.up
        return PlotOptions(variable=self.variable, x=self.across, y=up)


def chart_of(result: xr.Dataset, choice: Choice) -> Chart:
    """Return the chart of a result; raises ValueError for axes that cannot be drawn so."""
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
    return _curves(result, part, layout, choice, places)


def further_axes(result: xr.Dataset, choice: Choice) -> list[str]:
    """Return the axes of a result that have no room in its chart, and are cut somewhere."""
    if is_cloud(result, choice):
        taken: tuple[str, ...] = (CASE,)
    else:
        layout = _layout(result, choice)
        ways = (DIRECTION,) if layout.both_ways else ()
        taken = tuple(dim for dim in (layout.x, layout.y, layout.hue, *ways) if dim)
    return [str(dim) for dim, size in result.sizes.items() if size > 1 and dim not in taken]


def axes_to_choose(result: xr.Dataset) -> list[str]:
    """Return what may lie across or upward; nothing where there is no choice."""
    if is_cloud(result, Choice("status")):
        names = parameters_along(result, CASE)
    else:
        names = [str(dim) for dim, size in result.sizes.items() if size > 1 and dim != DIRECTION]
    return names if len(names) > 2 else []


def is_cloud(result: xr.Dataset, choice: Choice) -> bool:
    """Return whether the chart is one of points: linked cases in no order."""
    return CASE in result.sizes and cases_to_scatter(result, choice.options)


def _layout(result: xr.Dataset, choice: Choice) -> Layout:
    discrete = is_discrete(result, choice.variable)
    layout = layout_of(result, choice.options, discrete=discrete)
    if discrete and layout.x and layout.y is None and result.sizes.get(DIRECTION, 1) > 1:
        return replace(layout, y=DIRECTION)  # a strip of kinds for each way
    return layout


def _cells(
    result: xr.Dataset, part: xr.Dataset, layout: Layout, choice: Choice, places: Place
) -> Cells:
    if layout.y is None:
        part = part.expand_dims(STRIP)
    across = axis_of(part, str(layout.x), named=True)
    up = axis_of(part, layout.y or STRIP, named=True)
    colours = colours_of(result, choice.variable, log=choice.log)
    part = part.isel({across.dim: across.order, up.dim: up.order})
    values = colours.placed(part.transpose(up.dim, across.dim))
    return Cells(across, up, colours, values, places)


def _curves(
    result: xr.Dataset, part: xr.Dataset, layout: Layout, choice: Choice, places: Place
) -> Curves:
    axis, name = axis_of(part, str(layout.x), named=True), choice.variable
    part = part.isel({axis.dim: axis.order})
    curves = []
    for curve in curves_of(part, layout, axis, name):
        # A logarithm has no place for what is not above 0.
        values = np.where(curve.values > 0.0, curve.values, np.nan) if choice.log else curve.values
        label, place = plain(curve.label), places | curve.places
        curves.append(replace(curve, label=label, values=values, places=place))
    ends = axis_limits(*value_range(result, name, log=choice.log), log=choice.log)
    return Curves(axis, plain(shown(part[name]).label), tuple(curves), ends, choice.log)


def _cloud(result: xr.Dataset, part: xr.Dataset, choice: Choice, places: Place) -> Cloud:
    along, variable = parameters_along(result, CASE), choice.variable
    across = choice.across or next(name for name in along if name != choice.up)
    up = choice.up or next((name for name in along if name != across), variable)
    if across == up:
        raise ValueError(f"{across} lies across already; choose another parameter upward")
    is_height = up in RESULTS
    x, y = shown(part[across]), shown(trusted(part, up) if is_height else part[up])
    coloured, log = ("regime", False) if is_height else (variable, choice.log)
    colours = colours_of(result, coloured, log=log) if coloured in result else None
    heights = value_range(result, variable, log=choice.log)
    return Cloud(
        names=(across, up),
        x=x.values,
        y=y.values,
        labels=(plain(x.label), plain(y.label)),
        log=(fits_log(x.values), choice.log if is_height else fits_log(y.values)),
        ends=axis_limits(*heights, log=choice.log) if is_height else None,
        colours=colours,
        values=colours.placed(part) if colours else np.zeros(x.values.size),
        places=places,
    )
