"""Time courses of a motion: the curves that share a panel, and the sections of a run."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
import xarray as xr

from stickslip.variables import PARAMETERS, PULLED, TRAJECTORY
from sweeps.charts.axes import Selection, selections
from sweeps.charts.colours import BLACK, SKY, CurveStyle
from sweeps.charts.labels import Quantity, shown, slice_label
from sweeps.human import did_you_mean

# Dashes over a wide light line: both curves show while the blocks move together.
LOWER = CurveStyle(SKY, 1.6)
UPPER = CurveStyle(BLACK, 0.8, (0, (4.0, 2.0)))
ALONE = CurveStyle(BLACK, 0.9)


class Trace(NamedTuple):
    """A curve over time: a variable, or its difference from another one."""

    name: str
    minus: str | None = None
    style: CurveStyle = ALONE

    def quantity(self, ds: xr.Dataset) -> Quantity:
        """Return the values of the curve in the unit in which they are shown."""
        first = shown(ds[self.name])
        if self.minus is None:
            return first
        second = shown(ds[self.minus])
        symbol = f"${first.symbol.strip('$')} - {second.symbol.strip('$')}$"
        return Quantity(first.values - second.values, symbol, first.units)


TIME_COURSES = (
    (Trace("lower_displacement", style=LOWER), Trace("upper_displacement", style=UPPER)),
    (Trace("lower_velocity", style=LOWER), Trace("upper_velocity", style=UPPER)),
    (Trace("elastic_stress"),),
    (Trace("friction_force"),),
)
PULL = (
    (Trace("upper_velocity"),),
    (Trace("spring_force", style=LOWER), Trace("friction_force", style=UPPER)),
    (Trace("order_parameter"),),
)
RELATIVE_MOTION = (
    (Trace("upper_displacement", minus="lower_displacement"),),
    (Trace("upper_velocity", minus="lower_velocity"),),
)


def row_of(ds: xr.Dataset, name: str) -> tuple[Trace, ...]:
    """Return the curves of the panel that shows a variable, given by name or symbol.

    A variable outside the time courses gets its own panel. Raises ValueError for an unknown one.
    """
    along = ds["lower_displacement"].dims
    known = [n for n in (*TRAJECTORY, *PULLED) if n in ds.data_vars and ds[n].dims == along]
    full = next((n for n in known if ds[n].attrs.get("symbol") == name), name)
    if full not in known:
        hint = did_you_mean(name, known) or f"; there are {', '.join(known)}"
        raise ValueError(f"unknown variable '{name}' of a trajectory{hint}")
    standard = (row for row in TIME_COURSES if full in [trace.name for trace in row])
    return next(standard, (Trace(full),))


def label_of(ds: xr.Dataset, traces: tuple[Trace, ...]) -> str:
    """Return all symbols of a panel, capitals first as in the paper, and their common unit."""
    quantities = [trace.quantity(ds) for trace in reversed(traces)]
    symbols = ", ".join(quantity.symbol for quantity in quantities)
    return Quantity(quantities[0].values, symbols, quantities[0].units).label


def runs(ds: xr.Dataset, most: int) -> tuple[list[Selection], str]:
    """Return up to `most` trajectories, and a note if some are left out.

    Raises ValueError for a single instant.
    """
    if not ds["elapsed_time"].ndim:
        raise ValueError(
            "a single instant is not a motion: select several instants of the trajectory"
        )
    along = ds["elapsed_time"].dims[-1]
    dims = tuple(str(dim) for dim in ds["lower_displacement"].dims if dim != along)
    return selections(ds, dims, most)


def sections(run: Selection) -> list[Selection]:
    """Return the sections of a trajectory in which its parameters do not change (Fig. 6).

    Each begins at the instant at which the previous one ends, so that the line does not break.
    """
    ds = run.dataset
    along = str(ds["elapsed_time"].dims[0])
    stepped = [name for name in ds.coords if name in PARAMETERS and ds[name].dims == (along,)]
    if not stepped:
        return [run]
    changes = [np.flatnonzero(np.diff(ds[name].values)) + 1 for name in stepped]
    borders = [0, *np.unique(np.concatenate(changes)).tolist(), ds.sizes[along]]
    return [
        Selection(slice_label(ds, {along: start}), ds.isel({along: slice(max(start - 1, 0), stop)}))
        for start, stop in itertools.pairwise(borders)
    ]
