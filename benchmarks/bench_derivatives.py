"""Many orbits in one call, and derivatives of amplitudes at 200 random points.

`together` compares `stationary_orbits` with single calls. `derivatives` compares `sensitivities`
with differences of order 4 at rtol 1e-11, and looks for jumps within the step that it has missed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from shared.measuring import measure
from shared.points import AMPLITUDES, COUNTS, quantile, random_points
from shared.timing import medians_in_turn, timed

from stickslip import sensitivities, stationary_orbit, stationary_orbits
from stickslip.parameters import Parameters

SEED, POINTS, FEW = 2026, 200, 8
TOGETHER, RUNS = 300, 5
BY = (
    "temperature", "viscosity_coefficient", "spring_stiffness", "rheological_index",
    "angular_frequency", "film_thickness",
)  # fmt: skip
PLAIN = "rheological_index"
"""The parameter of these that is moved by a difference, all others by a factor."""

TIGHT, NEAR = 1e-11, 2e-4
STEP, SCANNED = 1e-3, 41
"""The step of `sensitivities`, and how many places within it are looked at."""

TOLERATED = 1e-4
"""Error relative to the largest derivative of a point."""


def together(quick: bool) -> dict[str, Any]:
    """Time 300 points in one call and one by one, and compare every number."""
    count = FEW if quick else TOGETHER
    points = dict(zip(Parameters._fields, random_points(count, SEED).T, strict=True))
    ds = stationary_orbits(points)
    singles = [Parameters(*row) for row in np.stack(list(points.values()), axis=1)]
    own = [stationary_orbit(each) for each in singles]
    same = all(
        np.array_equal(ds[name].values, [getattr(orbit, name) for orbit in own], equal_nan=True)
        for name in ds.data_vars
    )
    calls = (lambda: stationary_orbits(points), lambda: list(map(stationary_orbit, singles)))
    seconds = medians_in_turn(calls, 1 if quick else RUNS)
    return {"points": count, "same": same, "together": seconds[0], "singly": seconds[1]}


def derivatives(quick: bool) -> dict[str, Any]:
    """Compare errors with their estimates, and find jumps by a scan."""
    rows = random_points(POINTS, SEED)[: FEW if quick else POINTS]
    points = dict(zip(Parameters._fields, rows.T, strict=True))
    sensitivities({"T": 250.0}, BY)  # compiled
    ds, seconds = timed(lambda: sensitivities(points, BY))
    found, stated = (
        np.stack([ds[f"{name}_{what}"].values for name in AMPLITUDES])
        for what in ("sensitivity", "sensitivity_error")
    )
    true = np.stack([_true(points, name) for name in BY], axis=-1)
    jumps = np.stack([_jumps(points, name) for name in BY], axis=-1)
    known, smooth = np.isfinite(found), ~jumps[None]
    errors = np.abs(found - true)
    relative = errors / np.nanmax(np.abs(true), axis=(0, 2), keepdims=True)
    sound = known & smooth
    return {
        "points": len(rows),
        "parameters": len(BY),
        "seconds": seconds,
        "relative_error": {
            "median": quantile(relative[sound], 50),
            "95 %": quantile(relative[sound], 95),
            "max": float(relative[sound].max()),
        },
        "beyond_tolerated": int((relative[sound] > TOLERATED).sum()),
        "derivatives": int(sound.sum()),
        "held": float((errors <= stated)[sound].mean()),
        "over_median": quantile((stated / np.maximum(errors, 1e-300))[sound], 50),
        "worst_ratio": float((errors / stated)[sound].max()),
        "jumps": int(jumps.sum()),
        "jumps_missed": int((known.any(axis=0) & jumps).sum()),
        "missing_without_jump": int((~known.all(axis=0) & ~jumps).sum()),
    }


Points = Mapping[str, NDArray[np.float64]]


def _moved(points: Points, name: str, part: float) -> dict[str, NDArray[np.float64]]:
    """Return points with a parameter moved by a part of its scale."""
    value = points[name]
    return {**points, name: value + part if name == PLAIN else value * np.exp(part)}


def _true(points: Points, name: str) -> NDArray[np.float64]:
    """Return derivatives of the logarithms of the amplitudes, (2, n), by differences of order 4."""
    near = {
        steps: stationary_orbits(_moved(points, name, steps * NEAR), rtol=TIGHT)
        for steps in (-2, -1, 1, 2)
    }
    logs = {
        steps: np.log(np.stack([ds[name].values for name in AMPLITUDES]))
        for steps, ds in near.items()
    }
    return (8.0 * (logs[1] - logs[-1]) - (logs[2] - logs[-2])) / (12.0 * NEAR)


def _jumps(points: Points, name: str) -> NDArray[np.bool_]:
    """Return where the kind of motion changes within the step, (n,)."""
    kinds = ("status", "regime", *COUNTS)
    center = stationary_orbits(points, rtol=1e-8)
    changes = np.zeros(center.sizes["point"], dtype=bool)
    for part in np.linspace(-STEP, STEP, SCANNED):
        ds: xr.Dataset = stationary_orbits(_moved(points, name, part), rtol=1e-8)
        changes |= np.any([ds[kind].values != center[kind].values for kind in kinds], axis=0)
    return changes


if __name__ == "__main__":
    measure("derivatives", __doc__, {"together": together, "derivatives": derivatives})
