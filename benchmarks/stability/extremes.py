"""Parameters far beyond any film: each ends ok, or says why not, in a bounded number of steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import Orbits, at, descriptions, drawn, log_uniform, orbits

from stickslip.parameters import Parameters
from stickslip.status import Status

_STEPS, _PERIODS = 500_000, 1000

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
"""Values of a single parameter."""

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
"""Ranges of all at once, log-uniform but for the index."""


def run(quick: bool) -> dict[str, Any]:
    """Count statuses of single extremes and of random points, and check a sample of these."""
    one = [(n, v) for n, values in EXTREMES.items() for v in values]
    alone = np.array([Parameters(**{name: value}) for name, value in one])
    points = drawn(40 if quick else 2000, 13, _extreme)
    limits = {"max_steps": _STEPS, "max_periods": _PERIODS}
    found, single = orbits(points, **limits), orbits(alone, **limits)
    return {
        "one_at_a_time": [
            {"parameter": name, "value": value, "status": Status(int(code)).name.lower()}
            for (name, value), code in zip(one, single.status, strict=True)
        ],
        "points": len(points),
        "statuses": found.statuses(),
        "sample": _checked(found[found.ok], max(len(points) // 10, 4)),
    }


def _extreme(rng: np.random.Generator, _: int) -> Parameters:
    values = {name: log_uniform(rng, *ends) for name, ends in RANGES.items()}
    return Parameters(rheological_index=rng.uniform(-0.999, 5.0), **values)


def _checked(found: Orbits, count: int) -> dict[str, Any]:
    """Compute some points again at a hundredth of the tolerance; list those far off."""
    sample = found[:: max(len(found) // count, 1)][:count]
    better = orbits(sample.points, max_steps=5 * _STEPS, max_periods=5 * _PERIODS, **at(1e-8))
    sample, better = sample[better.ok], better[better.ok]
    missed, stated = sample.errors(better), sample.amplitude_error
    return {
        "compared": len(sample),
        "held": float(np.mean(missed <= stated)) if len(sample) else 1.0,
        "wrong": descriptions(
            sample.points, missed > 10.0 * stated + 1e-4, missed=missed, stated=stated
        ),
    }
