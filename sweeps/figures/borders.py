"""Borders between kinds of motion, drawn on the maps whose borders they are."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection

from stickslip.variables import PARAMETERS
from sweeps.figures.labels import shown
from sweeps.figures.layout import Axis
from sweeps.figures.panels import Panel

_WIDTH = 1.0  # points: well above the 0.4 between pixels


def require_borders(ds: xr.Dataset) -> None:
    """Raise ValueError if a dataset holds no borders over two axes."""
    if not {"line", "kind_left"} <= set(ds.variables):
        raise ValueError("this is no file of borders, which `stickslip boundary` writes")
    if len(_axes(ds)) != 2:
        raise ValueError(f"borders are drawn on maps; these are points along {_axes(ds)[0]}")


def draw_borders(panels: Iterable[Panel], borders: xr.Dataset, across: Axis, up: Axis) -> None:
    """Draw the borders on those panels that have the values of the other parameters.

    Raises ValueError if they are borders over other axes, or of no panel.
    """
    if {across.dim, up.dim} != set(_axes(borders)) or across.names or up.names:
        raise ValueError(
            f"these are borders over {' and '.join(_axes(borders))}: choose these axes"
        )
    lines = _lines(borders, across.dim, up.dim)
    own = [panel for panel in panels if not _other_value(panel.dataset, borders)]
    for panel in own:
        panel.axes.add_collection(
            LineCollection(lines, colors="black", linewidths=_WIDTH, capstyle="round"),
            autolim=False,
        )
    if not own:
        name = next(_other_value(panel.dataset, borders) for panel in panels)
        raise ValueError(f"these are the borders at {shown(borders[name]).equation}, not here")


def _axes(borders: xr.Dataset) -> list[str]:
    return [name for name in PARAMETERS if f"{name}_bracket" in borders.variables]


def _lines(borders: xr.Dataset, across: str, up: str) -> list[np.ndarray]:
    """Return the points (n, 2) of each line, in shown units; a point alone is no line."""
    points = np.column_stack([shown(borders[name]).values for name in (across, up)])
    ends = np.flatnonzero(np.diff(borders["line"].values)) + 1
    return [line for line in np.split(points, ends) if len(line) > 1]


def _other_value(ds: xr.Dataset, borders: xr.Dataset) -> str:
    """Return the first parameter with another value than the borders have; empty if none has."""
    for name in PARAMETERS:
        both = name in ds.variables and name in borders.variables
        if both and ds[name].size == 1 and borders[name].size == 1:
            here, there = float(ds[name].values.item()), float(borders[name].values.item())
            if not np.isclose(here, there, rtol=1e-9, atol=0.0):
                return name
    return ""
