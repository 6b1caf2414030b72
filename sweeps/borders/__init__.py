"""Borders between kinds of motion as lines: the edges of a map, bisected and joined.

Their Dataset has a row for each point of a line, with both its sides.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.datasets import result_attributes
from stickslip.variables import PARAMETERS, RESULTS
from sweeps.borders.computation import PARTS, BoundaryError, Kind, Map, map_of, part_of
from sweeps.borders.crossings import Crossings, Floats, Line, Rims
from sweeps.engine.progress import display_of
from sweeps.files.attributes import global_attributes

__all__ = ["BoundaryError", "Kind", "boundaries"]

# Below this, brackets would be as narrow as floats allow.
_FINEST = 1e-12

POINT = "boundary_point"

SIDES = ("left", "right")

NEAR = 0.2
"""A border is a fold if a multiplier at an end of its last bracket is as close to 1 as this.

Of the five borders over omega at T = 200 K, in brackets of 1e-6 of the axis, the one at 18.108
rad/s has 0.94 and the others at most 0.54; the ends of wide brackets are too far from the border.
The 0.94 is an error of one-sided differences: the eigenvalue tends to -0.920, and the orbit
continues beyond the border to 18.1087 rad/s, while a motion from the start reaches another
orbit. So the type says how close an orbit is to losing stability, not that it ends there. A value
far above 1 is not the multiplier of a stable orbit: the differences behind it reach across the
border.
"""


class Type(IntEnum):
    """The ways in which a motion can end at a border; the values are those of `type`."""

    GRAZING = 0
    FOLD = 1
    MEETING = 2


def boundaries(
    ds: xr.Dataset,
    accuracy: float = 1e-6,
    kind: Kind = "regime",
    *,
    workers: int | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Return the borders of a map as lines; see `StickslipAccessor.boundaries`.

    `progress` shows how far the computation is.
    """
    if kind not in PARTS:
        raise BoundaryError(f"kind must be {' or '.join(PARTS)}, not {kind!r}")
    if not _FINEST <= accuracy < 1:
        raise BoundaryError(
            f"accuracy must be a fraction of the axis, at least {_FINEST:g} and less than 1, "
            f"not {accuracy}"
        )
    kind_map = map_of(ds, kind, workers)
    with display_of(kind_map.progress, wanted=progress):
        found = kind_map.crossings(accuracy)
        lines, meetings = _joined(kind_map, found)
    return _table(ds, kind_map, found, lines, meetings, accuracy)


def _joined(kind_map: Map, found: Crossings) -> tuple[list[Line], list[list[int]]]:
    """Return the lines and meeting points of crossings; on one axis each crossing is a line."""
    rims = Rims(kind_map.kinds, found, found.places(kind_map.axes))
    centres: list[int] = []
    if doubtful := rims.doubtful():
        cells = zip(kind_map.axes, np.transpose(doubtful), strict=True)
        middles = [axis.middles(axis.values[i], axis.values[i + 1]) for axis, i in cells]
        centres = kind_map.kinds_at(np.column_stack(middles)).tolist()
    return rims.lines(dict(zip(doubtful, centres, strict=True)))


