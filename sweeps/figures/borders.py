"""Borders between kinds of motion, drawn on the maps whose borders they are."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from sweeps.charts.axes import Axis
from sweeps.charts.borders import STYLES, are_over, axes_of, elsewhere_than, parts_of
from sweeps.charts.styles import BLACK
from sweeps.figures.panels import Panel

_WIDTH = 1.0  # points: well above the 0.4 between pixels


def draw_borders(panels: Iterable[Panel], borders: xr.Dataset, across: Axis, up: Axis) -> None:
    """Draw the borders on those panels that have the values of the other parameters.

    Raises ValueError if they are borders over other axes, or of no panel.
    """
    if not are_over(borders, across, up):
        raise ValueError(
            f"these are borders over {' and '.join(axes_of(borders))}: choose these axes"
        )
    parts = list(parts_of(borders, across.dim, up.dim))
    lines = [places for places, _, _ in parts]
    styles = [STYLES[name] for _, _, name in parts]
    elsewhere = ""
    drawn = 0
    for panel in panels:
        if elsewhere := elsewhere_than(panel.dataset, borders):
            continue
        panel.axes.add_collection(
            LineCollection(lines, colors=BLACK, linewidths=_WIDTH, linestyles=styles),
            autolim=False,
        )
        drawn += 1
    if not drawn:
        raise ValueError(elsewhere)


def border_legend(borders: xr.Dataset) -> list[Line2D]:
    """Return a line and a label for each type of border; nothing where all are of one."""
    names = [name for _, _, name in parts_of(borders, *axes_of(borders))]
    look: dict[str, Any] = {"color": BLACK, "linewidth": _WIDTH}
    shown_types = [name for name in STYLES if name in names]
    return [
        Line2D([], [], label=f"border: {name}", **look | {"linestyle": STYLES[name]})
        for name in shown_types
        if len(shown_types) > 1
    ]
