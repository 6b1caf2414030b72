"""The facts in a page: how the points of a result ended, its config, its provenance.

All text from the file is escaped.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

import numpy as np
import xarray as xr

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.symbols import as_html
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.colours import code_name, code_sentence
from sweeps.charts.labels import shown, slice_label
from sweeps.charts.missing import trusted
from sweeps.grid import CASE
from sweeps.page.chosen_orbits import failed_points, places_of

_MOST_FAILURES = 500  # rows that a browser lays out without delay
_LONGEST_TEXT = 200_000  # characters; the cases of a config may take megabytes


def failures_table(ds: xr.Dataset) -> str:
    """Return a table of the points without a result: place, status and its meaning."""
    failed = failed_points(ds)
    if not failed.size:
        return "<p>Every point that was computed has a result.</p>"
    rows = []
    for number in failed[:_MOST_FAILURES].tolist():
        where = (
            f'<button type="button" data-point="{number}">{_place_in_words(ds, number)}</button>'
        )
        rows.append([where, *_name_and_meaning("status", int(ds["status"].values.flat[number]))])
    more = failed.size - len(rows)
    note = f"<p>{more} more are not listed.</p>" if more else ""
    return _table(("point", "status", "what happened, and what may help"), rows) + note


def _name_and_meaning(name: str, code: int) -> tuple[str, str]:
    return escape(code_name(name, code)), escape(code_sentence(name, code))


def _place_in_words(ds: xr.Dataset, number: int) -> str:
    """Return the values of the axes at a point, by its number in C order, as HTML."""
    (index,) = places_of(ds, np.array([number]))
    case = f"case {index[CASE]}, " if CASE in index else ""
    return case + as_html(slice_label(ds, index)) or "the only point"


def counts_table(ds: xr.Dataset) -> str:
    """Return a table of the numbers of points with each status and each regime, with meanings."""
    kinds = {"status": ds["status"].values}
    if "regime" in ds:
        kinds["regime"] = trusted(ds, "regime").fillna(Regime.UNKNOWN).values
    rows = []
    for name, codes in kinds.items():
        found, counts = np.unique(codes.astype(int), return_counts=True)
        for code, count in zip(found.tolist(), counts.tolist(), strict=True):
            kind, meaning = _name_and_meaning(name, code)
            rows.append([name, kind, str(count), meaning])
    return _table(("variable", "kind", "points", "meaning"), rows)


def largest_error(ds: xr.Dataset) -> str:
    """Return a sentence on the largest stated error and the point that has it."""
    errors = trusted(ds, "amplitude_error").values.ravel() if "amplitude_error" in ds else None
    if errors is None or not np.isfinite(errors).any():
        return "No point has a stated error."
    number = int(np.nanargmax(errors))
    error = as_html(shown(xr.DataArray(float(f"{errors[number]:.1e}"))).value)
    where = _place_in_words(ds, number)
    aperiodic = int(ds["status"].values.ravel()[number]) == Status.APERIODIC
    kind = " (the error of a mean over a motion that never closes)" if aperiodic else ""
    return f"The largest amplitude error is {error}, at {where}{kind}."


def fixed_parameters(ds: xr.Dataset) -> str:
    """Return the parameters that are equal at all points; values unlike the paper's are bold."""
    items = []
    for name in PARAMETERS:
        if name in ds.coords and ds[name].size == 1:
            value = as_html(shown(ds[name]).equation)
            usual = np.isclose(float(ds[name]), PARAMETERS[name].default, rtol=1e-12, atol=0.0)
            text = value if usual else f"<strong>{value}</strong>"
            items.append(f'<li title="{escape(PARAMETERS[name].meaning)}">{text}</li>')
    return f'<ul class="parameters">{"".join(items)}</ul>'


def readout_table(ds: xr.Dataset, parameters: Iterable[str], variables: Iterable[str]) -> str:
    """Return a table of the numbers of a point, which the script of the page fills from the top."""
    rows = []
    for name in parameters:
        symbol = f" {as_html(shown(ds[name]).symbol)}" if name in PARAMETERS else ""
        heading = f'<th scope="row">{escape(name.replace("_", " "))}{symbol}</th>'
        rows.append(f'<tr class="parameter">{heading}<td></td></tr>')
    for name in variables:
        heading = f'<th scope="row">{escape(name.replace("_", " "))}</th>'
        rows.append(f'<tr title="{escape(RESULTS[name].meaning)}">{heading}<td></td></tr>')
    return f'<table class="readout"><tbody>{"".join(rows)}</tbody></table>'


def provenance_table(facts: Iterable[tuple[str, object]]) -> str:
    """Return a table of names and texts, such as the attributes of a file."""
    return _table((), [[escape(name), _text(str(value))] for name, value in facts])


def config_text(config: str) -> str:
    """Return the config of a result, as YAML."""
    return f'<pre tabindex="0" role="group" aria-label="The config">{_text(config)}</pre>'


def _text(text: str) -> str:
    if len(text) <= _LONGEST_TEXT:
        return escape(text)
    return escape(text[:_LONGEST_TEXT]) + f"\n... ({len(text)} characters in the file)"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells in HTML; the first cell of a row is its heading."""
    titles = "".join(f'<th scope="col">{title}</th>' for title in head)
    lines = [
        f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in others)}</tr>'
        for first, *others in rows
    ]
    above = f"<thead><tr>{titles}</tr></thead>" if head else ""
    body = f"{above}<tbody>{''.join(lines)}</tbody>"
    box = 'class="wide" role="group" aria-label="Table" tabindex="0"'  # it scrolls where it is wide
    return f"<div {box}><table>{body}</table></div>"
