"""Variables over one axis (Figs. 7-9), with measured points; the picture of a fit."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from stickslip.variables import PARAMETERS, RESULTS
from sweeps.charts.axes import MANY, Axis, Layout, axis_of, coordinate_of, thinned
from sweeps.charts.chart import Curve, axis_limits, break_line, curves_of, range_with_bands
from sweeps.charts.colours import (
    BLACK,
    KINDS,
    SINGLE,
    CurveStyle,
    hue_of,
    way_style,
)
from sweeps.charts.labels import (
    DIRECTIONS,
    Array,
    legend_label,
    shown,
    shown_number,
    with_error,
)
from sweeps.charts.missing import missing_notes, missing_points
from sweeps.figures.panels import Panel, facet_panels, label_axes, name_kinds
from sweeps.figures.style import (
    has_small_print,
    line_at,
    line_of,
    make_logarithmic,
    new_panels,
    palette,
    put_legend,
    put_note,
    width_of,
)
from sweeps.grid import CASE, DIRECTION
from sweeps.human import counted

if TYPE_CHECKING:
    from sweeps.measurements import Floats, Measurements


_FEW = 20  # up to this number of points each has a marker
_ROW = 0.035  # of a panel's height: one row of crosses for missing points
_WAY_WIDTH = 1.4  # points, in the legend
_UP_AT, _HEAD = 0.6, 9.0  # where on a curve its arrow is; the size of the arrow in points
_BAND = 0.2  # opacity
_BAR = 3.0  # points: the width of the bar in place of a band
_MARGIN = 0.02  # beside a curve, as a part of its length; markers need more


def draw_curves(
    ds: xr.Dataset,
    layout: Layout,
    variables: Sequence[str],
    scales: frozenset[str] = frozenset(),
    data: Measurements | None = None,
) -> Figure:
    """Draw a row of panels for each variable, which share the x axis, and a column for each facet.

    A missing point is a gap in its curve, and a cross in the same colour at the top of the panel.
    Measured points lie over the curve of their parameters.
    """
    ds, note = thinned(ds, layout.hue, MANY)
    axis = axis_of(ds, str(layout.x), log="x" in scales)
    ds = ds.isel({axis.dim: axis.order})
    drawn = facet_panels(ds, layout, variables, of_axes=False)
    # The row of each curve's crosses, from the top; curves without missing points need none.
    missing = missing_points(drawn.dataset, variables)
    gaps = missing.any([dim for dim in missing.dims if dim != layout.hue]).values
    crosses = [int(row) for row in np.cumsum(np.atleast_1d(gaps))]
    logarithmic = [n for n in variables if scales & {"y", "z"} and n not in KINDS]
    for panel in drawn.panels:
        log = panel.variable in logarithmic
        _draw_panel(panel, axis, layout, variables, crosses)
        panel.axes.set_xmargin(_MARGIN if axis.order.size > _FEW else 2 * _MARGIN)
        panel.axes.update_datalim([(x, 0.0) for x in axis.quantity.values[[0, -1]]], updatey=False)
        make_logarithmic(panel.axes, ["x"] * axis.geometric + ["y"] * log)
    elsewhere = 0
    on: list[np.ndarray] = []
    if data is not None:
        if not set(data.variable) & set(variables):
            raise ValueError(
                f"the data are for {', '.join(dict.fromkeys(data.variable))}, but this picture "
                f"shows {', '.join(variables)}"
            )
        on = [draw_measured(panel, axis, layout, data, drawn.dataset) for panel in drawn.panels]
        own = np.isin(data.variable, variables)
        # A value is drawn if any of several panels has its parameters.
        elsewhere = int((own & ~np.any(on, axis=0)).sum())
    for panel in drawn.panels:
        log = panel.variable in logarithmic
        low, high = range_with_bands(drawn.dataset, panel.variable, log=log)
        if data is not None:
            low, high = _range_with_data(low, high, panel, data, np.any(on, axis=0), log=log)
        panel.axes.set(ylim=axis_limits(low, high, 1.0 / (1.0 - _ROW * crosses[-1]), log=log))
        name_kinds(panel.axes, drawn.dataset, panel.variable)
    label_axes(drawn, axis.label, [shown(ds[name]).label for name in variables])
    if handles := _legend(ds, layout):
        put_legend(drawn.figure, handles, short=_legend(ds, layout, short=True))
    lost = missing_notes(drawn.dataset, variables, "× ", log=logarithmic)
    others = counted(elsewhere, "measured value")
    apart = f"Not drawn: {others} at other parameters." if elsewhere else ""
    put_note(drawn.figure, [*lost, note, *drawn.notes, apart])
    if apart and not has_small_print():
        warnings.warn(apart, stacklevel=6)  # the line that called the accessor's `plot`
    return drawn.figure


def _draw_panel(
    panel: Panel, axis: Axis, layout: Layout, variables: Sequence[str], rows: list[int]
) -> None:
    axes, colours = panel.axes, palette()
    for curve in curves_of(panel.dataset, layout, axis, panel.variable):
        style = curve.style(colours)
        _draw_line(axes, axis, curve, style, marked=True)
        _draw_arrow(axes, axis.quantity.values, curve, style.colour)
        _draw_bands(axes, axis, curve, style.colour)
        missing = missing_points(panel.dataset.isel(curve.places), variables).values
        if missing.any():
            row = rows[curve.places.get(str(layout.hue), 0)]
            heights = np.full(missing.sum(), 1.0 - _ROW * (row - 0.3))
            above: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "gid": "missing"}
            above |= {"color": style.colour, "markersize": 3.0}
            axes.plot(axis.quantity.values[missing], heights, "x", **above)
    if axis.names:
        axes.set_xticks(axis.quantity.values, labels=axis.names)
    if panel.dataset[panel.variable].dtype.kind in "iu":
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _draw_line(
    axes: Axes, axis: Axis, curve: Curve, style: CurveStyle, *, marked: bool = False
) -> None:
    """Draw a curve, with a gap and a thin dotted vertical line in the middle of each jump.

    A `marked` curve of few points has a marker at each; a longer one has markers at the points that
    no line reaches.
    """
    x, y = break_line(axis, curve.values, curve.jumps)
    marks: dict[str, Any] = {}
    if marked:
        alone = _stands_alone(y) if y.size > _FEW else np.isfinite(y)
        marks = {"marker": "o", "markevery": np.flatnonzero(alone).tolist()}
    axes.plot(x, y, **marks, **line_of(style))
    dotted: dict[str, Any] = {"color": style.colour, "linewidth": 0.7, "gid": "jump"}
    for i in np.flatnonzero(curve.jumps):
        axes.plot([axis.middles[i]] * 2, curve.values[i : i + 2], ":", **dotted)


def _draw_bands(axes: Axes, axis: Axis, curve: Curve, colour: str) -> None:
    """Draw the bands of a curve with gaps at its jumps; a point that no band reaches has a bar."""
    for ends in curve.bands:
        (x, low), (_, high) = (break_line(axis, end, curve.jumps) for end in ends)
        axes.fill_between(x, low, high, color=colour, alpha=_BAND, linewidth=0.0)
        alone = _stands_alone(low) & (high > low)
        if alone.any():
            bar: dict[str, Any] = {"color": colour, "alpha": 2 * _BAND, "linewidth": _BAR}
            axes.vlines(x[alone], low[alone], high[alone], **bar)


def _stands_alone(y: Array) -> np.ndarray:
    """Return True for the values that no line reaches."""
    finite = np.pad(np.isfinite(y), 1)
    alone: np.ndarray = finite[1:-1] & ~finite[:-2] & ~finite[2:]
    return alone


def _draw_arrow(axes: Axes, x: Array, curve: Curve, colour: str) -> None:
    """Draw the head of an arrow, away from jumps, in the direction in which a curve is followed."""
    steps = np.flatnonzero(np.isfinite(curve.values[:-1] + curve.values[1:]) & ~curve.jumps)
    if not curve.way or not steps.size:
        return
    upward = curve.way == "up"
    step = steps[int((_UP_AT if upward else 1.0 - _UP_AT) * (steps.size - 1))]
    ends = [(x[place], curve.values[place]) for place in (step, step + 1)]
    tail, head = ends if upward else reversed(ends)
    arrow = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", head, tail, arrowprops=arrow | {"mutation_scale": _HEAD}, zorder=4)


def _legend(ds: xr.Dataset, layout: Layout, *, short: bool = False) -> list[Line2D]:
    """Return a line and a label for each curve; `short` labels share one symbol and unit."""
    ways = [str(way) for way in ds[DIRECTION].values] if layout.both_ways else []
    handles: list[Line2D] = []
    if layout.hue is not None:
        count = ds.sizes[layout.hue]
        labels = [legend_label(ds, layout.hue, index) for index in range(count)]
        if short and layout.hue in PARAMETERS:
            handles.append(
                Line2D([], [], linestyle="none", label=f"{shown(ds[layout.hue]).label}:")
            )
            labels = [shown(value).number for value in ds[layout.hue]]
        for index, label in enumerate(labels):
            style = line_at(hue_of(layout.hue, index, count))
            line = line_of(way_style(style, "up" if ways else ""))
            handles.append(Line2D([], [], **line, label=label))
    # Only a single curve has a colour for each direction; others differ in their dashes.
    of_way = SINGLE if layout.hue is None else CurveStyle(BLACK, _WAY_WIDTH)
    for way in ways:
        line = line_of(way_style(of_way, way))
        handles.append(Line2D([], [], **line, label=DIRECTIONS.get(way, way)))
    return handles


# --- measured points over the curves of a sweep ---------------------------------------------------

_THIN = 0.8  # points: edges and error bars
_SAME = 0.01  # relative distance within which a measurement belongs to a panel or curve


def draw_measured(
    panel: Panel, axis: Axis, layout: Layout, data: Measurements, whole: xr.Dataset
) -> np.ndarray:
    """Draw the measured values of a panel's variable; return which of the data these are.

    A measured value has the colour of the nearest curve, or is white if the data do not have the
    parameter that tells curves apart. `whole` is the dataset of all panels. Raises ValueError if
    the data lack the parameter of the horizontal axis.
    """
    across = str(coordinate_of(panel.dataset, axis.dim).name)
    if across not in data.parameters:
        raise ValueError(f"the data have no column {across}, which is the horizontal axis")
    _refuse_other_unit(panel)
    own = np.array([name == panel.variable for name in data.variable])
    left: np.ndarray = own & _belongs(panel, axis, layout, data, whole)[data.row]
    if layout.hue is None or (nearest := _nearest_places(whole, layout.hue, data)) is None:
        _draw_points(panel, data, across, left, "white")
        return left
    count = whole.sizes[layout.hue]
    for place in range(count):
        colour = line_at(hue_of(layout.hue, place, count)).colour
        _draw_points(panel, data, across, left & (nearest == place)[data.row], colour)
    drawn: np.ndarray = left & (nearest >= 0)[data.row]
    return drawn


def _refuse_other_unit(panel: Panel) -> None:
    """Raise ValueError if a user converted the variable of a panel; data are in SI units."""
    ours, units = RESULTS[panel.variable].units, panel.dataset[panel.variable].attrs.get("units")
    if units not in (None, ours):
        raise ValueError(
            f"the data are in {ours} and {panel.variable} is in {units}: convert it back to {ours}"
        )


def _belongs(
    panel: Panel, axis: Axis, layout: Layout, data: Measurements, whole: xr.Dataset
) -> np.ndarray:
    """Return which rows of the data have the parameters of a panel, apart from its hue."""
    across = str(coordinate_of(panel.dataset, axis.dim).name)
    here = np.ones(data.rows, dtype=bool)
    for name, values in data.parameters.items():
        if name == across or name not in whole.coords:
            continue
        if whole[name].size == 1:
            here &= _is_near(values, whole[name].values.item())
        elif whole[name].dims == (axis.dim,):  # linked to the horizontal axis
            x = data.parameters[across]
            here &= _is_near(values, np.interp(x, whole[across].values, whole[name].values))
    for dim in filter(None, (layout.col, layout.row)):
        if (nearest := _nearest_places(whole, dim, data)) is not None:
            name = str(coordinate_of(whole, dim).name)
            here &= (nearest >= 0) & (whole[name].values[nearest] == panel.dataset[name].item())
    return here


def _nearest_places(whole: xr.Dataset, dim: str, data: Measurements) -> np.ndarray | None:
    """Return for each row of the data the nearest point of a dimension; -1 if none is near.

    None if the data lack all parameters along the dimension.
    """
    names = [n for n in data.parameters if n in whole.coords and whole[n].dims == (dim,)]
    if not names:
        return None
    distance = np.zeros((data.rows, whole.sizes[dim]))
    for name in names:
        values, there = data.parameters[name][:, None], whole[name].values
        apart = np.abs(values - there) / np.maximum(np.abs(there), np.finfo(float).tiny)
        distance = np.maximum(distance, np.where(_is_near(values, there), apart, np.inf))
    nearest: np.ndarray = np.where(np.isfinite(distance.min(1)), distance.argmin(1), -1)
    return nearest


def _draw_points(
    panel: Panel, data: Measurements, across: str, on: np.ndarray, colour: str
) -> None:
    x = [shown_number(across, value).values for value in data.parameters[across][data.row[on]]]
    measured, error = _measured(panel, data, on)
    style = _style_of_data(colour)
    panel.axes.errorbar(x, measured, None if data.relative else error, elinewidth=_THIN, **style)


def _style_of_data(colour: str) -> dict[str, Any]:
    """Return the markers of measured values: circles of a colour, such as that of their curve."""
    return {
        "color": BLACK,  # edges and bars stand out from a curve of any colour, in grey as well
        "linestyle": "none",
        "marker": "o",
        "markersize": 4.0,
        "markerfacecolor": colour,
        "markeredgewidth": _THIN,
        "zorder": 4,
    }


def _measured(panel: Panel, data: Measurements, on: np.ndarray) -> tuple[Array, Array]:
    """Return some measured values and their errors in the unit of the panel's variable."""
    units = {"units": panel.dataset[panel.variable].attrs.get("units", "1")}
    value, error = (
        shown(xr.DataArray(values[on], dims="datum", attrs=units)).values
        for values in (data.value, data.error)
    )
    return value, error


