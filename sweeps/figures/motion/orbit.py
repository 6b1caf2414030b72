"""One orbit from all sides: courses in time, phase portrait, stroboscopic map."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sweeps.figures.labels import shown
from sweeps.figures.motion.traces import ALONE, TIME_COURSES, both_blocks, draw_courses
from sweeps.figures.style import PAGE, SKY, SMALL, TEXT, VERMILLION, new_figure

_HEIGHT = 5.2  # inches

# Of the stroboscopic map the last periods, those on the orbit, stand out.
_LAST = 32


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
    axes.plot(x.values, v.values, **ALONE.line())
    axes.plot(x.values[0], v.values[0], "o", color=VERMILLION, markersize=3.0, gid="start")
    axes.set_xlabel(x.label, fontsize=TEXT)
    axes.set_ylabel(v.label, fontsize=TEXT)
    axes.set_title("phase portrait; dot: phase 0 of the drive", fontsize=SMALL)


def _draw_map(axes: Axes, ds: xr.Dataset) -> None:
    """The states at the beginnings of drive periods, one by one from the start."""
    x, v = shown(ds["stroboscopic_displacement"]), shown(ds["stroboscopic_velocity"])
    axes.plot(x.values, v.values, color=SKY, linewidth=0.5, marker=".", markersize=2.5)
    last = slice(-min(_LAST, x.values.size), None)
    axes.plot(x.values[last], v.values[last], "o", color=VERMILLION, markersize=3.0, gid="last")
    axes.set_xlabel(x.label, fontsize=TEXT)
    axes.set_ylabel(v.label, fontsize=TEXT)
    periods = int(np.max(ds["period"].values))
    title = f"stroboscopic map of {periods} periods; dots: the last {_LAST}"
    axes.set_title(title, fontsize=SMALL)
