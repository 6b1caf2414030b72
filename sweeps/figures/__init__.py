"""Pictures of result and trajectory files: they draw what a Dataset holds and compute nothing.

`draw` chooses the picture, `save` writes it. The units of an axis come from the registry through
the scale table of `labels`: the one place that converts Pa to MPa or m to µm.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable

import xarray as xr
from matplotlib.figure import Figure

from sweeps.figures.amplitudes import amplitudes, is_sweep
from sweeps.figures.save import save
from sweeps.figures.segments import is_trajectory
from sweeps.figures.trajectories import (
    phase_portraits,
    relative_motion,
    time_courses,
)

__all__ = ["FIGURES", "default_figure", "draw", "save"]

FIGURES: dict[str, Callable[[xr.Dataset], Figure]] = {
    "amplitudes": amplitudes,
    "time_courses": time_courses,
    "relative_motion": relative_motion,
    "phase_portraits": phase_portraits,
}


def draw(ds: xr.Dataset, figure: str | None = None) -> Figure:
    """The picture of a dataset, drawn; `save` writes it.

    Parameters
    ----------
    ds
        A sweep result, or a trajectory along `time` or along (axis, sample) with a 2-D `time`.
    figure
        A key of `FIGURES`; left out, `time_courses` for a trajectory and `amplitudes` for a sweep:
        curves along one long axis, maps over two, facets beyond, a table for a single point.

    Raises
    ------
    ValueError
        For an unknown name, and for a figure that the dataset has no data for.
    """
    name = default_figure(ds) if figure is None else figure
    if name not in FIGURES:
        raise ValueError(_unknown(name))
    _require_data(ds, name)
    picture = FIGURES[name](ds)
    picture.set_label(str(ds.attrs.get("title", "")))
    return picture


def default_figure(ds: xr.Dataset) -> str:
    """The name of the figure that fits the dataset best."""
    return "time_courses" if is_trajectory(ds) else "amplitudes"


def _require_data(ds: xr.Dataset, name: str) -> None:
    if name == "amplitudes" and not is_sweep(ds):
        raise ValueError("the figure 'amplitudes' needs a sweep result: no amplitudes here")
    if name != "amplitudes" and not is_trajectory(ds):
        raise ValueError(f"the figure '{name}' needs a trajectory: no displacements in time here")


def _unknown(name: str) -> str:
    close = difflib.get_close_matches(name, FIGURES, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else f"; there are {', '.join(FIGURES)}"
    return f"unknown figure '{name}'{hint}"
