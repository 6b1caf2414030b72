"""Borders between kinds of motion as lines: the edges of a map, bisected and joined."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sweeps.borders.bisection import NO_KIND, Crossings, Floats
from sweeps.borders.computation import BoundaryError, Map, map_of
from sweeps.borders.joining import Line, Rims
from sweeps.borders.kinds import PARTS, Kind
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
    kinds, corners, places = own.kinds, found.corner, found.places(own.axes)
    if kinds.ndim == 1:
        kinds, corners = kinds[:, None], np.pad(corners, [(0, 0), (0, 1)])
    order = np.take_along_axis(places, found.axis[:, None], axis=1)[:, 0]
    rims = Rims(kinds, found.axis, corners, found.kinds, order, NO_KIND)
    doubtful = rims.doubtful()
    centres = own.kinds_at(_centres(own, np.array(doubtful))).tolist() if doubtful else []
    return rims.lines(dict(zip(doubtful, centres, strict=True)))


def _centres(own: Map, cells: NDArray[np.int64]) -> Floats:
    """Return the centres (n, axes) of cells (n, axes)."""
    columns = zip(own.axes, cells.T, strict=True)
    return np.column_stack([a.middles(a.values[i], a.values[i + 1]) for a, i in columns])
