"""Pictures of trajectories: time courses (Figs. 3, 6), relative motion (4), phase portraits (5).

Also loops of the friction force, pulls, and an orbit in several views.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from string import ascii_lowercase

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sweeps.charts.axes import MOST_FACETS, Selection
from sweeps.charts.colours import SKY, VERMILLION
from sweeps.charts.courses import (
    ALONE,
    LOWER,
    PULL,
    RELATIVE_MOTION,
    TIME_COURSES,
    UPPER,
    Trace,
    label_of,
    row_of,
    runs,
    sections,
)
from sweeps.charts.labels import Array, shown
from sweeps.figures.style import (
    COLUMN,
    PAGE,
    SMALL,
    TEXT,
    line_of,
    new_figure,
    new_panels,
    put_legend,
    put_note,
    width_of,
)
from sweeps.human import counted

_MOST_PORTRAITS = 9
_PULL_HEIGHT = 4.4  # inches
_MOST_SLIPS, _LAST_SLIPS = 40, 8  # the most that lines show in a column; those shown beside more
_BANDS = 300  # spans of time, about as many as the dots of a print


def time_courses(ds: xr.Dataset) -> Figure:
    """Displacements, velocities, elastic stress and friction force against time (Figs. 3, 6)."""
    figure = _stack(ds, TIME_COURSES, height=5.2)
    put_legend(figure, _both_blocks())
    return figure


def draw_variables(ds: xr.Dataset, names: Sequence[str]) -> Figure:
    """Draw the panels of the time courses that show these variables, given by name or symbol.

    A variable outside the time courses gets its own panel. Raises ValueError for an unknown one.
    """
    rows = tuple(dict.fromkeys(row_of(ds, name) for name in names))
    figure = _stack(ds, rows, height=1.6 + 0.9 * len(rows))
    if any(len(row) > 1 for row in rows):
        put_legend(figure, _both_blocks(), above=True)
    return figure


def _both_blocks() -> list[Line2D]:
    """Return the lines of both blocks for the legend of their time courses."""
    return [
        Line2D([], [], **line_of(UPPER), label="upper block $X$, $V$"),
        Line2D([], [], **line_of(LOWER), label="lower block $x$, $v$"),
    ]


def relative_motion(ds: xr.Dataset) -> Figure:
    """Relative displacement and relative velocity of the blocks against time (Fig. 4)."""
    return _stack(ds, RELATIVE_MOTION, height=3.4)


def pull(ds: xr.Dataset) -> Figure:
    """Velocity of the pull, spring and friction forces, and order parameter against time.

    If there are too many slips to draw as lines, bands show the whole run, and panels beside them
    show the last slips as lines.
    """
    slips = ds["melting_time"].values if "melting_time" in ds else np.empty(0)
    time = ds["elapsed_time"].values
    slips = slips[(slips >= time.min()) & (slips <= time.max())]  # of a part of a run
    if slips.size > _MOST_SLIPS and ds["elapsed_time"].ndim == 1:
        figure = _many_slips(ds, slips)
    else:
        figure = _stack(ds, PULL, height=_PULL_HEIGHT)
    lines = [
        Line2D([], [], **line_of(UPPER), label="friction force $F$"),
        Line2D([], [], **line_of(LOWER), label="spring force $2Kx$"),
    ]
    put_legend(figure, lines)
    return figure


def _many_slips(ds: xr.Dataset, slips: Array) -> Figure:
    """Return the panels of a pull: the whole run as bands, and the last slips as lines."""
    last = ds.isel(elapsed_time=ds["elapsed_time"].values >= slips[-1 - _LAST_SLIPS])
    figure, panels = new_panels(
        len(PULL), 2, (width_of(2), _PULL_HEIGHT), sharex="col", sharey="row"
    )
    end = [Selection("", last)]
    for (left, right), traces in zip(panels, PULL, strict=True):
        _draw_bands(left, traces, ds)
        _draw_traces(right, traces, end)
        left.set_ylabel(label_of(ds, traces), fontsize=TEXT)
    panels[0, 0].set_title(f"{slips.size} slips, lowest to highest value", fontsize=TEXT)
    panels[0, 1].set_title(f"the last {_LAST_SLIPS}", fontsize=TEXT)
    for axes in panels[-1]:
        _name_time(axes, last)
    figure.align_ylabels()
    return figure


def _draw_bands(axes: Axes, traces: tuple[Trace, ...], ds: xr.Dataset) -> None:
    """Draw the lowest and the highest value of each trace in short spans of time."""
    time = shown(ds["elapsed_time"]).values
    firsts = np.unique(np.linspace(0, time.size, _BANDS, endpoint=False).astype(int))
    places = np.append(firsts, time.size - 1)
    for trace in traces:
        values = trace.quantity(ds).values
        low, high = np.minimum.reduceat(values, firsts), np.maximum.reduceat(values, firsts)
        low, high = np.append(low, low[-1]), np.append(high, high[-1])  # up to the end
        colour = trace.style.colour
        axes.fill_between(time[places], low, high, color=colour, alpha=0.4, linewidth=0.8)
    axes.margins(x=0.0)


def _stack(ds: xr.Dataset, rows: tuple[tuple[Trace, ...], ...], height: float) -> Figure:
    found, note = runs(ds, MOST_FACETS)
    stacks = [sections(run) for run in found]
    size = (width_of(len(stacks)), height)
    figure, panels = new_panels(len(rows), len(stacks), size, sharex="col", sharey="row")
    for axes_of_column, stack in zip(panels.T, stacks, strict=True):
        for axes, traces in zip(axes_of_column, rows, strict=True):
            _draw_traces(axes, traces, stack)
        _name_sections(axes_of_column[0], stack)
        _name_time(axes_of_column[-1], stack[0].dataset)
    for axes, traces in zip(panels[:, 0], rows, strict=True):
        axes.set_ylabel(label_of(stacks[0][0].dataset, traces), fontsize=TEXT)
    figure.align_ylabels()
    put_note(figure, [note])
    return figure


def _name_time(axes: Axes, ds: xr.Dataset) -> None:
    axes.set_xlabel(shown(ds["elapsed_time"]).label, fontsize=TEXT)


def _draw_traces(axes: Axes, traces: tuple[Trace, ...], stack: list[Selection]) -> None:
    for section in stack:
        time = shown(section.dataset["elapsed_time"]).values
        for trace in traces:
            axes.plot(time, trace.quantity(section.dataset).values, **line_of(trace.style))
    for section in stack[1:]:
        border = float(np.nanmin(section.dataset["elapsed_time"].values))
        axes.axvline(border, color="0.5", linewidth=0.6, gid="border")
    axes.margins(x=0.0)


def _name_sections(axes: Axes, stack: list[Selection]) -> None:
    if len(stack) == 1:
        axes.set_title(stack[0].label, fontsize=TEXT)
        return
    for section in stack:
        time = section.dataset["elapsed_time"].values
        middle = (np.nanmin(time) + np.nanmax(time)) / 2
        axes.annotate(
            section.label,
            (middle, 1.0),
            xytext=(0, 2),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            fontsize=SMALL,
        )


def phase_portraits(ds: xr.Dataset) -> Figure:
    """Velocity of the lower block against its displacement, a panel per trajectory (Fig. 5)."""
    return _portraits(ds, "lower_displacement", "lower_velocity")


def force_loops(ds: xr.Dataset) -> Figure:
    """Friction force against the displacement of the upper block, a panel per trajectory.

    The area of a closed loop is the work of the drive.
    """
    return _portraits(ds, "upper_displacement", "friction_force")


def _portraits(ds: xr.Dataset, across: str, upward: str) -> Figure:
    portraits, note = runs(ds, _MOST_PORTRAITS)
    count = len(portraits)
    columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)
    size = (COLUMN, 2.9) if count == 1 else (width_of(columns), 2.4 * rows)
    figure, grid = new_panels(rows, columns, size)
    for unused in grid.flat[count:]:
        unused.remove()
    panels = list(grid.flat[:count])
    for index, (axes, portrait) in enumerate(zip(panels, portraits, strict=True)):
        x, y = shown(portrait.dataset[across]), shown(portrait.dataset[upward])
        axes.axhline(0.0, color="0.8", linewidth=0.5, gid="origin")
        axes.axvline(0.0, color="0.8", linewidth=0.5, gid="origin")
        axes.plot(x.values, y.values, **line_of(ALONE))
        _put_inset(axes, x.values, y.values)
        axes.set_xlabel(x.label, fontsize=TEXT)
        axes.set_ylabel(y.label, fontsize=TEXT)
        if count > 1:
            name = f"({ascii_lowercase[index]}) {portrait.label}"
            axes.set_title(name, fontsize=TEXT, loc="left")
    put_note(figure, [note])
    return figure


# --- insets: an enlarged section with loops too small to see --------------------------------------

# As parts of the extent of a portrait: the distance below which features are lost in the width of
# the line; the size below which loops are hard to see; the side of an inset.
_STEP, _SMALL_LOOP, _SIDE = 0.002, 0.03, 0.3

_PLACES = np.linspace(0.04, 0.96 - _SIDE, 40)
_MARGIN = 0.03  # between an inset and the nearest curve


def _put_inset(axes: Axes, x: Array, y: Array) -> None:
    """Enlarge the section of a curve with its smallest loops, in an empty place of its panel.

    Nothing is drawn if no loop is too small to see, or if the curve leaves no room.
    """
    section = _hidden_loops(*_normalised(x, y))
    place = _empty_place(axes, x, y) if section is not None else None
    if section is None or place is None:
        return
    inset = axes.inset_axes((*place, _SIDE, _SIDE))
    inset.plot(x, y, **line_of(ALONE))
    inset.set_xlim(x.min() + np.ptp(x) * section[0])
    inset.set_ylim(y.min() + np.ptp(y) * section[1])
    inset.tick_params(labelsize=SMALL, direction="in", length=2.0)
    inset.ticklabel_format(useOffset=False)
    inset.locator_params(nbins=2)
    inset.set_title("A", fontsize=SMALL, pad=2.0)
    axes.indicate_inset_zoom(inset, edgecolor="0.4")


def _normalised(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a curve scaled to a unit square, thinned to steps that can be seen."""
    points = np.column_stack([(v - v.min()) / (np.ptp(v) or 1.0) for v in (x, y)])
    kept = [0]
    for number, point in enumerate(points):
        if math.dist(point, points[kept[-1]]) >= _STEP:
            kept.append(number)
    return points[kept, 0], points[kept, 1]


