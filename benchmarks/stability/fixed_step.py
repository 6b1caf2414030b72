"""Whole orbits by Euler-Cromer near the step that is refused: the true error and the stated one.

The map of steps judges single periods; here the scheme settles on an orbit of its own, whose offset
from the true one grows where the orbit attracts slowly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import Orbits, at, orbits, parameter, random_points

from stickslip.stability import largest_stable_step

_NEAR = 0.9  # of the largest step
_MOST_STEPS = 50_000  # in a period
_PERIODS = 200  # plain iteration of an orbit that attracts slowly would take thousands
_EXACT, _RESOLVED = 1e-11, 1e-10


def run(quick: bool) -> dict[str, Any]:
    """Count statuses at nearly the largest step, and compare true and stated errors."""
    points = random_points(2000, 29)
    steps = _NEAR * largest_stable_step(points)
    in_a_period = 2.0 * np.pi / parameter(points, "angular_frequency") / steps
    chosen = np.flatnonzero(in_a_period <= _MOST_STEPS)[: 8 if quick else 160]
    points, steps = points[chosen], steps[chosen]
    each = [_by_euler_cromer(*pair) for pair in zip(points, steps, strict=True)]
    found = Orbits(points, *map(np.concatenate, zip(*each, strict=True)))
    exact = orbits(points, max_error=1.0, **at(_EXACT))
    return {
        "points": len(points),
        "statuses": found.statuses(),
        **found.error_bars(exact, found.ok & exact.ok, _RESOLVED),
    }


def _by_euler_cromer(point: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return results and final state of a point, each a row."""
    found = orbits(point[None], method="euler-cromer", dt=float(dt), max_periods=_PERIODS)
    return found.rows, found.finals
