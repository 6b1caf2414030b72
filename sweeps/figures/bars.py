"""The picture of Sobol indices: bars for each parameter, the largest at the top."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.variables import PARAMETERS
from sweeps.charts.labels import VARIABLES
from sweeps.figures.style import new_panels, palette, put_note, width_of

_BAR = 0.36  # of the distance between two parameters
_ORDERS = (("first_order", "first order", -0.5), ("total_order", "total", 0.5))


def indices(ds: xr.Dataset) -> Figure:
    """A column for each result: the first-order and total indices of each parameter."""
    names = list(map(str, ds.result.values))
    size = (width_of(len(names)), 1.2 + 0.42 * ds.sizes["parameter"])
    figure, panels = new_panels(1, len(names), size, sharey=True)
    order = ds.total_order.max("result").argsort().values
    for name, axes in zip(names, panels[0], strict=True):
        _draw_bars(ds.sel(result=name).isel(parameter=order), axes)
        axes.set_title(VARIABLES[name].meaning)
    panels[0, 0].legend(loc="lower right", frameon=False)
    percent = f"{100 * ds.attrs['confidence_level']:g}"
    used = ds.attrs["base_points"] - ds.attrs["base_points_without_result"]
    put_note(figure, [f"{used} base points, {percent} % intervals"])
    return figure


def _draw_bars(one: xr.Dataset, axes: Axes) -> None:
    """Draw the bars of one result, from the lowest parameter up, with confidence intervals."""
    places, colours = np.arange(one.sizes["parameter"]), palette().cycle
    for (order, label, side), colour in zip(_ORDERS, colours, strict=False):
        heights, (low, high) = places - side * _BAR, one[f"{order}_interval"].values.T
        axes.barh(heights, one[order].values, _BAR, label=label, color=colour)
        axes.hlines(heights, low, high, color="black", linewidth=0.8)
    symbols = (PARAMETERS[str(name)].tex for name in one.parameter.values)
    axes.set_yticks(places, [f"${symbol}$" for symbol in symbols])
    axes.set_xlabel("Sobol index")
    axes.set_xlim(min(0.0, axes.get_xlim()[0]), None)
