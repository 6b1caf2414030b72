"""The picture of a single point: a table of its results and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.colours import KINDS, code_name
from sweeps.charts.labels import shown
from sweeps.charts.missing import missing_notes, missing_points, trusted
from sweeps.figure_table import AMPLITUDES
from sweeps.figures.style import SMALL, TEXT, new_figure, wrapped

_LINE = 0.18  # inches
_MARGIN = 0.12  # inches
_WIDTH = 5.2  # inches
# Inches from the left: symbols of results, their values, symbols of parameters, their values.
_COLUMNS = (_MARGIN, 1.25, 3.2, 3.65)


class _Row(NamedTuple):
    symbol: str
    value: str


def draw_point(ds: xr.Dataset) -> Figure:
    """The results on the left, the parameters on the right, how the point ended above."""
    results = [_row(ds, name) for name in RESULTS if name in ds.variables and name != "status"]
    parameters = [_row(ds, name) for name in PARAMETERS if name in ds.variables]
    longest = max(len(results), len(parameters))
    figure = new_figure((_WIDTH, 1.0))
    head = wrapped(figure, _ending(ds), _WIDTH - 2 * _MARGIN, SMALL).split("\n")
    first = len(head) + 1
    figure.set_figheight(2 * _MARGIN + _LINE * (first + longest))
    _write(figure, head, 0, _MARGIN, SMALL)
    cells = (*zip(*results, strict=True), *zip(*parameters, strict=True))
    for column, x in zip(cells, _COLUMNS, strict=False):
        _write(figure, column, first, x, TEXT)
    return figure


def _ending(ds: xr.Dataset) -> str:
    notes = missing_notes(ds, AMPLITUDES, "")
    if not notes:
        return "A single point: nothing was swept."
    code = int(ds["status"]) if "status" in ds else None
    sentence = Status(code).sentence if code in list(Status) else notes[0]
    return f"A single point, without a result. {sentence}"


def _row(ds: xr.Dataset, name: str) -> _Row:
    quantity = shown(trusted(ds, name) if name in RESULTS else ds[name])
    if np.isfinite(quantity.values):
        kind = name in KINDS or name == "orbit_periods"
        return _Row(
            quantity.symbol, code_name(name, int(quantity.values)) if kind else quantity.value
        )
    # Of a point with a result, what lacks does not exist: the Lyapunov exponent of a closed orbit.
    absent = "missing" if name in AMPLITUDES or missing_points(ds).item() else "none"
    return _Row(quantity.symbol, absent)


def _write(figure: Figure, lines: Sequence[str], first: int, x: float, size: str) -> None:
    width, height = figure.get_size_inches()
    for index, line in enumerate(lines, start=first):
        y = height - _MARGIN - _LINE * (index + 0.5)
        figure.text(x / width, y / height, line, fontsize=size, va="center")
