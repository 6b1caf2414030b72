"""A chart of a result (cells, curves or points), and the borders over a map, in shown units."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS
from sweeps.charts.axes import (
    STRIP,
    Axis,
    Layout,
    axis_of,
    cases_to_scatter,
    cells_of_pixels,
    fits_log,
    layout_of,
)
from sweeps.charts.choice import Choice
from sweeps.charts.colours import (
    Colours,
    CurveStyle,
    Hue,
    Palette,
    colours_of,
    curve_style,
    hue_of,
    is_discrete,
    way_style,
)
from sweeps.charts.labels import DIRECTIONS, Array, legend_label, parameters_along, shown
from sweeps.charts.missing import trusted, value_range
from sweeps.charts.quantiles import bands_of
from sweeps.grid import CASE, DIRECTION


@dataclass(frozen=True)
class Curve:
    """One curve: values over the axis, where they jump, and its place along hue and direction.

    `way` is the direction in which the curve is followed, if there are two. `bands` are the lower
    and upper ends of the spread due to noise or uncertain parameters, the widest first.
    """

    label: str
    hue: Hue
    values: Array
    jumps: Array
    places: dict[str, int]
    way: str = ""
    bands: tuple[tuple[Array, Array], ...] = ()

    def style(self, palette: Palette) -> CurveStyle:
        """Return the style of the curve in the colours of a palette."""
        return way_style(curve_style(self.hue, palette), self.way)


def curves_of(ds: xr.Dataset, layout: Layout, axis: Axis, name: str) -> Iterator[Curve]:
    """Yield a curve of a variable for each value of the hue and each direction.

    The points of `ds` must be in the order of the axis.
    """
    dims = [dim for dim in (layout.hue, DIRECTION if layout.both_ways else None) if dim]
    count, counts = ds.sizes[layout.hue] if layout.hue else 1, is_discrete(ds, name)
    for places in itertools.product(*(range(ds.sizes[dim]) for dim in dims)):
        place = dict(zip(dims, places, strict=True))
        line, hue = ds.isel(place), hue_of(layout.hue, place.get(str(layout.hue), 0), count)
        labels = [legend_label(ds, layout.hue, place[layout.hue])] if layout.hue else []
        way = ""
        if layout.both_ways:
            way = str(line[DIRECTION].values)
            labels.append(DIRECTIONS.get(way, way))
        values = shown(trusted(line, name)).values
        # No value lies between two counts.
        breaks = abs(np.diff(values)) > 0 if counts else jumps(line, axis.steps, values)
        yield Curve(", ".join(labels), hue, values, breaks, place, way, _bands(line, name, values))


def _bands(line: xr.Dataset, name: str, values: Array) -> tuple[tuple[Array, Array], ...]:
    """Return the bands of a variable: quantiles, or the spread of a mean over drive periods.

    The spread is the standard deviation between drive periods; `values` are the means, in shown
    units. Orbits of several periods have no band: their value is the largest, not the middle.
    """
    own = f"{name}_spread"
    if own not in line or "orbit_periods" not in line:
        return tuple(bands_of(line, name))
    spread = np.where(line["orbit_periods"] == 0, shown(trusted(line, own)).values, 0.0)
    if not np.nansum(spread):
        return ()
    spread = np.nan_to_num(spread)
    return ((values - spread, values + spread),)


def range_with_bands(ds: xr.Dataset, name: str, *, log: bool) -> tuple[float, float]:
    """Return the range of the values, extended to the ends of the bands; above 0 if `log`."""
    low, high = value_range(ds, name, log=log)
    bands = _bands(ds, name, shown(trusted(ds, name)).values)
    ends = np.concatenate([[low, high], *(end.ravel() for band in bands for end in band)])
    ends = ends[np.isfinite(ends) & ((ends > 0.0) | (not log))]
    return float(ends.min()), float(ends.max())


def axis_limits(
    low: float, high: float, room: float = 1.0, *, log: bool = False
) -> tuple[float, float]:
    """Return limits below the lowest point, so that a curve at zero shows, and above the highest.

    `room` is the height of the axis in units of the height that the curves need.
    """
    if log:
        span = max(high / low, 1.1)
        return low * span**-0.03, low * (span**1.05) ** room
    span = high - low
    return low - 0.03 * span, low + 1.05 * span * room


# --- jumps of a curve: the kind of motion changes, and the value is discontinuous -----------------

_KINDS = ("regime", "orbit_periods", "melting_count")  # these distinguish kinds of motion
_MARKED = 4.0  # times the steepest slope beside it; less is a bend
_VISIBLE = 0.02  # of the largest value of the curve; a smaller gap does not show on paper


def jumps(ds: xr.Dataset, steps: Array, y: Array) -> Array:
    """Return True for each interval of curves over which the value jumps, (..., n - 1).

    `steps` (n - 1,) are the distances between the points along x and `y` (..., n) the values as
    drawn; the variables of `ds` have the dimensions of `y`. At a jump the kind of motion differs
    between the two ends, and the value changes several times more than the slopes beside it would
    explain. These slopes are taken within one kind of motion.
    """
    if y.shape[-1] < 2:
        return np.zeros((*y.shape[:-1], 0), dtype=bool)
    changes, rises = _changes(ds, y.shape), np.abs(np.diff(y))
    slopes = np.where(changes | (steps == 0), np.nan, rises / np.where(steps == 0, 1.0, steps))
    explained = _MARKED * _steepest_beside(slopes) * steps
    largest = np.fmax.reduce(np.abs(y), axis=-1, keepdims=True)
    # A NaN compares as no jump: there already is a gap, or nothing to compare with.
    found: Array = changes & (rises > explained) & (rises > _VISIBLE * largest)
    return found


def break_line(axis: Axis, y: Array, places: Array) -> tuple[Array, Array]:
    """Return the curve with a gap in the middle of each jump."""
    at = np.flatnonzero(places)
    return np.insert(axis.quantity.values, at + 1, axis.middles[at]), np.insert(y, at + 1, np.nan)


def _changes(ds: xr.Dataset, shape: tuple[int, ...]) -> Array:
    changes = np.zeros((*shape[:-1], shape[-1] - 1), dtype=bool)
    for name in _KINDS:
        if name in ds:
            kinds = trusted(ds, name).values
            before, after = kinds[..., :-1], kinds[..., 1:]
            changes |= (after != before) & np.isfinite(after + before)
    return changes


def _steepest_beside(slopes: Array) -> Array:
    """Return the steepest slope in the two intervals on each side; NaN if all of them are NaN."""
    around = [(0, 0)] * (slopes.ndim - 1) + [(2, 2)]
    padded, count = np.pad(slopes, around, constant_values=np.nan), slopes.shape[-1]
    beside = [padded[..., shift : shift + count] for shift in (0, 1, 3, 4)]
    return np.asarray(np.fmax.reduce(beside))


# --- cells, curves or points ----------------------------------------------------------------------


@dataclass(frozen=True)
class Cells:
    """A map: a cell for each point of two axes."""

    across: Axis
    up: Axis
    colours: Colours
    values: Array

    def image(self) -> Array:
        """Return the values (up, across) on pixels of equal size on the scales of the axes."""
        rows, columns = (cells_of_pixels(axis) for axis in (self.up, self.across))
        values = np.ma.filled(self.values.astype(np.float32), np.nan)
        return np.asarray(values[np.ix_(rows, columns)])


@dataclass(frozen=True)
class Curves:
    """Curves over one axis; `ends` are the ends of the vertical axis."""

    across: Axis
    label: str
    curves: tuple[Curve, ...]
    ends: tuple[float, float]
    log: bool


@dataclass(frozen=True)
class Cloud:
    """Linked cases in no order: points over two parameters, or over one and a variable.

    `ends` are the ends of the axis of a variable. A page keeps them when another slice is drawn.
    """

    names: tuple[str, str]
    x: Array
    y: Array
    labels: tuple[str, str]
    log: tuple[bool, bool]
    ends: tuple[float, float] | None
    colours: Colours | None
    values: Array


Chart: TypeAlias = Cells | Curves | Cloud


def chart_of(
    result: xr.Dataset, choice: Choice, *, of_values: bool = False, named: bool = True
) -> Chart:
    """Return the chart of one variable of a result.

    Axes without room in the chart are cut at their first point, and the scales are those of the
    whole result. For cases in no order, `of_values` puts the variable itself on the vertical axis,
    over a parameter. The points of short axes may be `named`. Raises ValueError for a choice of
    axes that cannot be drawn.
    """
    (name,) = choice.variables
    part = result.isel(dict.fromkeys(further_axes(result, choice), 0))
    log = bool(choice.scales & {"y", "z"})
    if cases_to_scatter(result, choice):
        return _cloud_of_result(result, part, choice, of_values=of_values)
    layout = _layout(result, choice)
    across = axis_of(part, str(layout.x), named=named)
    if layout.y or is_discrete(result, name):
        if layout.y is None:
            part = part.expand_dims(STRIP)
        up = axis_of(part, layout.y or STRIP, named=named)
        return cells_of(part, across, up, colours_of(result, name, log=log))
    ends = axis_limits(*value_range(result, name, log=log), log=log)
    part = part.isel({across.dim: across.order})
    curves = tuple(
        # A logarithmic scale has no place for values that are not above 0.
        replace(curve, values=np.where(curve.values > 0.0, curve.values, np.nan)) if log else curve
        for curve in curves_of(part, layout, across, name)
    )
    return Curves(across, shown(part[name]).label, curves, ends, log)


def cells_of(part: xr.Dataset, across: Axis, up: Axis, colours: Colours) -> Cells:
    """Return the map of a variable over two axes of a slice."""
    ordered = part.isel({across.dim: across.order, up.dim: up.order})
    return Cells(across, up, colours, colours.placed(ordered.transpose(up.dim, across.dim, ...)))


def cloud_of(
    part: xr.Dataset,
    names: tuple[str, str],
    colours: Colours | None,
    scales: frozenset[str] = frozenset(),
) -> Cloud:
    """Return the points of a slice over two parameters, or over one and a variable.

    A parameter has the scale that fits its values, unless `scales` asks for a logarithmic one.
    Raises ValueError for a logarithmic scale of a parameter that is not above 0.
    """
    up = names[1]
    is_height = up not in PARAMETERS
    x, y = (shown(part[name] if name in PARAMETERS else trusted(part, name)) for name in names)
    for letter, name, shown_values in zip("xy", names, (x, y), strict=True):
        if letter in scales and name in PARAMETERS and shown_values.values.min() <= 0.0:
            raise ValueError(f"a logarithmic scale needs numbers above 0; {name} has others")
    log_up = bool(scales & {"y", "z"}) if is_height else "y" in scales or fits_log(y.values)
    return Cloud(
        names=names,
        x=x.values,
        y=y.values,
        labels=(x.label, y.label),
        log=("x" in scales or fits_log(x.values), log_up),
        ends=None,
        colours=colours,
        values=colours.placed(part) if colours else np.zeros(x.values.size),
    )


def _cloud_of_result(
    result: xr.Dataset, part: xr.Dataset, choice: Choice, *, of_values: bool
) -> Cloud:
    along, (variable,) = parameters_along(result, CASE), choice.variables
    across = choice.x or next(name for name in along if name != choice.y)
    others = (name for name in along if name != across)
    up = variable if of_values else choice.y or next(others, variable)
    if across == up:
        raise ValueError(
            f"{across} is on the horizontal axis already; choose another one for the vertical axis"
        )
    is_height, log = up not in PARAMETERS, bool(choice.scales & {"y", "z"})
    coloured = "regime" if is_height else variable
    colours = None
    if coloured in result:
        colours = colours_of(result, coloured, log=log and not is_height)
    scales = frozenset("z") if log and is_height else frozenset()
    cloud = cloud_of(part, (across, up), colours, scales)
    ends = axis_limits(*value_range(result, variable, log=log), log=log) if is_height else None
    return replace(cloud, ends=ends)


def further_axes(result: xr.Dataset, choice: Choice) -> list[str]:
    """Return the axes of a result that have no room in its chart, which cuts them."""
    if cases_to_scatter(result, choice):
        taken: tuple[str, ...] = (CASE,)
    else:
        layout = _layout(result, choice)
        ways = (DIRECTION,) if layout.both_ways else ()
        taken = tuple(dim for dim in (layout.x, layout.y, layout.hue, *ways) if dim)
    return [str(dim) for dim, size in result.sizes.items() if size > 1 and dim not in taken]


def _layout(result: xr.Dataset, choice: Choice) -> Layout:
    discrete = is_discrete(result, choice.variables[0])
    layout = layout_of(result, choice, discrete=discrete)
    if discrete and layout.x and layout.y is None and result.sizes.get(DIRECTION, 1) > 1:
        return replace(layout, y=DIRECTION)  # a strip of kinds for each direction
    return layout


# --- borders between kinds of motion: the lines in a file of `stickslip boundary` -----------------

_GRAZING = 0  # a `type` of border
BORDER_STYLES = {"grazing": "solid", "fold": "dashed"}


def require_borders(ds: xr.Dataset) -> None:
    """Raise ValueError if a dataset holds no borders over two axes."""
    axes = border_axes(ds)
    named = {"line", "kind_left", "kind_right", "type"} <= set(ds.variables)
    if not axes or not named or "boundary_point" not in ds.dims:
        raise ValueError("this is not a file of borders as written by `stickslip boundary`")
    if len(axes) != 2:
        raise ValueError(f"borders are drawn on maps; these are points along {axes[0]}")


def require_borders_of(ds: xr.Dataset, borders: xr.Dataset) -> None:
    """Raise ValueError unless a result has two axes and `borders` lie over them."""
    require_borders(borders)
    names = border_axes(borders)
    if any(parameters_along(ds, name) != [name] for name in names):
        raise ValueError(
            f"these borders lie over {' and '.join(names)}, which are not both axes of this result"
        )
    if elsewhere := place_elsewhere(ds, borders):
        raise ValueError(elsewhere)
    if further := sorted(str(d) for d, size in ds.sizes.items() if size > 1 and d not in names):
        raise ValueError(
            f"borders belong to one map, and {further[0]} has {ds.sizes[further[0]]} values "
            f"here; choose one, for example with --at {further[0]}={ds[further[0]].values[0]}"
        )


def border_axes(borders: xr.Dataset) -> list[str]:
    """Return the parameters over which borders lie."""
    return [name for name in PARAMETERS if f"{name}_bracket" in borders.variables]


def border_parts(
    borders: xr.Dataset, across: str, up: str
) -> Iterator[tuple[np.ndarray, np.ndarray, str]]:
    """Yield the parts of lines that have a single type, with the name of that type.

    Each part has its positions (n, 2) in shown units and the numbers (n,) of its points in the
    file. A single point is not a line.
    """
    places = np.column_stack([shown(borders[name]).values for name in (across, up)])
    last = np.flatnonzero(np.diff(borders["line"].values)) + 1
    for line in np.split(np.arange(len(places)), last):
        is_grazing = borders["type"].values[line] == _GRAZING
        # A piece that ends where lines meet has the type of its other end.
        pieces = is_grazing[:-1] | is_grazing[1:]
        ends = [0, *(np.flatnonzero(np.diff(pieces)) + 1).tolist(), len(pieces)]
        for start, stop in itertools.pairwise(ends):
            if start < stop:
                points = line[start : stop + 1]
                yield places[points], points, "grazing" if pieces[start] else "fold"


def place_elsewhere(ds: xr.Dataset, borders: xr.Dataset) -> str:
    """Return a sentence on where borders are, if a dataset has other parameters; else nothing."""
    over = border_axes(borders)  # a single point of borders has one value of each, too
    for name in (name for name in PARAMETERS if name not in over):
        if name in ds.variables and name in borders.variables and borders[name].size == 1:
            there = float(borders[name].values.item())
            if not np.isclose(ds[name].values, there, rtol=1e-9, atol=0.0).any():
                return (
                    f"these borders are at {shown(borders[name]).equation}, which this result lacks"
                )
    return ""
