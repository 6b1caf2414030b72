"""Measured points over the curves of a sweep, with their error bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sweeps.charts.axes import Axis
from sweeps.charts.labels import parameters_along, shown, shown_number
from sweeps.charts.layout import Layout
from sweeps.charts.styles import BLACK, hue_of
from sweeps.figures.panels import Panel
from sweeps.figures.style import line_at

if TYPE_CHECKING:
    from sweeps.measurements import Floats, Measurements

_SAME = 0.01  # relative: a measurement was made at the value of a panel or a curve


def draw_measured(panel: Panel, axis: Axis, layout: Layout, data: Measurements) -> int:
    """Draw the measured values of a panel's variable; return how many are of other parameters.

    Each has the colour of the curve with its value of the hue, and is white without one. Raises
    ValueError if the data do not have the parameter of the horizontal axis.
    """
    along = parameters_along(panel.dataset, axis.dim)
    across = next((name for name in along if name in data.parameters), None)
    if across is None:
        raise ValueError(f"the data have no column {axis.dim}, which is the horizontal axis")
    own = np.array([name == panel.variable for name in data.variable])
    here = np.ones(data.rows, dtype=bool)
    for name, values in data.parameters.items():
        if name in panel.dataset.coords and panel.dataset[name].size == 1:
            here &= _is_near(values, float(panel.dataset[name].values.item()))
    left = own & here[data.row]
    drawn = np.zeros_like(left)
    hue = layout.hue if layout.hue in data.parameters else None
    count = panel.dataset.sizes[hue] if hue else 1
    for place in range(count):
        on = left
        if hue:
            value = float(panel.dataset[hue].values[place])
            on = left & _is_near(data.parameters[hue], value)[data.row]
        colour = line_at(hue_of(hue, place, count)).colour if hue else "white"
        _draw(panel, data, across, on, colour)
        drawn |= on
    return int((own & ~drawn).sum())


def _draw(panel: Panel, data: Measurements, across: str, on: np.ndarray, colour: str) -> None:
    units = {"units": panel.dataset[panel.variable].attrs.get("units", "1")}
    x = [shown_number(across, value).values for value in data.parameters[across][data.row[on]]]
    measured, error = (
        shown(xr.DataArray(values[on], dims="datum", attrs=units)).values
        for values in (data.value, data.error)
    )
    panel.axes.errorbar(
        x,
        measured,
        None if data.relative else error,
        color=BLACK,  # edges and bars: they stand out from a curve of any colour, in grey as well
        linestyle="none",
        marker="o",
        markersize=4.0,
        markerfacecolor=colour,
        markeredgewidth=0.8,
        elinewidth=0.8,
        zorder=4,
    )


def _is_near(values: Floats, value: float) -> np.ndarray:
    near: np.ndarray = np.isclose(values, value, rtol=_SAME, atol=0.0)
    return near