def _table(
    ds: xr.Dataset,
    kind_map: Map,
    found: Crossings,
    lines: list[Line],
    meetings: list[list[int]],
    accuracy: float,
) -> xr.Dataset:
    """Return the borders of a map along `boundary_point`.

    `found` are its crossings, whose brackets stayed wide or have at most the width `accuracy`;
    `lines` join them, and `meetings` lists the crossings of each meeting point.
    """
    points = np.array([point for line in lines for point in line.points], dtype=np.int64)
    numbers = [number for number, line in enumerate(lines) for _ in line.points]
    sides = np.array([line.kinds for line in lines for _ in line.points], dtype=np.int64)
    sides, is_crossing = sides.reshape(-1, 2), points < len(found)
    places = found.places(kind_map.axes)
    middles = [places[meeting].mean(axis=0) for meeting in meetings]
    places = np.vstack([places, *middles])[points]
    brackets = _per_point(found.high - found.low, points)
    coordinates = {"line": (POINT, np.array(numbers, dtype=np.int32), _LINE)} | {
        name: (POINT, place, dict(PARAMETERS[name].attributes))
        for name, place in zip(kind_map.names, places.T, strict=True)
    }
    multipliers = _per_point(found.numbers, points)
    turned = _per_point(found.kinds.astype(float), points)[:, 0] != sides[:, 0]
    multipliers[turned] = multipliers[turned, ::-1]
    data = _kinds(kind_map, sides)
    attributes = result_attributes("floquet_multiplier")
    for side, values in zip(SIDES, multipliers.T, strict=True):
        data[f"multiplier_{side}"] = (POINT, values, _on_side(attributes, side))
    data["type"] = (POINT, types_of(multipliers, is_crossing), _TYPE)
    data |= {
        f"{name}_bracket": (POINT, width, _bracket(name))
        for name, width in zip(kind_map.names, brackets.T, strict=True)
    }
    fixed = {name: ds[name].squeeze() for name in PARAMETERS if name in ds and ds[name].size == 1}
    wide = {"wide_brackets": str(int((~found.are_narrow(kind_map.axes, accuracy)).sum()))}
    return xr.Dataset(data, coordinates | fixed, _about(ds, kind_map) | wide)


def _per_point(values: Floats, points: NDArray[np.int64]) -> Floats:
    """Return values (n, k) of crossings at the points of lines, NaN at meeting points."""
    padded = np.vstack([values, np.full(values.shape[1:], np.nan)])
    return padded[np.minimum(points, len(values))]


def types_of(multipliers: Floats, is_crossing: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Return the types (n,) of points from the multipliers (n, 2) on their two sides."""
    fold = (np.abs(multipliers - 1.0) <= NEAR).any(axis=1)
    codes = np.where(fold, Type.FOLD, Type.GRAZING)
    return np.where(is_crossing, codes, Type.MEETING).astype(np.int8)


def _kinds(kind_map: Map, sides: NDArray[np.int64]) -> dict[str, Any]:
    """Return the parts of the kinds (n, 2) on either side, each as a result variable."""
    data: dict[str, Any] = {}
    for part in PARTS[kind_map.kind]:
        for side, numbers in zip(SIDES, sides.T, strict=True):
            values = part_of(numbers, part).astype(RESULTS[part].dtype)
            name = f"{'kind' if part == 'regime' else part}_{side}"
            data[name] = (POINT, values, _on_side(result_attributes(part), side))
    return data


def _on_side(attributes: dict[str, object], side: str) -> dict[str, object]:
    """Return the attributes of a result variable at one end of the bracket."""
    name = f"{attributes['long_name']}, on the {side}"
    return attributes | {"long_name": name}


def _bracket(name: str) -> dict[str, str]:
    return {
        "long_name": f"width of the last bracket along {name}",
        "units": PARAMETERS[name].units,
        "comment": "0 where the point lies exactly on a grid line; wider than requested if a point "
        "on the way had no result, or took too long in a bracket below a thousandth of the axis",
    }


_LINE = {
    "long_name": "number of the line",
    "units": "1",
    "comment": "points follow each other along a line, with the first axis pointing right and the "
    "second up; for a line with a single point, left is toward smaller values",
}

_TYPE: dict[str, object] = {
    "long_name": "how motions end at the border",
    "units": "1",
    "comment": f"fold: a multiplier within {NEAR} of 1 on at least one side; grazing: none; "
    "meeting: the mean position of crossings where three or more kinds meet, not itself computed",
    "flag_values": np.array([int(code) for code in Type], dtype=np.int8),
    "flag_meanings": " ".join(code.name.lower() for code in Type),
}


def _about(ds: xr.Dataset, kind_map: Map) -> dict[str, object]:
    """Return the global attributes: provenance of this computation, and the config of the map."""
    of_map = {name: ds.attrs[name] for name in ("config", "config_sha256") if name in ds.attrs}
    title = ds.attrs.get("title", "a sweep")
    return {
        **global_attributes(kind_map.config),
        **of_map,
        "title": f"Borders between kinds of motion: {title}",
        "summary": "Where the kind of motion of a block on a boundary lubricant film changes",
        "boundary_kind": kind_map.kind,
        "computed_points": str(kind_map.progress.done),
    }
