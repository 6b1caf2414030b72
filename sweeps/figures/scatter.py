"""Linked cases in no order, such as random ones: points against each parameter that they vary."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.variables import RESULTS, canonical_name
from sweeps.figures.colours import Colours, colours_of, is_discrete
from sweeps.figures.labels import Array, parameters_along, shown
from sweeps.figures.layout import MANY, is_scattered
from sweeps.figures.missing import missing_notes, trusted
from sweeps.figures.plot_options import ROLES, PlotOptions, slice_in_the_middle
from sweeps.figures.style import (
    BLACK,
    PAGE,
    make_logarithmic,
    new_panels,
    put_legend,
    put_note,
    width_of,
)
from sweeps.grid import CASE

_ROW, _FRAME = 2.0, 0.7  # inches: a row of panels, what is above and below them
_AREA = 9.0  # square points of a dot where there are few; many are smaller
_WIDE = 5.0  # largest over smallest value: from here on a logarithmic axis may fit better


class _Cloud(NamedTuple):
    """The contents of a panel: the quantities of both axes, and that which colours the points."""

    across: str
    up: str
    colour: str


def cases_to_scatter(ds: xr.Dataset, options: PlotOptions) -> bool:
    """Tell whether to draw points: for cases in no order that have no other role."""
    if ds.sizes.get(CASE, 1) == 1 or not is_scattered(ds, CASE):
        return False
    along = {CASE, *parameters_along(ds, CASE)}
    names = (getattr(options, role) for role in ROLES)
    named = {canonical_name(name) or name for name in names if name}
    return named <= along and (ds.sizes[CASE] > MANY or len(ds.sizes) == 1)


def draw_scatter(
    ds: xr.Dataset, variables: Sequence[str], options: PlotOptions
) -> tuple[Figure, str]:
    """A panel for each variable and parameter, and where other axes are cut.

    A point has the colour of its regime; over two parameters, or of kinds, that of its value.
    """
    if options.hue or options.row or options.col:
        raise ValueError("cases in no order are points over x and y: they have no hue, row or col")
    ds, middle = slice_in_the_middle(ds, [str(dim) for dim in ds.sizes if dim != CASE])
    rows = _clouds(ds, variables, options)
    figure, panels = _panels(rows)
    scales = options.scales
    colours = None
    for row, line in zip(rows, panels, strict=True):
        colours = _colours(ds, row[0], scales)
        for axes, cloud in zip(line, row, strict=True):
            _draw_cloud(axes, ds, cloud, colours, scales)
        for axes in line[:: _across(len(row))]:
            axes.set_ylabel(shown(ds[row[0].up]).label)
        if colours and not colours.legend:
            colours.draw_scale(figure, line)
    if colours and colours.legend:
        put_legend(figure, colours.legend, above=True)
    figure.align_labels()
    put_note(figure, missing_notes(ds, variables, "Not drawn: "))
    return figure, middle


def pairs(ds: xr.Dataset) -> Figure:
    """The varied parameters of a sample against each other: where each kind of motion lies.

    Raises ValueError for a result without cases in no order that vary two parameters or more.
    """
    ds = ds.squeeze()
    names = parameters_along(ds, CASE) if CASE in ds.dims and is_scattered(ds, CASE) else []
    if len(names) < 2:
        raise ValueError("pairs need a sample, or cases in no order, of two parameters or more")
    ds, middle = slice_in_the_middle(ds, [str(dim) for dim in ds.sizes if dim != CASE])
    count = len(names) - 1
    figure, grid = new_panels(count, count, (PAGE, PAGE), sharex="col", sharey="row")
    colours = colours_of(ds, "regime")
    for row, up in enumerate(names[1:]):
        for column, across in enumerate(names[:-1]):
            axes = grid[row, column]
            if column > row:
                axes.remove()
                continue
            _draw_cloud(axes, ds, _Cloud(across, up, "regime"), colours, frozenset())
            axes.set_ylabel(shown(ds[up]).label)
            axes.label_outer()
    put_legend(figure, colours.legend)
    figure.align_labels()
    put_note(figure, [*missing_notes(ds, ["regime"], "Not drawn: "), middle])
    return figure


def _clouds(ds: xr.Dataset, variables: Sequence[str], options: PlotOptions) -> list[list[_Cloud]]:
    """A list for each variable: over each parameter, or coloured by it over two of them."""
    along = parameters_along(ds, CASE)
    x, y = (canonical_name(name) if name else None for name in (options.x, options.y))
    if y is None and is_discrete(ds, variables[0]) and len(along) > 1:
        y = next(name for name in along if name != x)
    across = [x] if x else [name for name in along if name != y]
    return [
        [_Cloud(name, y or variable, variable if y else "regime") for name in across]
        for variable in variables
    ]


def _panels(rows: list[list[_Cloud]]) -> tuple[Figure, list[list[Axes]]]:
    """Panels for the clouds: those of each variable in lines of their own."""
    count = len(rows[0])
    across = _across(count)
    down = math.ceil(count / across)
    size = (width_of(across), _FRAME + _ROW * down * len(rows))
    figure, grid = new_panels(down * len(rows), across, size, sharey="row")
    lines = []
    for lines_of_one in np.split(grid, len(rows)):
        for unused in lines_of_one.flat[count:]:
            unused.remove()
        lines.append(list(lines_of_one.flat[:count]))
    return figure, lines


def _across(count: int) -> int:
    """Return the number of panels of a variable that are side by side."""
    return count if count <= 4 else 3


def _draw_cloud(
    axes: Axes, ds: xr.Dataset, cloud: _Cloud, colours: Colours | None, scales: frozenset[str]
) -> None:
    x, y = (shown(trusted(ds, name) if name in RESULTS else ds[name]) for name in cloud[:2])
    axes.scatter(
        x.values,
        y.values,
        s=_AREA * min(1.0, 300 / x.values.size),
        c=colours.placed(ds) if colours else BLACK,
        cmap=colours.cmap if colours else None,
        norm=colours.norm if colours else None,
        linewidths=0,
        rasterized=True,
    )
    axes.set_xlabel(x.label)
    is_value = cloud.up in RESULTS
    log_y = bool(scales & {"y", "z"}) if is_value else "y" in scales or fits_log(y.values)
    log_x = "x" in scales or fits_log(x.values)
    make_logarithmic(axes, ["x"] * log_x + ["y"] * log_y)


def _colours(ds: xr.Dataset, cloud: _Cloud, scales: frozenset[str]) -> Colours | None:
    """The colours of the points; none where the file does not know what colours them."""
    if cloud.colour not in ds:
        return None
    return colours_of(ds, cloud.colour, log="z" in scales and cloud.up not in RESULTS)


def fits_log(values: Array) -> bool:
    """Tell whether the median of the values is nearer to their centre on a logarithmic scale."""
    low, middle, high = np.quantile(values, [0.0, 0.5, 1.0])
    if low <= 0 or high < _WIDE * low:
        return False
    return bool(abs(math.log(middle**2 / (low * high))) < abs(math.log(2 * middle / (low + high))))
