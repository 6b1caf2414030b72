"""HTML tables for notebooks, with names, symbols, values and units."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping
from typing import Any

from stickslip.symbols import as_html
from stickslip.variables import Variable

_POWER = re.compile(r"\^\((.*)\)|(-?\d+)")
_CELL = "text-align: left; padding: 0 1em 0 0"


def value_table(
    values: Mapping[str, Any], variables: Mapping[str, Variable], bold: Iterable[str] = ()
) -> str:
    """Return an HTML table of values with symbols and units, and meanings as tooltips.

    The rows named in `bold` are in bold type.
    """
    marked = set(bold)
    rows = [_row(variables[name], value, name in marked) for name, value in values.items()]
    return f"<table>{''.join(rows)}</table>"


def _row(variable: Variable, value: Any, bold: bool) -> str:
    units = _POWER.sub(r"<sup>\1\2</sup>", variable.unit.replace("gamma", "γ"))
    symbol = as_html(f"${variable.tex}$")
    cells = [html.escape(variable.name), symbol, html.escape(_text(value)), units.replace("-", "−")]
    inner = "".join(f'<td style="{_CELL}">{cell}</td>' for cell in cells)
    weight = ' style="font-weight: bold"' if bold else ""
    return f'<tr title="{html.escape(variable.meaning)}"{weight}>{inner}</tr>'


def _text(value: Any) -> str:
    """Return a value as text: flags by name, floats to seven digits."""
    name = getattr(value, "name", None)
    if isinstance(name, str):
        return name.lower()
    return f"{value:.7g}" if isinstance(value, float) else str(value)
