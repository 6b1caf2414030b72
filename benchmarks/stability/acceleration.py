"""Acceleration on and off, from random starts: both should end on the same orbit."""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import Log, box, descriptions, drawn, log_uniform, orbits

from stickslip.parameters import Parameters

# Cycles of a hundred applications are approached in thousands.
_MAX_PERIODS_OF_SEVERAL = 3000

_several = box(
    2911,
    T=(150, 260),
    k=Log(1e4, 7e4),
    K=Log(1300, 3800),
    gamma=(-0.85, -0.75),
    omega=(15, 50),
    x_0=(-8e-7, 8e-7),
)
"""Films that may stay liquid, freeze for good, or do both by turns."""


def run(quick: bool) -> dict[str, Any]:
    """Count the points that differ by more than both state, or in their kind of motion."""
    wide, near = (40, 20) if quick else (2000, 1000)
    return {
        "near_melting": near,
        **_compared(_random_starts(wide, near)),
        "several": _compared(_several(20 if quick else 2000), max_periods=_MAX_PERIODS_OF_SEVERAL),
    }


def _random_starts(wide: int, near: int) -> np.ndarray:
    """Return rows of parameters with random starts: from all over, and within 5 K of T_c."""
    return drawn(
        wide + near,
        11,
        lambda rng, i: Parameters(
            temperature=rng.uniform(285, 295) if i >= wide else rng.uniform(120, 340),
            viscosity_coefficient=log_uniform(rng, 3e3, 3e5),
            spring_stiffness=log_uniform(rng, 500, 1e4),
            rheological_index=-2 / 3 if rng.random() < 0.25 else rng.uniform(-0.8, 0.9),
            angular_frequency=log_uniform(rng, 5, 80),
            initial_displacement=rng.uniform(-0.8e-6, 0.8e-6),
            initial_velocity=rng.uniform(-2e-5, 2e-5),
            initial_order_parameter=0.0 if rng.random() < 0.5 else rng.uniform(0.0, 0.6),
        ),
    )


def _compared(points: np.ndarray, **options: Any) -> dict[str, Any]:
    jumping, plain = (orbits(points, accelerate=each, **options) for each in (True, False))
    both = jumping.ok & plain.ok
    differs = jumping.errors(plain)
    stated = jumping.amplitude_error + plain.amplitude_error
    wrong = both & (differs > 10.0 * stated + 1e-6)
    return {
        "points": len(points),
        "compared": int(both.sum()),
        "same": int((both & ~wrong).sum()),
        "other_status": int((jumping.status != plain.status).sum()),
        "beyond_stated": int((both & (differs > stated)).sum()),
        "others": descriptions(
            points, wrong, differs=differs, stated=stated, multiplier=jumping.floquet_multiplier
        ),
        "statuses": jumping.statuses(),
        "statuses_plain": plain.statuses(),
        "periods": int(jumping.periods_integrated.sum()),
        "periods_plain": int(plain.periods_integrated.sum()),
    }
