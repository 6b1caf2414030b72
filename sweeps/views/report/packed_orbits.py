"""The orbits of chosen points, thinned and packed for a page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from stickslip.status import Status
from sweeps.figures.labels import shown
from sweeps.views.orbits import Motion, motions
from sweeps.views.report.chosen_points import Numbers, places_of
from sweeps.views.report.figures import COURSES
from sweeps.views.report.packing import packed, thinned


def packed_orbits(
    ds: xr.Dataset,
    chosen: Numbers,
    *,
    workers: int | None = None,
    on_motion: Callable[[], None] = lambda: None,
) -> list[dict[str, Any]]:
    """The motion at some points, given as their numbers in C order, for the scripts of a page."""
    found = motions(ds, places_of(ds, chosen), workers=workers, on_motion=on_motion)
    return [
        {"point": number, **_packed(motion)}
        for number, motion in zip(chosen.tolist(), found, strict=True)
    ]


def _packed(motion: Motion) -> dict[str, Any]:
    if motion.courses is None:
        return {"obstacle": motion.obstacle}
    names = ("elapsed_time", *COURSES)
    columns = np.stack([shown(motion.courses[name]).values for name in names])
    columns = columns[:, thinned(columns)]
    arrays = {name: packed(column) for name, column in zip(names, columns, strict=True)}
    omega = float(motion.courses["angular_frequency"])
    periods = round(float(motion.courses["elapsed_time"][-1]) * omega / (2 * np.pi))
    status = motion.point.orbit().status
    return {
        "periods": periods,
        "settled": status.is_result,
        "closed": status is not Status.APERIODIC,
        "columns": arrays,
    }
