"""Euler-Cromer over the step and the scene: what is wrong, and what the checks say of it.

One period from the state on which the adaptive method settles, at steps from a hundredth to a
hundred times the limit above which a step is refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.fixed import fixed_period, reference_period
from shared.points import column, parameter, random_points

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.stability import largest_stable_step
from stickslip.status import Status

RATIOS = tuple(float(f"{r:.3g}") for r in np.geomspace(1e-2, 1e2, 17))
_SCENES = 32
_SEED = 17
_LEAST_OMEGA = 30.0
_MOST_STEPS = 20_000_000
# An error that no one would call right, and the largest that an ok point may state.
_WRONG = 1e-2


def run(quick: bool) -> dict[str, Any]:
    """Judge the cells of the map, by scene and ratio, and count each kind."""
    points = _scenes(2 if quick else _SCENES)
    results, finals = compute_orbits(points, Options(rtol=1e-9, stationary_rtol=1e-9))
    keep = (column(results, "status") == Status.OK) & (column(results, "orbit_periods") == 1)
    points, finals = points[keep], finals[keep]
    exact, near = (reference_period(points, finals, rtol) for rtol in (1e-11, 1e-9))
    limits, omegas = largest_stable_step(points), parameter(points, "angular_frequency")
    cells = []
    ratios = RATIOS[4:13:4] if quick else RATIOS
    for i in range(len(points)):
        for ratio in ratios:
            dt = float(ratio * limits[i])
            steps = 2.0 * np.pi / omegas[i] / dt
            if 10.0 <= steps <= _MOST_STEPS:
                row, error = fixed_period(points[i], finals[i], dt, exact[i], near[i])
                cells.append(_cell(i, ratio, dt, row, error))
    return {"scenes": len(points), "cells": cells, "counts": _counts(cells)}


def _scenes(count: int) -> np.ndarray:
    drawn = random_points(40 * count, _SEED)
    return drawn[parameter(drawn, "angular_frequency") >= _LEAST_OMEGA][:count]


def _cell(scene: int, ratio: float, dt: float, row: np.ndarray, error: float) -> dict[str, Any]:
    status, stated = (column(row[None], name)[0] for name in ("status", "amplitude_error"))
    refused = ratio > 1.0
    accepted = status == Status.OK and stated <= _WRONG
    wrong = not error <= _WRONG
    kind = (
        ("refused, rightly" if wrong else "refused, and right")
        if refused
        else ("wrong" if wrong else "right")
        if accepted
        else "caught afterwards"
    )
    would_pass = refused and wrong and accepted
    return {
        "scene": scene,
        "ratio": ratio,
        "dt": dt,
        "error": float(error),
        "stated": float(stated),
        "status": Status(int(status)).name.lower(),
        "kind": kind,
        "missed_afterwards": bool(would_pass),
    }


def _counts(cells: list[dict[str, Any]]) -> dict[str, int]:
    kinds = [cell["kind"] for cell in cells]
    return {kind: kinds.count(kind) for kind in sorted(set(kinds))} | {
        "wrong, and no check afterwards would see it": sum(c["missed_afterwards"] for c in cells)
    }