def _range_with_data(
    low: float, high: float, panel: Panel, data: Measurements, on: np.ndarray, *, log: bool
) -> tuple[float, float]:
    """Return the range of a panel, extended to the measured values of its variable."""
    own = on & np.array([name == panel.variable for name in data.variable])
    value, error = _measured(panel, data, own)
    bar = np.zeros_like(error) if data.relative else error
    ends = np.concatenate([value, value - bar, value + bar])
    ends = ends[np.isfinite(ends) & (ends > 0.0 if log else True)]
    return float(ends.min(initial=low)), float(ends.max(initial=high))


def _is_near(values: Floats, there: Floats | float) -> np.ndarray:
    near: np.ndarray = np.isclose(values, there, rtol=_SAME, atol=0.0)
    return near


# --- a fit: measurements and the fitted curve, and the residuals below ----------------------------

_DATUM = "datum"
_HEIGHT = 3.4  # inches
_RATIOS = {"height_ratios": [3, 1]}


def fit(ds: xr.Dataset) -> Figure:
    """A column for each measured variable: data and fitted curve above, residuals below.

    They lie over the swept parameter, with a curve for each value of another parameter. Data that
    form no curve lie over their numbers, with the fitted values as crosses. Data next to a jump are
    squares.
    """
    names = list(dict.fromkeys(map(str, ds.datum_variable.values)))
    sweep = ds.drop_dims([str(dim) for dim in ds.sizes if dim not in ds["status"].dims])
    # A dataset may be transposed; the horizontal axis has the most points.
    dims = sorted(map(str, ds["status"].dims), key=lambda dim: -ds.sizes[dim])
    figure, panels = new_panels(
        2, len(names), (width_of(len(names)), _HEIGHT), sharex="col", gridspec_kw=_RATIOS
    )
    is_curve = bool(dims) and dims[0] != CASE
    layout = Layout(x=dims[0], hue=dims[1] if dims[1:] else None) if is_curve else Layout()
    colours = palette()
    for name, (above, below) in zip(names, panels.T, strict=True):
        axis = axis_of(sweep, str(layout.x)) if is_curve else None
        if axis is not None:
            for curve in curves_of(sweep.isel({axis.dim: axis.order}), layout, axis, name):
                _draw_line(above, axis, curve, curve.style(colours))
        for x, numbers, style in _data_of_curves(ds, sweep, layout, name):
            data = ds.isel({_DATUM: numbers})
            _draw_data(above, below, data, x, style, crosses=axis is None)
        below.margins(y=0.2)
        below.axhline(0.0, color="0.5", linewidth=0.6)
        below.set_xlabel(axis.label if axis else "datum number")
        above.set_ylabel(shown_number(name, 0.0).label)
        if axis and axis.geometric:
            make_logarithmic(below, ["x"])
    panels[1, 0].set_ylabel("residual")
    figure.align_labels()
    if layout.hue:
        put_legend(figure, _legend(sweep, layout))
    at_jump = "Squares mark data next to a jump." if (ds.datum_at_jump == 1).any() else ""
    left_out = int((~_of_curves(ds, sweep)).sum()) if is_curve else 0
    apart = f"Not drawn: {left_out} data at other parameters." if left_out else ""
    put_note(figure, [_fitted(ds), f"Residuals are in standard errors. {at_jump}".rstrip(), apart])
    return figure


