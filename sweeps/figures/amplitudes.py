"""The picture of a sweep result: curves, maps, points, or the table of a single point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.axes import cases_to_scatter, layout_of
from sweeps.charts.chart import require_borders
from sweeps.charts.choice import lie_along, named_roles, slice_at, slice_in_the_middle, variables_of
from sweeps.charts.colours import KINDS, code_name, is_discrete
from sweeps.charts.labels import shown
from sweeps.charts.missing import missing_notes, missing_points, trusted
from sweeps.charts.quantiles import asks_for_bands, medians_of, quantiles_of
from sweeps.figure_table import AMPLITUDES
from sweeps.figures.curves import draw_curves
from sweeps.figures.look import PlotOptions
from sweeps.figures.maps import draw_maps
from sweeps.figures.scatter import draw_scatter
from sweeps.figures.style import SMALL, TEXT, new_figure, put_note, wrapped
from sweeps.grid import DIRECTION, QUANTILE


def amplitudes(ds: xr.Dataset) -> Figure:
    """Curves along one long axis, maps over two, facets for further axes, a table for a point."""
    return draw_results(ds, PlotOptions())


def draw_results(ds: xr.Dataset, options: PlotOptions) -> Figure:
    """Return the picture that the options describe; raises ValueError if it cannot be drawn."""
    variables = variables_of(ds, options)
    ds, at = slice_at(ds.squeeze(), options.at)
    if not ds.sizes:
        _require_no_axes(ds, options)
        return draw_point(ds, variables, at)
    bands: list[str] = []
    if asks_for_bands(ds, options, variables):
        ds = quantiles_of(ds)
    if QUANTILE in ds.dims:
        ds, bands = medians_of(ds)
    options = _along_directions(ds, options)
    if cases_to_scatter(ds, options):
        if options.boundaries is not None or options.data is not None:
            raise ValueError(
                "borders need a map and measured points need curves, but unordered cases give "
                "neither"
            )
        figure, middle = draw_scatter(ds, variables, options)
    else:
        ds = lie_along(ds, options)
        discrete = all(is_discrete(ds, name) for name in variables)
        layout = layout_of(ds, options, discrete=discrete, rows=len(variables))
        left = [str(dim) for dim in ds.sizes if dim not in layout.dims]
        ds, middle = slice_in_the_middle(ds, left)
        is_map = layout.y is not None or discrete
        if options.boundaries is not None:
            require_borders(options.boundaries)
        if is_map:
            figure = draw_maps(ds, layout, variables, options.scales, options.boundaries)
        elif options.boundaries is None:
            figure = draw_curves(ds, layout, variables, options.scales, options.data)
        else:
            raise ValueError("borders are drawn on maps; add an axis with -y")
        if is_map and options.data is not None:
            raise ValueError(
                f"measured points are drawn over curves, but {', '.join(variables)} would be a "
                "map; choose a variable and axes that give curves"
            )
    put_note(figure, [*bands, at, middle])
    return figure


def _along_directions(ds: xr.Dataset, options: PlotOptions) -> PlotOptions:
    """Return the options with an axis for both directions of a single point, which has no other."""
    alone = [*ds.sizes] == [DIRECTION] and not named_roles(ds, options)
    return replace(options, x=DIRECTION) if alone else options


def _require_no_axes(ds: xr.Dataset, options: PlotOptions) -> None:
    """Raise ValueError for an option that the table of a single point cannot follow."""
    named_roles(ds, options)  # it refuses any axis
    over = {"boundaries": options.boundaries, "data": options.data, "log": options.log or None}
    if idle := [name for name, value in over.items() if value is not None]:
        raise ValueError(f"a single point is drawn as a table; leave out {', '.join(idle)}")


# --- the table of a single point ------------------------------------------------------------------

_LINE = 0.18  # inches
_MARGIN = 0.12  # inches
_WIDTH = 5.2  # inches
# Inches from the left: symbols of results, their values, symbols of parameters, their values.
_COLUMNS = (_MARGIN, 1.25, 3.2, 3.65)


def draw_point(ds: xr.Dataset, variables: Sequence[str], at: str) -> Figure:
    """Return a table of results on the left and parameters on the right, below a line on the point.

    The line says how the point ended if it has no result. The `variables` that the user added are
    above the table, since their names may be long. `at` says where the point is if it was cut out
    of a result with axes.
    """
    # A part of a result may lack the amplitudes, which say whether there is a result.
    measured = [name for name in AMPLITUDES if name in ds.variables] or variables
    lacks_result = missing_points(ds, measured).item()
    results = [name for name in RESULTS if name in ds.variables and name != "status"]
    left = [_row(ds, name, lacks_result) for name in results]
    right = [_row(ds, name) for name in PARAMETERS if name in ds.variables]
    own = [_row(ds, name, lacks_result) for name in variables if name not in RESULTS]
    which = at or "A single point."
    ending = which
    if notes := missing_notes(ds, measured, ""):
        code = ds["status"].item() if "status" in ds else None  # NaN if it is masked
        sentence = Status(code).sentence if code in list(Status) else notes[0]
        ending = f"{which} It has no result. {sentence}"
    longest = max(len(left), len(right))
    figure = new_figure((_WIDTH, 1.0))
    above = [ending, *(": ".join(row) for row in own)]
    lines = [wrapped(figure, text, _WIDTH - 2 * _MARGIN, SMALL) for text in above]
    head = "\n".join(lines).split("\n")
    first = len(head) + 1
    figure.set_figheight(2 * _MARGIN + _LINE * (first + longest))
    _write(figure, head, 0, _MARGIN, SMALL)
    cells = (*zip(*left, strict=True), *zip(*right, strict=True))
    for column, x in zip(cells, _COLUMNS, strict=False):
        _write(figure, column, first, x, TEXT)
    return figure


def _row(ds: xr.Dataset, name: str, lacks_result: bool = False) -> tuple[str, str]:
    """Return the symbol of a variable, and its value."""
    quantity = shown(ds[name] if name in PARAMETERS else trusted(ds, name))
    if not np.isfinite(quantity.values):
        # A point with a result lacks what does not exist: a closed orbit has no Lyapunov exponent.
        return quantity.symbol, "missing" if name in AMPLITUDES or lacks_result else "none"
    if name in KINDS or name == "orbit_periods":
        return quantity.symbol, code_name(name, int(quantity.values))
    return quantity.symbol, quantity.value


def _write(figure: Figure, lines: Sequence[str], first: int, x: float, size: str) -> None:
    width, height = figure.get_size_inches()
    for index, line in enumerate(lines, start=first):
        y = height - _MARGIN - _LINE * (index + 0.5)
        figure.text(x / width, y / height, line, fontsize=size, va="center")
