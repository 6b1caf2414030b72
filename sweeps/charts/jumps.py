"""Jumps of a curve, where the kind of motion changes and the value does not continue."""

from __future__ import annotations

import numpy as np
import xarray as xr

from sweeps.charts.axes import Axis
from sweeps.charts.labels import Array
from sweeps.charts.missing import trusted

_KINDS = ("regime", "orbit_periods", "melting_count")  # what tells one kind of motion from another
_MARKED = 4.0  # times the steepest slope beside it: less is a bend
_VISIBLE = 0.02  # of the range of the curve: less is no gap on paper


def jumps(ds: xr.Dataset, steps: Array, y: Array) -> Array:
    """Return True for each interval of curves over which the value jumps, (..., n - 1).

    `steps` (n - 1,) are the distances of the points along x, `y` (..., n) the values as drawn; the
    variables of `ds` have the same dimensions. The kind of motion differs at the two ends, and the
    value goes several times as far as the slopes beside it explain; those are taken within one kind
    of motion.
    """
    if y.shape[-1] < 2:
        return np.zeros((*y.shape[:-1], 0), dtype=bool)
    changes, rises = _changes(ds, y.shape), np.abs(np.diff(y))
    slopes = np.where(changes | (steps == 0), np.nan, rises / np.where(steps == 0, 1.0, steps))
    explained = _MARKED * _steepest_beside(slopes) * steps
    largest = np.fmax.reduce(np.abs(y), axis=-1, keepdims=True)
    # A NaN compares as no jump: there is a gap already, or nothing to compare with.
    found: Array = changes & (rises > explained) & (rises > _VISIBLE * largest)
    return found


def break_line(axis: Axis, y: Array, places: Array) -> tuple[Array, Array]:
    """The curve with a gap in the middle of each jump."""
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
    """Return the steepest of the two intervals on each side; NaN where none of them counts."""
    around = [(0, 0)] * (slopes.ndim - 1) + [(2, 2)]
    padded, count = np.pad(slopes, around, constant_values=np.nan), slopes.shape[-1]
    beside = [padded[..., shift : shift + count] for shift in (0, 1, 3, 4)]
    return np.asarray(np.fmax.reduce(beside))