def _data_of_curves(
    ds: xr.Dataset, sweep: xr.Dataset, layout: Layout, name: str
) -> Iterator[tuple[Array, Array, CurveStyle]]:
    """Yield, for each curve of a variable, x of the data, their numbers, and the style."""
    own = ds.datum_variable.values == name
    if layout.x is None:
        yield 1.0 + np.arange(own.sum()), np.flatnonzero(own), SINGLE
        return
    own &= _of_curves(ds, sweep)
    count = sweep.sizes[layout.hue] if layout.hue else 1
    for place in range(count):
        on = own
        if layout.hue:
            on = own & (ds[f"{_DATUM}_{layout.hue}"].values == sweep[layout.hue].values[place])
        x = ds[f"{_DATUM}_{layout.x}"].rename(layout.x)[on]
        yield shown(x).values, np.flatnonzero(on), line_at(hue_of(layout.hue, place, count))


def _of_curves(ds: xr.Dataset, sweep: xr.Dataset) -> np.ndarray:
    """Return which data have the parameters of the curves, of which a part may be chosen."""
    on = np.ones(ds.sizes[_DATUM], dtype=bool)
    for name in PARAMETERS:
        if f"{_DATUM}_{name}" in ds.variables and name in sweep.coords and sweep[name].size == 1:
            on &= ds[f"{_DATUM}_{name}"].values == sweep[name].values.item()
    return on


