"""One orbit from all sides: courses in time, phase portrait, stroboscopic map."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sweeps.charts.courses import ALONE, TIME_COURSES
from sweeps.charts.labels import Array, shown
from sweeps.charts.styles import SKY, VERMILLION
from sweeps.figures.motion.traces import both_blocks, draw_courses
from sweeps.figures.style import PAGE, SMALL, TEXT, line_of, new_figure
from sweeps.human import counted

_HEIGHT = 5.2  # inches

# Of the stroboscopic map the last periods, those on the orbit, stand out.
_LAST = 32
# Of an orbit that closes these are a few, within a part of all that the map covers.
_FEW, _NEAR = 8, 1e-3
_LEAST = 16  # periods that are shown of the way to it


def orbit(ds: xr.Dataset) -> Figure:
    """Time courses on the left; phase portrait and, where there is one, stroboscopic map."""
    figure = new_figure((PAGE, _HEIGHT), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.15, 1.0))  # type: ignore[misc]
    courses = left.subplots(len(TIME_COURSES), 1, sharex=True)
    draw_courses(list(courses), TIME_COURSES, ds)
    left.legend(handles=both_blocks(), loc="outside upper center", ncols=2)
    left.align_ylabels()
    with_map = "stroboscopic_displacement" in ds.variables
    panels = right.subplots(2 if with_map else 1, 1, squeeze=False).ravel()
    _draw_portrait(panels[0], ds)
    if with_map:
        _draw_map(panels[1], ds)
    return figure


def _draw_portrait(axes: Axes, ds: xr.Dataset) -> None:
    x, v = shown(ds["lower_displacement"]), shown(ds["lower_velocity"])
    axes.plot(x.values, v.values, **line_of(ALONE))
    axes.plot(x.values[0], v.values[0], "o", color=VERMILLION, markersize=3.0, gid="start")
    axes.set_xlabel(x.label, fontsize=TEXT)
    axes.set_ylabel(v.label, fontsize=TEXT)
    axes.set_title("phase portrait; dot: phase 0 of the drive", fontsize=SMALL)


def _draw_map(axes: Axes, ds: xr.Dataset) -> None:
    """The states at the beginnings of drive periods, one by one from the start.

    Of an orbit that closes they are a few points in the end: then the way there, against time.
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
    """Return the period from which on all states are among the last few; None: there is none."""
    extent = max(np.ptp(x), 1e-300), max(np.ptp(v), 1e-300)
    last = slice(-min(_LAST, x.size), None)
    states = np.column_stack([x / extent[0], v / extent[1]])
    ends = np.unique((states[last] / _NEAR).round(), axis=0) * _NEAR
    if len(ends) > _FEW:
        return None
    distance = np.abs(states[:, None] - ends[None]).max(axis=2).min(axis=1)
    away = np.flatnonzero(distance > 2 * _NEAR)
    return int(away[-1]) + 1 if away.size else 0
