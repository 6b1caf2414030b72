"""The panels of a picture: a row for each variable or value of a short axis, a column a facet."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sweeps.figures.layout import MOST_FACETS, Layout, Selection, selections, thinned
from sweeps.figures.style import new_panels, width_of, wrapped

_MOST_ROWS = 6  # rows of panels that still fit on a page
_MOST_WRAPPED = 9  # facets of a single variable, in rows of three
_ROW, _FRAME = 2.1, 0.6  # inches: a row of panels, what is above and below them
_TALLEST = 9.0  # inches: of a page


class Panel(NamedTuple):
    """A panel, the slice that it shows, and of which variable."""

    axes: Axes
    dataset: xr.Dataset
    variable: str


class Panels(NamedTuple):
    """The panels of a figure, all that they show, and what is to be said of facets left out."""

    figure: Figure
    panels: list[Panel]
    dataset: xr.Dataset
    notes: list[str]

    def of(self, variable: str) -> list[Panel]:
        """The panels of one variable."""
        return [panel for panel in self.panels if panel.variable == variable]


def facet_panels(
    ds: xr.Dataset, layout: Layout, variables: Sequence[str], *, of_axes: bool
) -> Panels:
    """Panels for the facets and variables of a picture; facets of one row are wrapped.

    `of_axes` says that what goes up is an axis of the sweep, the same for all variables.
    """
    wraps = len(variables) == 1 and layout.row is None
    ds, fewer = thinned(ds, layout.col, _MOST_WRAPPED if wraps else MOST_FACETS)
    ds, fewer_rows = thinned(ds, layout.row, min(MOST_FACETS, _MOST_ROWS // len(variables)))
    columns = _facets(ds, layout.col)
    if len(columns) > MOST_FACETS:
        return Panels(*_wrapped(columns, variables[0]), ds, [fewer])
    rows = list(itertools.product(_facets(ds, layout.row), variables))
    size = (width_of(len(columns)), min(_TALLEST, _FRAME + _ROW * len(rows)))
    share_y = True if len(variables) == 1 or of_axes else "row"
    figure, grid = new_panels(len(rows), len(columns), size, sharex=True, sharey=share_y)
    panels = []
    for line, (row, name) in zip(grid, rows, strict=True):
        line[0].set_ylabel(row.label)
        slices = _facets(row.dataset, layout.col)
        panels += [Panel(axes, s.dataset, name) for axes, s in zip(line, slices, strict=True)]
    for axes, column in zip(grid[0], columns, strict=True):
        _name(figure, axes, column.label, len(columns))
    return Panels(figure, panels, ds, [fewer, fewer_rows])


def label_axes(panels: Panels, across: str, up: Sequence[str]) -> None:
    """What lies across, below each column; what goes up, left of each row (of `up`, in turn)."""
    for panel in panels.panels:
        place = panel.axes.get_subplotspec()
        if place is None:
            continue
        if panel.axes.xaxis.get_tick_params()["labelbottom"]:
            panel.axes.set_xlabel(across)
        if place.is_first_col():
            row = panel.axes.get_ylabel()
            label = up[place.rowspan.start % len(up)]
            panel.axes.set_ylabel(f"{row}\n{label}" if row and label else row or label)
    panels.figure.align_ylabels()


def _facets(ds: xr.Dataset, dim: str | None) -> list[Selection]:
    return [Selection("", ds)] if dim is None else selections(ds, (dim,), ds.sizes[dim])[0]


def _wrapped(facets: list[Selection], variable: str) -> tuple[Figure, list[Panel]]:
    across = math.ceil(math.sqrt(len(facets)))
    down = math.ceil(len(facets) / across)
    size = (width_of(across), _FRAME + _ROW * down)
    figure, grid = new_panels(down, across, size, sharex=True, sharey=True)
    panels = []
    for axes, facet in zip(grid.flat, facets, strict=False):
        _name(figure, axes, facet.label, across)
        panels.append(Panel(axes, facet.dataset, variable))
    for axes in grid.flat[len(facets) :]:
        axes.remove()
    for axes in grid.flat[len(facets) - across : len(facets)]:
        axes.tick_params(labelbottom=True)
    return figure, panels


def _name(figure: Figure, axes: Axes, title: str, columns: int) -> None:
    if title:
        axes.set_title(wrapped(figure, title, (figure.get_figwidth() - 1.0) / columns))
