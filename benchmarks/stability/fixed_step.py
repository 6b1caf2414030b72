"""Whole orbits by Euler-Cromer near the step that is refused: the true error and the stated one.

The map of steps judges single periods; here the scheme settles on an orbit of its own, whose offset
from the true one grows where the orbit attracts slowly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import error_bars, good, orbits, parameter, random_points, statuses

from stickslip.options import Options
from stickslip.stability import largest_stable_step

_SEED = 29
_NEAR = 0.9  # of the largest step
_MOST_STEPS = 50_000  # in a period
_PERIODS = 200  # plain iteration of an orbit that attracts slowly would take thousands
_EXACT = 1e-11
_RESOLVED = 1e-10


def run(quick: bool) -> dict[str, Any]:
    """Count statuses at nearly the largest step, and compare true and stated errors."""
    drawn = random_points(2000, _SEED)
    steps = _NEAR * largest_stable_step(drawn)
    a_period = 2.0 * np.pi / parameter(drawn, "angular_frequency") / steps
    chosen = np.flatnonzero(a_period <= _MOST_STEPS)[: 8 if quick else 160]
    points = drawn[chosen]
    found = np.concatenate(
        [orbits(points[i : i + 1], _options(float(steps[at]))) for i, at in enumerate(chosen)]
    )
    exact = orbits(points, Options(rtol=_EXACT, stationary_rtol=_EXACT, max_error=1.0))
    both = good(found) & good(exact)
    return {
        "points": len(points),
        "statuses": statuses(found),
        **error_bars(points, found, exact, both, _RESOLVED),
    }


def _options(dt: float) -> Options:
    return Options(method="euler-cromer", dt=dt, max_periods=_PERIODS)
