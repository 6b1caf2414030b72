"""The motion at many points of a result, computed again in threads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip import IntegrationError, NoiseError
from stickslip.dispatch.lines import remember_starts
from sweeps.config.schema import Execution
from sweeps.engine.settings import options_of
from sweeps.exits import ExpectedError
from sweeps.points import Point, point_of

# What the points of files that are of another version, or were edited, have raised.
_OBSTACLES = (ExpectedError, IntegrationError, NoiseError, ArithmeticError, ValueError)


@dataclass(frozen=True)
class Motion:
    """The time courses at a point: over its orbit or, where it has none, from its start.

    `courses` is None where they cannot be computed; `obstacle` says why.
    """

    point: Point
    courses: xr.Dataset | None
    obstacle: str = ""


def motions(
    ds: xr.Dataset,
    places: Sequence[Mapping[str, int]],
    *,
    workers: int | None = None,
    on_motion: Callable[[], None] = lambda: None,
) -> list[Motion]:
    """The motion at some points of a result, in their order.

    `places` say where the points are along the dimensions of `ds`. `on_motion` is called, in any
    thread, whenever one is finished. The first is computed alone: the others find the kernels
    compiled.

    Raises PointError if `ds` is no result of a sweep, or of one that cannot be computed here.
    """

    def computed(point: Point) -> Motion:
        motion = _motion(point)
        on_motion()
        return motion

    points = [point_of(ds.isel(place)) for place in places]
    _remember_lines(points)
    with ThreadPoolExecutor(workers or Execution().slots) as pool:
        return [*map(computed, points[:1]), *pool.map(computed, points[1:])]


def _motion(point: Point) -> Motion:
    try:
        return Motion(point, point.simulate())
    except _OBSTACLES as error:
        return Motion(point, None, str(error))


def _remember_lines(points: Sequence[Point]) -> None:
    """Follow each line once, however many of its points there are, and many lines at a time."""
    lines: dict[bytes, NDArray[np.float64]] = {}
    for point in points:
        first = point.before[:1].tobytes()
        if len(point.before) > len(lines.get(first, ())):
            lines[first] = point.before
    if lines:
        remember_starts(list(lines.values()), options_of(points[0].config))
