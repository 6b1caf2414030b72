"""The data of the script of a page: the numbers of a result, their names, legends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource

from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.axes import axis_of
from sweeps.charts.chart import axis_limits, jumps
from sweeps.charts.colours import GREY, Colours, code_name, code_sentence, colours_of
from sweeps.charts.labels import DIRECTIONS, Array, Quantity, shown, slice_label
from sweeps.charts.missing import trusted, value_range
from sweeps.figure_table import AMPLITUDES
from sweeps.grid import CASE, DIRECTION
from sweeps.page.drawing import palette_of

# The most important variables, which come first.
_FIRST = (*AMPLITUDES, "regime", "status", "amplitude_error")


def symbol_of(name: str) -> str:
    """Return the symbol of a parameter in plain letters, or its name if there is no such symbol."""
    symbol = plain(f"${PARAMETERS[name].tex}$") if name in PARAMETERS else name
    return name.replace("_", " ") if "_" in symbol else symbol


def called(name: str) -> list[str]:
    """Return what an address of the page may call a quantity: its name and its symbols."""
    known = PARAMETERS.get(name) or RESULTS.get(name)
    return [name, known.symbol, plain(f"${known.tex}$")] if known else [name]


def variables_of(ds: xr.Dataset) -> dict[str, Colours]:
    """Return the result variables with their colours, the most important ones first."""
    known = [name for name in RESULTS if name in ds.data_vars]
    known.sort(key=lambda name: _FIRST.index(name) if name in _FIRST else len(_FIRST))
    return {name: colours_of(ds, name) for name in known}


def parameters_of(ds: xr.Dataset) -> list[str]:
    """Return the parameters that vary, in the order of the axes, and the axis of a stack."""
    known = [name for name in (CASE, *PARAMETERS) if name in ds.coords]
    return [
        name
        for dim in map(str, ds["status"].dims)
        for name in dict.fromkeys([*known, dim])
        if ds[name].dims == (dim,)
    ]


def parameter(ds: xr.Dataset, name: str) -> dict[str, Any]:
    """Return the symbol, unit and axis of a parameter, and the texts of values that have names."""
    coordinate = ds[name]
    dim = str(coordinate.dims[0])
    about: dict[str, Any] = {"name": name, "axis": list(ds["status"].dims).index(dim)}
    if coordinate.dtype.kind not in "fiu":
        keys = list(map(str, coordinate.values.tolist()))
        texts = [escape(DIRECTIONS.get(key, key)) for key in keys]
        return about | {"prefix": "", "keys": keys, "texts": texts}
    one = shown(xr.ones_like(coordinate, dtype=float))
    symbol = as_html(one.symbol) if name in PARAMETERS else escape(name)
    about |= {"prefix": f"{symbol} = ", "units": _unit(one), "factor": float(one.values[0])}
    if name == "rheological_index" and name == dim and axis_of(ds, dim, named=True).names:
        labels = [as_html(slice_label(ds, {dim: at})) for at in range(coordinate.size)]
        about["texts"] = [label.rpartition(" = ")[2] for label in labels]
    return about


def variable(ds: xr.Dataset, name: str, colours: Colours) -> dict[str, Any]:
    """Return the names, unit and legend of a variable, and the ranges or kinds of its values."""
    quantity, words = shown(trusted(ds, name)), name.replace("_", " ")
    # A symbol may be a word that is less clear than the name.
    is_word = plain(quantity.symbol).replace("_", " ") in words
    about = {
        "name": name,
        "called": called(name),
        "label": words if is_word else plain(quantity.label),
        "units": _unit(quantity),
    }
    heading = escape(words) if is_word else as_html(quantity.label)
    title = f'<strong title="{escape(RESULTS[name].meaning)}">{heading}</strong>'
    none = ""
    if not np.isfinite(quantity.values).all():
        none = _square(GREY, "no value", "No result, or not defined at these points.")
    if not colours.codes:
        ranges = {"linear": _range(ds, name), "log": _range(ds, name, log=True)}
        return about | {"legend": title + none, "ranges": ranges}
    names = [code_name(name, code) for code in colours.codes]
    palette = palette_of(colours)
    kinds = [
        _square(colour, text, code_sentence(name, code))
        for colour, text, code in zip(palette, names, colours.codes, strict=True)
    ]
    ends = -0.5, len(names) - 0.5
    return about | {
        "legend": title + "".join(kinds) + none,
        "ranges": {"kinds": (*ends, *ends)},
        "palette": palette,
        "names": list(map(escape, names)),
        "codes": [int(code) for code in colours.codes],
    }


def _square(colour: str, text: str, meaning: str) -> str:
    """Return an item of a legend."""
    square = f'<i style="background:{colour}"></i>'
    return f'<span title="{escape(meaning)}">{square}{escape(text)}</span>'


def _unit(quantity: Quantity) -> str:
    return f" {as_html(quantity.units)}" if quantity.units else ""


def _range(ds: xr.Dataset, name: str, *, log: bool = False) -> tuple[float, ...]:
    """Return the range of a variable for its colours, and the limits of its axis."""
    ends = value_range(ds, name, log=log)
    return (*ends, *axis_limits(*ends, log=log))


def sources(ds: xr.Dataset, variables: Mapping[str, Colours]) -> Iterator[ColumnDataSource]:
    """Yield the numbers of the points in C order: parameters, variables, and where these jump.

    The number of a kind is its place among the kinds in the result.
    """
    for name in parameters_of(ds):
        if ds[name].dtype.kind in "fiu":
            yield _source(name, ds[name].values.astype(float))
    values = {name: np.ma.filled(c.placed(ds), np.nan) for name, c in variables.items()}
    for name, numbers in values.items():
        yield _source(name, numbers.astype(np.float32))
    heights = {name: numbers for name, numbers in values.items() if not variables[name].codes}
    # Each bit of a point's number says whether a variable jumps over the interval after the point.
    bits = np.array([list(values).index(name) for name in heights], dtype=np.uint32)
    weights = np.uint32(1) << bits
    for dim in map(str, ds["status"].dims):
        if dim != DIRECTION and heights:
            found = _jumps_along(ds, dim, np.stack([*heights.values()]))
            jumping = np.tensordot(weights, found.astype(np.uint32), axes=1)
            yield _source(f"jumps along {dim}", jumping)


def _source(name: str, values: Array) -> ColumnDataSource:
    return ColumnDataSource({"values": values.ravel()}, name=f"values of {name}")


def _jumps_along(ds: xr.Dataset, dim: str, heights: Array) -> Array:
    """Return True for each variable that jumps over the interval after a point (variable, ...)."""
    axis = list(ds["status"].dims).index(dim) - ds["status"].ndim  # of the last axes of heights
    steps = axis_of(ds, dim, named=True).steps
    found = jumps(ds.transpose(..., dim), steps, np.moveaxis(heights, axis, -1))
    ahead = [(0, 0)] * (found.ndim - 1) + [(0, 1)]
    return np.moveaxis(np.pad(found, ahead), -1, axis)
