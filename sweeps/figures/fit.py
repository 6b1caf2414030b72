"""The picture of a fit: measurements and the fitted curve, and the residuals below."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from stickslip.variables import RESULTS
from sweeps.charts.axes import Axis, axis_of
from sweeps.charts.curves import curves_of
from sweeps.charts.jumps import break_line
from sweeps.charts.labels import Array, legend_label, shown, shown_number
from sweeps.charts.layout import Layout
from sweeps.charts.styles import SINGLE, CurveStyle, hue_of
from sweeps.figures.curves import draw_jumps
from sweeps.figures.style import (
    line_at,
    line_of,
    make_logarithmic,
    new_panels,
    palette,
    put_legend,
    put_note,
    width_of,
)
from sweeps.grid import CASE

_DATUM = "datum"
_HEIGHT = 3.4  # inches
_RATIOS = {"height_ratios": [3, 1]}


class _Curve(NamedTuple):
    """A curve through some of the data: x of these, their numbers, and how it looks."""

    x: Array
    data: Array
    style: CurveStyle


def fit(ds: xr.Dataset) -> Figure:
    """A column for each measured variable; data next to a jump are hollow.

    Over the swept parameter, with a curve for each value of another; data that are no curve lie
    over their numbers, with the fitted values as crosses.
    """
    names = list(dict.fromkeys(map(str, ds.datum_variable.values)))
    sweep = ds.drop_dims([str(dim) for dim in ds.sizes if dim not in ds["status"].dims])
    dims = [str(dim) for dim in ds["status"].dims]
    figure, panels = new_panels(
        2, len(names), (width_of(len(names)), _HEIGHT), sharex="col", gridspec_kw=_RATIOS
    )
    is_curve = bool(dims) and dims[0] != CASE
    layout = Layout(x=dims[0], hue=dims[1] if dims[1:] else None) if is_curve else Layout()
    for name, (above, below) in zip(names, panels.T, strict=True):
        axis = axis_of(sweep, str(layout.x)) if is_curve else None
        if axis is not None:
            _draw_curves(above, sweep, layout, axis, name)
        for part in _parts(ds, sweep, layout, name):
            _draw_data(above, below, ds.isel({_DATUM: part.data}), part, crosses=axis is None)
        below.margins(y=0.2)
        below.axhline(0.0, color="0.5", linewidth=0.6)
        below.set_xlabel(axis.label if axis else "number of the datum")
        above.set_ylabel(shown_number(name, 0.0).label)
        if axis and axis.geometric:
            make_logarithmic(below, ["x"])
    panels[1, 0].set_ylabel("residual\n(standard errors)")
    figure.align_labels()
    if layout.hue:
        put_legend(figure, list(_legend(sweep, layout.hue)))
    put_note(figure, [_fitted(ds)])
    return figure


def _parts(ds: xr.Dataset, sweep: xr.Dataset, layout: Layout, name: str) -> Iterator[_Curve]:
    """Yield the data of a variable along each curve."""
    own = ds.datum_variable.values == name
    if layout.x is None:
        yield _Curve(1.0 + np.arange(own.sum()), np.flatnonzero(own), SINGLE)
        return
    count = sweep.sizes[layout.hue] if layout.hue else 1
    for place in range(count):
        on = own
        if layout.hue:
            on = own & (ds[f"{_DATUM}_{layout.hue}"].values == sweep[layout.hue].values[place])
        x = ds[f"{_DATUM}_{layout.x}"].rename(layout.x)[on]
        yield _Curve(shown(x).values, np.flatnonzero(on), line_at(hue_of(layout.hue, place, count)))


def _draw_curves(axes: Axes, sweep: xr.Dataset, layout: Layout, axis: Axis, name: str) -> None:
    colours = palette()
    for curve in curves_of(sweep.isel({axis.dim: axis.order}), layout, axis, name):
        x, y = break_line(axis, curve.values, curve.jumps)
        style = curve.style(colours)
        axes.plot(x, y, **line_of(style))
        draw_jumps(axes, axis, curve, style.colour)


def _draw_data(above: Axes, below: Axes, data: xr.Dataset, part: _Curve, *, crosses: bool) -> None:
    units = {"units": RESULTS[str(data.datum_variable.values[0])].units} if part.data.size else {}
    measured, error, fitted = (
        shown(xr.DataArray(data[name].values, dims=_DATUM, attrs=units)).values
        for name in ("measured_value", "measured_error", "fitted_value")
    )
    look: dict[str, Any] = {"color": part.style.colour, "linestyle": "none", "markersize": 3.5}
    at_jump = data.datum_at_jump.values == 1
    for hollow, fill in ((False, part.style.colour), (True, "white")):
        own = at_jump == hollow
        if not own.any():
            continue
        dots: dict[str, Any] = {"marker": "o", "markerfacecolor": fill, "zorder": 4}
        above.errorbar(part.x[own], measured[own], error[own], elinewidth=0.8, **look, **dots)
        below.plot(part.x[own], data.residual.values[own], **look, **dots)
    if crosses:
        above.plot(part.x, fitted, **(look | {"marker": "x", "zorder": 5}))


def _legend(sweep: xr.Dataset, hue: str) -> Iterator[Line2D]:
    count = sweep.sizes[hue]
    for place in range(count):
        label = legend_label(sweep, hue, place)
        yield Line2D([], [], **line_of(line_at(hue_of(hue, place, count))), label=label)


def _fitted(ds: xr.Dataset) -> str:
    """Return the fitted values as a sentence, each with the digits that its error leaves it."""
    words = []
    for name in map(str, ds.free_parameter.values):
        own = ds.sel(free_parameter=name)
        value, error = float(own.parameter_value), float(f"{own.parameter_standard_error:.2g}")
        if np.isfinite(error) and error > 0:
            digits = 1 - math.floor(math.log10(error))  # two of the error
            equation = shown_number(name, round(value, digits)).equation
            number, space, units = equation.partition("$ ")
            words.append(
                f"{number.rstrip('$')}$ ± {shown_number(name, error).number}{space[1:]}{units}"
            )
        else:
            words.append(f"{shown_number(name, value).equation} (error unknown)")
    reduced = float(ds.attrs["reduced_chi2"])
    scatter = f"$\\chi^2$/dof {reduced:.3g}"
    if str(ds.attrs.get("measurement_errors")).startswith("none"):
        scatter = f"relative scatter {100 * np.sqrt(reduced):.2g}\u00a0%"
    return f"Fitted: {', '.join(words)}; {scatter}."