def _draw_data(
    above: Axes, below: Axes, data: xr.Dataset, x: Array, style: CurveStyle, *, crosses: bool
) -> None:
    units = {"units": RESULTS[str(data.datum_variable.values[0])].units} if x.size else {}
    measured, error, fitted = (
        shown(xr.DataArray(data[name].values, dims=_DATUM, attrs=units)).values
        for name in ("measured_value", "measured_error", "fitted_value")
    )
    look = _style_of_data("white" if style == SINGLE else style.colour)
    at_jump = data.datum_at_jump.values == 1
    for jumping, marker in ((False, "o"), (True, "s")):
        own = at_jump == jumping
        if not own.any():
            continue
        marks = look | {"marker": marker}
        above.errorbar(x[own], measured[own], error[own], elinewidth=_THIN, **marks)
        below.plot(x[own], data.residual.values[own], **marks)
    if crosses:
        above.plot(x, fitted, **(look | {"marker": "x", "zorder": 5}))


def _fitted(ds: xr.Dataset) -> str:
    """Return the fitted values as a sentence, rounded as in the printed summary.

    It is empty without the package uncertainties, which fitting needs and drawing does not.
    """
    if find_spec("uncertainties") is None:
        return ""
    words = []
    for name in map(str, ds.free_parameter.values):
        own = ds.sel(free_parameter=name)
        fitted, error = (
            shown_number(name, float(own[f"parameter_{what}"]))
            for what in ("value", "standard_error")
        )
        if np.isfinite(error.values) and error.values > 0:
            rounded = with_error(float(fitted.values), float(error.values), mathtext=True)
            equation = f"${fitted.symbol.strip('$')} = {rounded}$"
            words.append(f"{equation} {fitted.units}".rstrip())
        else:
            words.append(f"{fitted.equation} (error unknown)")
    reduced = float(ds.attrs["reduced_chi2"])
    scatter = f"$\\chi^2$/dof {reduced:.3g}"
    if str(ds.attrs.get("measurement_errors")).startswith("none"):
        scatter = f"relative scatter {100 * np.sqrt(reduced):.2g}\u00a0%"
    return f"Fitted: {', '.join(words)}; {scatter}."
