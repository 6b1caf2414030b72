"""Borders between kinds of motion as lines: the edges of a map, bisected and joined."""

from __future__ import annotations

import numpy as np
import xarray as xr

from sweeps.borders.computation import PARTS, BoundaryError, Kind, Map, map_of
from sweeps.borders.crossings import Crossings, Line, Rims
from sweeps.borders.table import table_of
from sweeps.engine.progress import display_of

__all__ = ["BoundaryError", "Kind", "boundaries"]

# Below it brackets would be as narrow as floats allow.
_FINEST = 1e-12


def boundaries(
    ds: xr.Dataset,
    accuracy: float = 1e-6,
    kind: Kind = "regime",
    *,
    workers: int | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Return the borders of a map as lines; see `StickslipAccessor.boundaries`.

    With `progress` it says how far it is.
    """
    if kind not in PARTS:
        raise BoundaryError(f"kind is {' or '.join(PARTS)}, not {kind!r}")
    if not _FINEST <= accuracy < 1:
        raise BoundaryError(
            f"accuracy is a part of the length of an axis, from {_FINEST:g} to below 1, "
            f"not {accuracy}"
        )
    own = map_of(ds, kind, workers)
    with display_of(own.progress, wanted=progress):
        found = own.crossings(accuracy)
        lines, meetings = _joined(own, found)
    return table_of(ds, own, found, lines, meetings, accuracy)


def _joined(own: Map, found: Crossings) -> tuple[list[Line], list[list[int]]]:
    """Return the lines and meeting points of crossings; those of one axis are points."""
    rims = Rims(own.kinds, found, found.places(own.axes))
    centres: list[int] = []
    if doubtful := rims.doubtful():
        cells = zip(own.axes, np.transpose(doubtful), strict=True)
        middles = [axis.middles(axis.values[i], axis.values[i + 1]) for axis, i in cells]
        centres = own.kinds_at(np.column_stack(middles)).tolist()
    return rims.lines(dict(zip(doubtful, centres, strict=True)))
