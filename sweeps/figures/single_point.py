"""The picture of a single point: a table of its results and parameters."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.figure_table import AMPLITUDES
from sweeps.figures.labels import shown
from sweeps.figures.missing import missing_note, trusted
from sweeps.figures.style import COLUMN, SMALL, TEXT, new_figure

_LINE = 0.18  # inches
_MARGIN = 0.12  # inches
_LETTERS = 58  # of SMALL size in a column


def draw_point(ds: xr.Dataset) -> Figure:
    """The results on the left, the parameters on the right, how the point ended above."""
    head = textwrap.wrap(_ending(ds), _LETTERS)
    results = _equations(ds, RESULTS)
    parameters = _equations(ds, PARAMETERS)
    lines = len(head) + 1 + max(len(results), len(parameters))
    figure = new_figure((COLUMN, 2 * _MARGIN + _LINE * lines))
    _write(figure, head, first=0, x=_MARGIN, size=SMALL)
    _write(figure, results, first=len(head) + 1, x=_MARGIN, size=TEXT)
    _write(figure, parameters, first=len(head) + 1, x=_MARGIN + COLUMN / 2, size=TEXT)
    return figure


def _ending(ds: xr.Dataset) -> str:
    note = missing_note(ds, "")
    if not note:
        return "A single point: nothing was swept."
    code = int(ds["status"]) if "status" in ds else None
    sentence = Status(code).sentence if code in list(Status) else note
    return f"A single point, without a result. {sentence}"


def _equations(ds: xr.Dataset, names: Iterable[str]) -> list[str]:
    return [_equation(ds, name) for name in names if name in ds.variables and name != "status"]


def _equation(ds: xr.Dataset, name: str) -> str:
    quantity = shown(trusted(ds, name) if name in AMPLITUDES else ds[name])
    no_count = name in RESULTS and not quantity.units and quantity.values < 0
    if no_count or not np.isfinite(quantity.values):
        return f"{quantity.symbol} missing"
    return quantity.equation


def _write(figure: Figure, lines: list[str], first: int, x: float, size: float) -> None:
    width, height = figure.get_size_inches()
    for index, line in enumerate(lines, start=first):
        y = height - _MARGIN - _LINE * (index + 0.5)
        figure.text(x / width, y / height, line, fontsize=size, va="center")
