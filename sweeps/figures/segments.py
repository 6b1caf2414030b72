"""The trajectories in a dataset: one along `time`, or several along (axis, sample)."""

from __future__ import annotations

import itertools
import math

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS
from sweeps.figures.layout import Selection, point_label, selections

NEEDED = ("time", "upper_displacement", "lower_displacement", "upper_velocity", "lower_velocity")


def is_trajectory(ds: xr.Dataset) -> bool:
    """Whether the dataset holds motion in time."""
    return all(name in ds.variables for name in NEEDED) and ds["time"].ndim > 0


def runs(ds: xr.Dataset, most: int) -> tuple[list[Selection], str]:
    """The trajectories, at most `most`, and a note where that leaves some out."""
    along = ds["time"].dims[-1]
    dims = tuple(str(dim) for dim in ds["lower_displacement"].dims if dim != along)
    return selections(ds, dims, most)


def columns(ds: xr.Dataset, most: int) -> tuple[list[list[Selection]], str]:
    """The trajectories by column: those that continue one another in time share one."""
    everything, _ = runs(ds, most=_count(ds))
    if _continue(everything):
        return [everything], ""
    kept, note = runs(ds, most)
    return [_sections(run) for run in kept], note


def _count(ds: xr.Dataset) -> int:
    return math.prod(ds["lower_displacement"].shape) // ds["time"].sizes[ds["time"].dims[-1]]


def _continue(sections: list[Selection]) -> bool:
    """Whether each trajectory starts where the one before ends, or one of its steps later."""
    times = [section.dataset["time"].values for section in sections]
    times = [time[np.isfinite(time)] for time in times]
    pairs = itertools.pairwise(times)
    return len(times) > 1 and all(0 <= b[0] - a[-1] < 1.5 * (a[-1] - a[-2]) for a, b in pairs)


def _sections(run: Selection) -> list[Selection]:
    """The stretches of one trajectory along which its parameters do not change (Fig. 6)."""
    ds = run.dataset
    along = str(ds["time"].dims[0])
    stepped = [name for name in ds.coords if name in PARAMETERS and ds[name].dims == (along,)]
    if not stepped:
        return [run]
    changes = [np.flatnonzero(np.diff(ds[name].values)) + 1 for name in stepped]
    borders = [0, *np.unique(np.concatenate(changes)).tolist(), ds.sizes[along]]
    pairs = itertools.pairwise(borders)
    return [
        Selection(point_label(ds, along, start), ds.isel({along: slice(start, stop)}))
        for start, stop in pairs
    ]
