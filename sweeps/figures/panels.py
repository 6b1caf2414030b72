"""The panels of a picture: rows of variables or values of a short axis, columns of facets."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sweeps.charts.axes import MOST_FACETS, Layout, Selection, selections, thinned
from sweeps.charts.colours import KINDS, code_name, kinds_in
from sweeps.figures.style import new_panels, width_of, wrapped

_MOST_ROWS = 6  # rows of panels that still fit on a page
_MOST_WRAPPED = 9  # facets of a single variable, in rows of three
_ROW, _FRAME = 2.1, 0.6  # inches: a row of panels; the space above and below all panels
_TALLEST = 9.0  # inches: the height of a page


class Panel(NamedTuple):
    """A panel with the slice and variable that it shows."""

    axes: Axes
    dataset: xr.Dataset
    variable: str


class Panels(NamedTuple):
    """The panels of a figure, the data of all of them, and notes on the facets left out."""

    figure: Figure
    panels: list[Panel]
    dataset: xr.Dataset
    notes: list[str]

    def of(self, variable: str) -> list[Panel]:
        """Return the panels of one variable."""
        return [panel for panel in self.panels if panel.variable == variable]


def facet_panels(
    ds: xr.Dataset, layout: Layout, variables: Sequence[str], *, of_axes: bool
) -> Panels:
    """Return panels for the facets and variables of a picture; facets of a single row wrap.

    With `of_axes` the vertical axis is an axis of the sweep, the same for all variables.
    """
    wraps = len(variables) == 1 and layout.row is None
    ds, fewer = thinned(ds, layout.col, _MOST_WRAPPED if wraps else MOST_FACETS)
    ds, fewer_rows = thinned(ds, layout.row, min(MOST_FACETS, max(1, _MOST_ROWS // len(variables))))
    columns = _facets(ds, layout.col)
    rows = list(itertools.product(_facets(ds, layout.row), variables))
    across = len(columns) if len(columns) <= MOST_FACETS else math.ceil(math.sqrt(len(columns)))
    down = len(rows) * math.ceil(len(columns) / across)
    size = (width_of(across), min(_TALLEST, _FRAME + _ROW * down))
    share_y = True if len(variables) == 1 or of_axes else "row"
    figure, grid = new_panels(down, across, size, sharex=True, sharey=share_y)
    cells = [(c.dataset, name) for row, name in rows for c in _facets(row.dataset, layout.col)]
    panels = [Panel(axes, *cell) for axes, cell in zip(grid.flat, cells, strict=False)]
    for axes, (row, _) in zip(grid[:, 0], rows, strict=False):
        axes.set_ylabel(row.label)
    for axes, column in zip(grid.flat, columns, strict=False):
        _name(figure, axes, column.label, across)
    for unused in grid.flat[len(panels) :]:
        unused.remove()
    for lowest in grid.flat[len(panels) - across : len(panels)] if len(panels) > 1 else ():
        lowest.tick_params(labelbottom=True)
    return Panels(figure, panels, ds, [fewer, fewer_rows])


def label_axes(panels: Panels, across: str, up: Sequence[str]) -> None:
    """Label the horizontal axis of each column and the vertical one of each row (`up`, in turn)."""
    if len(panels.panels) == 1:  # perhaps in a figure of the user
        (panel,) = panels.panels
        panel.axes.set_ylabel(up[0])
        if panel.axes.xaxis.get_tick_params().get("labelbottom", True):
            panel.axes.set_xlabel(across)
        return
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


def name_kinds(axes: Axes, ds: xr.Dataset, variable: str) -> None:
    """Write the names of kinds on the vertical axis; an axis of numbers stays as it is."""
    if variable in KINDS:
        codes = kinds_in(ds, variable) or ()
        names = [code_name(variable, code).replace(", ", ",\n") for code in codes]
        axes.set_yticks(codes, labels=names)


def _facets(ds: xr.Dataset, dim: str | None) -> list[Selection]:
    return [Selection("", ds)] if dim is None else selections(ds, (dim,), ds.sizes[dim])[0]


def _name(figure: Figure, axes: Axes, title: str, columns: int) -> None:
    if title:
        axes.set_title(wrapped(figure, title, (figure.get_figwidth() - 1.0) / columns))
