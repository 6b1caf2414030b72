"""Linked cases in no order, such as random ones: points over each parameter that they vary."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stickslip.variables import canonical_name
from sweeps.charts.axes import is_scattered
from sweeps.charts.chart import Cloud, cloud_of
from sweeps.charts.choice import Choice, slice_in_the_middle
from sweeps.charts.colours import BLACK, KINDS, colours_of, is_discrete
from sweeps.charts.labels import parameters_along
from sweeps.charts.missing import missing_notes
from sweeps.figures.maps import draw_scale, legend_of, shades_of
from sweeps.figures.panels import name_kinds
from sweeps.figures.style import PAGE, make_logarithmic, new_panels, put_legend, put_note, width_of
from sweeps.grid import CASE

_ROW, _FRAME = 2.0, 0.7  # inches: a row of panels; the space above and below all panels
_AREA = 9.0  # square points: the area of a dot among few; many dots are smaller


def draw_scatter(ds: xr.Dataset, variables: Sequence[str], options: Choice) -> tuple[Figure, str]:
    """Return a panel for each variable and parameter, and a note on where other axes are cut.

    The colour of a point shows its regime or, over two parameters, the value of the variable.
    """
    if options.hue or options.row or options.col:
        raise ValueError("unordered cases are points over x and y; leave out hue, row and col")
    if CASE in (options.x, options.y):
        along = ", ".join(parameters_along(ds, CASE))
        raise ValueError(f"unordered cases lie over their parameters ({along}), not over {CASE}")
    ds, middle = slice_in_the_middle(ds, [str(dim) for dim in ds.sizes if dim != CASE])
    rows = _clouds(ds, variables, options)
    figure, panels = _panels(rows)
    legends: dict[str, list[Line2D]] = {}  # rows of heights share the colours of the regime
    for row, line in zip(rows, panels, strict=True):
        colours = row[0].colours
        shades = shades_of(colours) if colours else None
        for axes, cloud in zip(line, row, strict=True):
            _draw_cloud(axes, cloud, shades)
        for axes in line[:: _across(len(row))]:
            axes.set_ylabel(row[0].labels[1])
            name_kinds(axes, ds, row[0].names[1])
        if colours and shades:
            draw_scale(colours, shades, figure, line)
            legends[colours.name] = legend_of(colours)
    if kinds := [*chain(*legends.values())]:
        put_legend(figure, kinds, above=True)
    figure.align_labels()
    by_height = rows[0][0].names[1] in variables
    log = [n for n, row in zip(variables, rows, strict=True) if _has_log_scale(row[0], n)]
    if "z" in options.scales and all(
        n in KINDS if by_height else is_discrete(ds, n) for n in variables
    ):
        raise ValueError("kinds and counts have no scale, so log z does not apply")
    put_note(figure, missing_notes(ds, variables, "Not drawn: ", log=log))
    return figure, middle


def _has_log_scale(cloud: Cloud, variable: str) -> bool:
    """Return True if a variable, which is the height or the colour, has a logarithmic scale."""
    if cloud.names[1] == variable:
        return cloud.log[1]
    return cloud.colours is not None and cloud.colours.log


def pairs(ds: xr.Dataset) -> Figure:
    """The kinds of motion over each pair of the parameters that a sample varies.

    Raises ValueError for a result without cases in no order that vary two parameters or more.
    """
    ds = ds.squeeze()
    names = parameters_along(ds, CASE) if CASE in ds.dims and is_scattered(ds, CASE) else []
    if len(names) < 2:
        raise ValueError("pairs need a sample, or unordered cases, of at least two parameters")
    ds, middle = slice_in_the_middle(ds, [str(dim) for dim in ds.sizes if dim != CASE])
    count = len(names) - 1
    figure, grid = new_panels(count, count, (PAGE, PAGE), sharex="col", sharey="row")
    colours = colours_of(ds, "regime")
    shades = shades_of(colours)
    for row, up in enumerate(names[1:]):
        for column, across in enumerate(names[:-1]):
            axes = grid[row, column]
            if column > row:
                axes.remove()
                continue
            cloud = cloud_of(ds, (across, up), colours)
            _draw_cloud(axes, cloud, shades)
            axes.set_ylabel(cloud.labels[1])
            axes.label_outer()
    put_legend(figure, legend_of(colours))
    figure.align_labels()
    put_note(figure, [*missing_notes(ds, ["regime"], "Not drawn: "), middle])
    return figure


def _clouds(ds: xr.Dataset, variables: Sequence[str], options: Choice) -> list[list[Cloud]]:
    """Return a list of clouds for each variable: it is the height, or the colour over two axes."""
    along = parameters_along(ds, CASE)
    x, y = (canonical_name(name) if name else None for name in (options.x, options.y))
    if x is not None and x == y:
        raise ValueError(f"{x} is both x and y; points need two parameters, or one and a variable")
    if y is None and any(is_discrete(ds, name) for name in variables) and len(along) > 1:
        y = next(name for name in along if name != x)
    across = [x] if x else [name for name in along if name != y]
    if not across:
        raise ValueError(f"no parameter is left for x: only {y} varies; name it as x")
    rows = []
    for variable in variables:
        # Without colours if the file lacks the variable that gives the points their colours.
        name, log = variable if y else "regime", "z" in options.scales and bool(y)
        colours = colours_of(ds, name, log=log) if name in ds else None
        pairs = ((name, y or variable) for name in across)
        scales = options.scales if y or variable not in KINDS else options.scales - {"y", "z"}
        rows.append([cloud_of(ds, pair, colours, scales) for pair in pairs])
    return rows


def _panels(rows: list[list[Cloud]]) -> tuple[Figure, list[list[Axes]]]:
    """Return the panels of the clouds; each variable begins a new line of panels."""
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
    """Return the number of panels of a variable in a line."""
    return count if count <= 4 else 3


def _draw_cloud(axes: Axes, cloud: Cloud, shades: Mapping[str, Any] | None) -> None:
    """Draw points in their colours, or in black if there are none."""
    axes.scatter(
        cloud.x,
        cloud.y,
        s=_AREA * min(1.0, 300 / cloud.x.size),
        c=np.ma.filled(cloud.values, np.nan) if shades else BLACK,  # it warns of a masked first one
        linewidths=0,
        rasterized=True,
        **(shades or {}),
    )
    axes.set_xlabel(cloud.labels[0])
    make_logarithmic(axes, [side for side, log in zip("xy", cloud.log, strict=True) if log])
