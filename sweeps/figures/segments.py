"""The trajectories in a dataset: one along `time`, or several along (axis, sample)."""

from __future__ import annotations

import itertools

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS
from sweeps.figures.layout import Selection, point_label, selections


def is_trajectory(ds: xr.Dataset) -> bool:
    """Whether the dataset holds motion in time."""
    return "time" in ds.variables and ds["time"].ndim > 0


def runs(ds: xr.Dataset, most: int) -> tuple[list[Selection], str]:
    """The trajectories, at most `most`, and a note where that leaves some out."""
    along = ds["time"].dims[-1]
    dims = tuple(str(dim) for dim in ds["lower_displacement"].dims if dim != along)
    return selections(ds, dims, most)


def columns(ds: xr.Dataset, most: int) -> tuple[list[list[Selection]], str]:
    """The trajectories, at most `most`, each as its sections; and a note of those left out."""
    kept, note = runs(ds, most)
    return [_sections(run) for run in kept], note


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