def _hidden_loops(x: Array, y: Array) -> Array | None:
    """Return the section ((x, x), (y, y)) with the most turns in a small space; None without loops.

    A full turn within `_SMALL_LOOP` of its beginning is a loop.
    """
    directions = np.unwrap(np.arctan2(np.diff(y), np.diff(x)))
    turned = np.append(0.0, np.cumsum(np.abs(np.diff(directions))))
    most, section = 2.0 * math.pi, None
    for first in range(len(turned)):
        away = np.hypot(x[first:-1] - x[first], y[first:-1] - y[first]) > _SMALL_LOOP
        stretch = int(np.argmax(away)) if away.any() else len(away)
        if stretch < 2:
            continue
        last = first + stretch - 1
        if turned[last] - turned[first] > most:
            most = turned[last] - turned[first]
            ends = np.array(
                [(v.min(), v.max()) for v in (x[first : last + 1], y[first : last + 1])]
            )
            section = ends + 0.3 * np.diff(ends) * [-1.0, 1.0]  # with a margin on both sides
    return section


def _empty_place(axes: Axes, x: Array, y: Array) -> tuple[float, float] | None:
    """Return the lower left corner, in parts of the panel, of the place farthest from the curve."""
    limits = (axes.get_xlim(), axes.get_ylim())  # reading the limits also fixes them
    points = np.column_stack(
        [(v - low) / (high - low) for v, (low, high) in zip((x, y), limits, strict=True)]
    )
    best, found = _MARGIN, None
    for left in _PLACES:
        for bottom in _PLACES:
            beyond = np.abs(points - [left + _SIDE / 2, bottom + _SIDE / 2]) - _SIDE / 2
            distance = float(beyond.max(axis=1).min())
            if distance > best:
                best, found = distance, (float(left), float(bottom))
    return found


