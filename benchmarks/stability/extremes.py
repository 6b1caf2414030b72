"""Parameters far beyond any film: each ends ok, or says why not, in a bounded number of steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import (
    column,
    description,
    good,
    log_uniform,
    orbits,
    statuses,
    worse_errors,
)

from stickslip.options import Options
from stickslip.parameters import Parameters
from stickslip.status import Status

_SEED = 13
_STEPS = 500_000
_PERIODS = 1000

EXTREMES: dict[str, tuple[float, ...]] = {
    "rheological_index": (-0.999, -0.9, -2 / 3, 0.0, 2 / 3, 2.0, 5.0),
    "viscosity_coefficient": (0.0, 1e-6, 1.0, 1e9),
    "spring_stiffness": (0.0, 1e-3, 1e8),
    "kinetic_coefficient": (1e-3, 1e6),
    "temperature": (0.0, 290.0, 1e4),
    "angular_frequency": (1e-2, 1e5),
    "block_mass": (1e-9, 1e3),
    "film_thickness": (1e-11, 1e-6),
    "strain_relaxation_time": (1e-12, 1e-3),
}
# Log-uniform, but for the index.
RANGES: dict[str, tuple[float, float]] = {
    "viscosity_coefficient": (1e-6, 1e9),
    "spring_stiffness": (1e-2, 1e8),
    "kinetic_coefficient": (1e-3, 1e6),
    "temperature": (1.0, 1e4),
    "angular_frequency": (1e-2, 1e5),
    "block_mass": (1e-9, 1e3),
    "film_thickness": (1e-11, 1e-6),
    "strain_relaxation_time": (1e-12, 1e-3),
}


def run(quick: bool) -> dict[str, Any]:
    """Count statuses of single extremes and of random points, and check a sample of these."""
    one = [(n, v) for n, values in EXTREMES.items() for v in values]
    alone = np.array([Parameters(**{name: value}) for name, value in one])
    points = random_extremes(40 if quick else 2000)
    options = Options(max_steps=_STEPS, max_periods=_PERIODS)
    results, single = orbits(points, options), orbits(alone, options)
    return {
        "one_at_a_time": [
            {"parameter": name, "value": value, "status": Status(int(code)).name.lower()}
            for (name, value), code in zip(one, column(single, "status"), strict=True)
        ],
        "points": len(points),
        "statuses": statuses(results),
        "worst_stated": float(column(results, "amplitude_error")[good(results)].max()),
        "sample": _checked(points, results, max(len(points) // 10, 4)),
    }


def random_extremes(count: int) -> np.ndarray:
    """Return rows (count, parameters)."""
    rng = np.random.default_rng(_SEED)
    rows = []
    for _ in range(count):
        values = {name: log_uniform(rng, *ends) for name, ends in RANGES.items()}
        rows.append(Parameters(rheological_index=rng.uniform(-0.999, 5.0), **values))
    return np.array(rows)


def _checked(points: np.ndarray, results: np.ndarray, count: int) -> dict[str, Any]:
    """Compute some ok points again at a hundredth of the tolerance; list those far off."""
    rows = np.flatnonzero(good(results))[:: max(good(results).sum() // count, 1)][:count]
    tight = Options(rtol=1e-8, stationary_rtol=1e-8, max_steps=5 * _STEPS, max_periods=5 * _PERIODS)
    better = orbits(points[rows], tight)
    both = good(better)
    rows, better = rows[both], better[both]
    missed = worse_errors(points[rows], results[rows], better)
    stated = column(results, "amplitude_error")[rows]
    return {
        "compared": len(rows),
        "held": float(np.mean(missed <= stated)) if len(rows) else 1.0,
        "wrong": [
            description(points[i], missed=float(m), stated=float(s))
            for i, m, s in zip(rows, missed, stated, strict=True)
            if m > 10.0 * s + 1e-4
        ],
    }
