"""The kinds of Datasets, and the figures that each can be drawn as."""

from __future__ import annotations

import xarray as xr

from sweeps.figure_table import FIGURES, Data
from sweeps.human import did_you_mean


def data_of(ds: xr.Dataset) -> Data:
    """Return the kind of a dataset: a trajectory, phases, a fit, or otherwise a sweep."""
    if "fitted_value" in ds.variables:
        return "fit"
    if "free_energy" in ds.variables or "melting_temperature" in ds.variables:
        return "phases"
    return "trajectory" if "elapsed_time" in ds.variables else "sweep"


def default_figure(ds: xr.Dataset) -> str:
    """The name of the figure that fits the dataset best."""
    data = data_of(ds)
    return next(name for name, entry in FIGURES.items() if entry.data == data)


def obstacle(ds: xr.Dataset, name: str) -> str:
    """Why a figure cannot be drawn of a dataset, as a sentence; empty where it can."""
    if name not in FIGURES:
        hint = did_you_mean(name, FIGURES) or f"; there are {', '.join(FIGURES)}"
        return f"unknown figure '{name}'{hint}"
    entry, data = FIGURES[name], data_of(ds)
    if "boundary_point" in ds.dims:
        return (
            "borders are drawn over their map: give the file of the map, and --boundaries this one"
        )
    lacking = [needed for needed in entry.variables if needed not in ds.variables]
    if entry.data != data:
        return f"the figure '{name}' draws {entry.drawn}, and this file holds none"
    if lacking:
        return f"the figure '{name}' needs {', '.join(lacking)}, which this file lacks"
    return ""