# --- an orbit in several views --------------------------------------------------------------------

_ORBIT_HEIGHT = 5.2  # inches

_LAST = 32  # periods of the stroboscopic map that are highlighted, because they lie on the orbit
# A closed orbit has a few states there, each within this part of the extent of the map.
_FEW_STATES, _NEAR = 8, 1e-3
_LEAST = 16  # the fewest periods of the approach that are shown


def orbit(ds: xr.Dataset) -> Figure:
    """Time courses on the left; phase portrait and, if the file has it, stroboscopic map.

    Raises ValueError for several trajectories.
    """
    if len(runs(ds, 2)[0]) > 1:
        raise ValueError(
            "the figure 'orbit' draws one trajectory, but there are several: select one, as with "
            "isel(), or draw their phase_portraits"
        )
    figure = new_figure((PAGE, _ORBIT_HEIGHT), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.15, 1.0))  # type: ignore[misc]
    courses = left.subplots(len(TIME_COURSES), 1, sharex=True)
    for axes, traces in zip(courses, TIME_COURSES, strict=True):
        _draw_traces(axes, traces, [Selection("", ds)])
        axes.set_ylabel(label_of(ds, traces), fontsize=TEXT)
    _name_time(courses[-1], ds)
    left.legend(handles=_both_blocks(), loc="outside upper center", ncols=2)
    left.align_ylabels()
    with_map = "stroboscopic_displacement" in ds.variables
    panels = right.subplots(2 if with_map else 1, 1, squeeze=False).ravel()
    x, v = shown(ds["lower_displacement"]), shown(ds["lower_velocity"])
    panels[0].plot(x.values, v.values, **line_of(ALONE))
    panels[0].plot(x.values[0], v.values[0], "o", color=VERMILLION, markersize=3.0, gid="start")
    panels[0].set_xlabel(x.label, fontsize=TEXT)
    panels[0].set_ylabel(v.label, fontsize=TEXT)
    panels[0].set_title("phase portrait; dot: phase 0 of the drive", fontsize=SMALL)
    if with_map:
        _draw_map(panels[1], ds)
    return figure


