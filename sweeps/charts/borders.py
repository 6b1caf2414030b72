"""Borders between kinds of motion: the lines in a file of `stickslip boundary`."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS
from sweeps.charts.axes import Axis
from sweeps.charts.labels import parameters_along, shown

_GRAZING = 0  # a `type` of border
STYLES = {"grazing": "solid", "fold": "dashed"}


def require_borders(ds: xr.Dataset) -> None:
    """Raise ValueError if a dataset holds no borders over two axes."""
    if not {"line", "kind_left", "kind_right", "type"} <= set(ds.variables):
        raise ValueError("this is no file of borders, which `stickslip boundary` writes")
    if len(axes_of(ds)) != 2:
        raise ValueError(f"borders are drawn on maps; these are points along {axes_of(ds)[0]}")


def require_borders_of(ds: xr.Dataset, borders: xr.Dataset) -> None:
    """Raise ValueError if a dataset holds no borders over two axes of a result, or at no slice."""
    require_borders(borders)
    names = axes_of(borders)
    if any(parameters_along(ds, name) != [name] for name in names):
        raise ValueError(f"these are borders over {' and '.join(names)}, which are no axes here")
    if elsewhere := elsewhere_than(ds, borders):
        raise ValueError(elsewhere)


def are_over(borders: xr.Dataset, across: Axis, up: Axis) -> bool:
    """Return whether borders lie over two axes, in either order."""
    return {across.dim, up.dim} == set(axes_of(borders)) and not (across.names or up.names)


def axes_of(borders: xr.Dataset) -> list[str]:
    """Return the parameters over which borders lie."""
    return [name for name in PARAMETERS if f"{name}_bracket" in borders.variables]


def lines_of(borders: xr.Dataset, across: str, up: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return each line: its places (n, 2) in shown units, and its points (n,) in the file.

    A point alone is no line.
    """
    places = np.column_stack([shown(borders[name]).values for name in (across, up)])
    ends = np.flatnonzero(np.diff(borders["line"].values)) + 1
    lines = np.split(np.arange(len(places)), ends)
    return [(places[line], line) for line in lines if len(line) > 1]


def parts_of(
    borders: xr.Dataset, across: str, up: str
) -> Iterator[tuple[np.ndarray, np.ndarray, str]]:
    """Yield parts of lines that are of one type: places, points as of `lines_of`, and the type."""
    for places, points in lines_of(borders, across, up):
        is_grazing = borders["type"].values[points] == _GRAZING
        # A piece that ends where lines meet is what its other end is.
        pieces = is_grazing[:-1] | is_grazing[1:]
        ends = [0, *(np.flatnonzero(np.diff(pieces)) + 1).tolist(), len(pieces)]
        for start, stop in itertools.pairwise(ends):
            name = "grazing" if pieces[start] else "fold"
            yield places[start : stop + 1], points[start : stop + 1], name


def elsewhere_than(ds: xr.Dataset, borders: xr.Dataset) -> str:
    """Return where borders are if a dataset has other values of a parameter; else nothing."""
    for name in PARAMETERS:
        if name in ds.variables and name in borders.variables and borders[name].size == 1:
            there = float(borders[name].values.item())
            if not np.isclose(ds[name].values, there, rtol=1e-9, atol=0.0).any():
                return f"these are the borders at {shown(borders[name]).equation}, not here"
    return ""
