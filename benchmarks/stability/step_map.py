"""Euler-Cromer over the step and the scene: what is wrong, and what the checks say of it.

One period from the state on which the adaptive method settles, at steps from a hundredth to a
hundred times the limit above which a step is refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.fixed import fixed_period
from inside.lanes import period_records
from shared.points import at, orbits, parameter, random_points

from stickslip.stability import largest_stable_step
from stickslip.status import Status

RATIOS = tuple(float(f"{r:.3g}") for r in np.geomspace(1e-2, 1e2, 17))
_SCENES = 32
_LEAST_OMEGA = 30.0
_MOST_STEPS = 20_000_000
# An error that no one would call right, and the largest that an ok point may state.
_WRONG = 1e-2


def run(quick: bool) -> dict[str, Any]:
    """Judge the cells of the map, by scene and ratio, and count each kind."""
    settled = orbits(_scenes(2 if quick else _SCENES), **at(1e-9))
    settled = settled[settled.ok & (settled.orbit_periods == 1)]
    points = settled.points
    exact, near = (period_records(points, rtol, settled.finals) for rtol in (1e-11, 1e-9))
    limits, omegas = largest_stable_step(points), parameter(points, "angular_frequency")
    cells = []
    for i in range(len(points)):
        for ratio in RATIOS[4:13:4] if quick else RATIOS:
            dt = float(ratio * limits[i])
            if 10.0 <= 2.0 * np.pi / omegas[i] / dt <= _MOST_STEPS:
                found, error = fixed_period(points[i], settled.finals[i], dt, exact[i], near[i])
                status, stated = int(found.status[0]), float(found.amplitude_error[0])
                own = {"scene": i, "ratio": ratio, "dt": dt, "error": error, "stated": stated}
                cells.append(own | _judged(ratio, error, stated, Status(status)))
    return {"scenes": len(points), "cells": cells, "counts": _counts(cells)}


def _scenes(count: int) -> np.ndarray:
    points = random_points(40 * count, 17)
    return points[parameter(points, "angular_frequency") >= _LEAST_OMEGA][:count]


def _judged(ratio: float, error: float, stated: float, status: Status) -> dict[str, Any]:
    """Return the kind of a cell, and whether the checks afterwards would miss its error."""
    accepted = status == Status.OK and stated <= _WRONG
    wrong = not error <= _WRONG
    if ratio > 1.0:
        kind = "refused, rightly" if wrong else "refused, and right"
    elif accepted:
        kind = "wrong" if wrong else "right"
    else:
        kind = "caught afterwards"
    missed = ratio > 1.0 and wrong and accepted
    return {"status": status.name.lower(), "kind": kind, "missed_afterwards": missed}


def _counts(cells: list[dict[str, Any]]) -> dict[str, int]:
    kinds = [cell["kind"] for cell in cells]
    return {kind: kinds.count(kind) for kind in sorted(set(kinds))} | {
        "wrong, and no check afterwards would see it": sum(c["missed_afterwards"] for c in cells)
    }