def _draw_map(axes: Axes, ds: xr.Dataset) -> None:
    """Draw the states at the beginnings of drive periods.

    A closed orbit ends in a few points, so its approach is drawn against time instead.
    """
    x, v = shown(ds["stroboscopic_displacement"]), shown(ds["stroboscopic_velocity"])
    settled = _settled(x.values, v.values)
    if settled is None:
        axes.plot(x.values, v.values, color=SKY, linewidth=0.0, marker=".", markersize=2.5)
        last = slice(-min(_LAST, x.values.size), None)
        axes.plot(x.values[last], v.values[last], "o", color=VERMILLION, markersize=3.0, gid="last")
        axes.set_xlabel(x.label, fontsize=TEXT)
        axes.set_ylabel(v.label, fontsize=TEXT)
        periods = int(np.max(ds["period"].values))
        title = f"stroboscopic map of {periods} periods; dots: the last {_LAST}"
    else:
        shown_periods = slice(max(2 * settled, _LEAST))
        number = ds["period"].values[shown_periods]
        axes.plot(number, x.values[shown_periods], ".", color=VERMILLION, markersize=4.0)
        axes.set_xlabel("drive periods from the start", fontsize=TEXT)
        axes.set_ylabel(x.label, fontsize=TEXT)
        title = f"stroboscopic displacement; on the orbit after {counted(settled, 'period')}"
    axes.set_title(title, fontsize=SMALL)


def _settled(x: Array, v: Array) -> int | None:
    """Return the period after which all states are among the last few; None for an open orbit."""
    extent = max(np.ptp(x), 1e-300), max(np.ptp(v), 1e-300)
    last = slice(-min(_LAST, x.size), None)
    states = np.column_stack([x / extent[0], v / extent[1]])
    ends = np.unique((states[last] / _NEAR).round(), axis=0) * _NEAR
    if len(ends) > _FEW_STATES:
        return None
    distance = np.abs(states[:, None] - ends[None]).max(axis=2).min(axis=1)
    away = np.flatnonzero(distance > 2 * _NEAR)
    return int(away[-1]) + 1 if away.size else 0
