"""The numbers of a result and what they are called, as the scripts of its page take them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.colors import to_hex

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.figure_table import AMPLITUDES
from sweeps.figures.colours import KINDS, code_name, colours_of, is_discrete
from sweeps.figures.labels import DIRECTIONS, legend_label, shown
from sweeps.figures.layout import Axis
from sweeps.figures.maps import cell_edges
from sweeps.figures.missing import trusted, value_range
from sweeps.figures.style import GREY
from sweeps.grid import CASE, DIRECTION
from sweeps.views.report.packing import packed
from sweeps.views.report.views import View, is_uniform
from sweeps.views.symbols import plain

# What a reader looks at first.
_FIRST = (*AMPLITUDES, "regime", "status", "amplitude_error")

_SENTENCES: Mapping[str, type[Regime] | type[Status]] = {"regime": Regime, "status": Status}


def payload(ds: xr.Dataset, axes: Mapping[str, Axis], views: list[View]) -> dict[str, Any]:
    """All that the scripts know of a result; `ds` is in the order of its axes."""
    dims = list(axes)
    return {
        "missing": to_hex(GREY),
        "palette": palette(),
        "start": [_start(ds, dim) for dim in dims],
        "axes": [_axis(ds, axis) for axis in axes.values()],
        "parameters": [_parameter(ds, name, dims) for name in _varied_first(ds)],
        "variables": [_variable(ds.transpose(*dims), name) for name in _variables(ds)],
        "views": [_view(view, dims) for view in views],
    }


def palette() -> list[str]:
    """The colours of a scale of values, from low to high."""
    return [to_hex(colour) for colour in colormaps[mpl.rcParams["image.cmap"]](np.arange(256))]


def _axis(ds: xr.Dataset, axis: Axis) -> dict[str, Any]:
    return {
        "name": axis.dim,
        "size": ds.sizes[axis.dim],
        "label": axis_label(axis),
        "places": axis.quantity.values.tolist(),
        "edges": cell_edges(axis).tolist(),
        "uniform": is_uniform(axis),
        "geometric": axis.geometric,
        "names": [plain(name).replace("\n", " ") for name in axis.names],
    }


def _start(ds: xr.Dataset, dim: str) -> int:
    """Where to look first: at the paper's value, or in the middle of an axis without it."""
    values, usual = ds[dim].values, PARAMETERS[dim].default if dim in PARAMETERS else np.nan
    if dim in PARAMETERS and values.min() <= usual <= values.max():
        return int(np.argmin(np.abs(values - usual)))
    return ds.sizes[dim] // 2


def axis_label(axis: Axis) -> str:
    """Symbol and unit of an axis; one of named points has no unit."""
    return plain(axis.label) or symbol_of(axis.dim)


def _varied_first(ds: xr.Dataset) -> list[str]:
    """The parameters of the points: those that vary, in the order of the axes, then the others."""
    known = [name for name in (CASE, *PARAMETERS, DIRECTION) if name in ds.coords]
    varied = [name for dim in ds["status"].dims for name in known if ds[name].dims == (dim,)]
    return [*varied, *(name for name in known if name not in varied)]


def _parameter(ds: xr.Dataset, name: str, dims: list[str]) -> dict[str, Any]:
    coordinate = ds[name]
    about: dict[str, Any] = {
        "name": name,
        "axis": dims.index(str(coordinate.dims[0])) if coordinate.dims else None,
    }
    if name == DIRECTION:
        keys = np.atleast_1d(coordinate.values).astype(str).tolist()
        return about | {"keys": keys, "texts": [DIRECTIONS.get(key, key) for key in keys]}
    one = shown(xr.ones_like(coordinate, dtype=float))
    return about | {
        "symbol": symbol_of(name),
        "units": plain(one.units),
        "factor": float(one.values.flat[0]),
        "values": packed(coordinate.values, "f8"),
    }


def _variables(ds: xr.Dataset) -> list[str]:
    there = [name for name in RESULTS if name in ds.data_vars]
    return [*(n for n in _FIRST if n in there), *(n for n in there if n not in _FIRST)]


def _variable(ds: xr.Dataset, name: str) -> dict[str, Any]:
    quantity, words = shown(trusted(ds, name)), name.replace("_", " ")
    is_word = plain(quantity.symbol).replace("_", " ") in words  # and says less than the name
    about = {
        "name": name,
        "called": words if is_word else f"{words}, {plain(quantity.symbol)}",
        "units": plain(quantity.units),
        "label": words if is_word else plain(quantity.label),
        "meaning": RESULTS[name].meaning,
        "values": packed(quantity.values),
        "kinds": [],
    }
    return about | (_of_kinds(ds, name) if is_discrete(ds, name) else _of_numbers(ds, name))


def _of_kinds(ds: xr.Dataset, name: str) -> dict[str, Any]:
    """The codes or counts that there are, with the colours that they have in all pictures."""
    colours = colours_of(ds, name)
    kinds = [
        {"code": code, "name": code_name(name, code), "colour": to_hex(colours.cmap(place))}
        | {"sentence": _sentence(name, code)}
        for place, code in enumerate(colours.codes)
    ]
    return {"kinds": kinds, "named": name in KINDS}


def _sentence(name: str, code: int) -> str:
    meanings = _SENTENCES.get(name)
    return meanings(code).sentence if meanings and code in list(meanings) else ""


def _of_numbers(ds: xr.Dataset, name: str) -> dict[str, Any]:
    low, high = value_range(ds, name)
    return {"range": [low, high], "log_range": list(value_range(ds, name, log=True))}


def _view(view: View, dims: list[str]) -> dict[str, Any]:
    return {
        "kind": view.kind,
        "label": view_label(view),
        "x": view.x,
        "y": view.y,
        "hue": view.hue,
        "ways": view.both_ways,
        "sliders": [place for place, dim in enumerate(dims) if dim not in view.dims],
        "figure": view.name,
    }


def view_label(view: View) -> str:
    """What a view is called where it is chosen."""
    kind = "points" if view.kind == "point map" else view.kind
    return f"{kind} over {' and '.join(symbol_of(name) for name in (view.x, view.y) if name)}"


def symbol_of(name: str) -> str:
    """The symbol of a parameter; what is none, such as a case, is called by its name."""
    return plain(f"${PARAMETERS[name].tex}$") if name in PARAMETERS else name


def curve_names(ds: xr.Dataset, view: View) -> Iterator[str]:
    """The names of the curves of a view, as a legend has them."""
    for place in range(ds.sizes[view.hue] if view.hue else 0):
        yield plain(legend_label(ds, str(view.hue), place))
