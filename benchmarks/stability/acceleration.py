"""Acceleration on and off, from random starts: both should end on the same orbit."""

from __future__ import annotations

from typing import Any

import numpy as np
from common import amplitude_errors, amplitudes, column, described, good, orbits, statuses

from stickslip.options import Options
from stickslip.parameters import Parameters

_SEED = 11


def random_starts(wide: int, near: int) -> np.ndarray:
    """Rows of parameters with random starts: from all over, and within 5 K of T_c."""
    rng = np.random.default_rng(_SEED)

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    return np.array(
        [
            Parameters(
                temperature=rng.uniform(285, 295) if i >= wide else rng.uniform(120, 340),
                viscosity_coefficient=log_uniform(3e3, 3e5),
                spring_stiffness=log_uniform(500, 1e4),
                rheological_index=-2 / 3 if rng.random() < 0.25 else rng.uniform(-0.8, 0.9),
                angular_frequency=log_uniform(5, 80),
                initial_displacement=rng.uniform(-0.8e-6, 0.8e-6),
                initial_velocity=rng.uniform(-2e-5, 2e-5),
                initial_order_parameter=0.0 if rng.random() < 0.5 else rng.uniform(0.0, 0.6),
            )
            for i in range(wide + near)
        ]
    )


def run(quick: bool) -> dict[str, Any]:
    """How many points differ by more than both state, or in their kind of motion."""
    wide, near = (40, 20) if quick else (2000, 1000)
    points = random_starts(wide, near)
    jumping, plain = (orbits(points, Options(accelerate=each)) for each in (True, False))
    both = good(jumping) & good(plain)
    differs = amplitude_errors(points, amplitudes(jumping), amplitudes(plain)).max(axis=1)
    stated = column(jumping, "amplitude_error") + column(plain, "amplitude_error")
    wrong = both & (differs > 10.0 * stated + 1e-6)
    return {
        "points": len(points),
        "near_melting": near,
        "compared": int(both.sum()),
        "same": int((both & ~wrong).sum()),
        "other_status": int((column(jumping, "status") != column(plain, "status")).sum()),
        "beyond_stated": int((both & (differs > stated)).sum()),
        "others": [
            described(
                points[i],
                differs=float(differs[i]),
                stated=float(stated[i]),
                multiplier=float(column(jumping, "floquet_multiplier")[i]),
            )
            for i in np.flatnonzero(wrong)
        ],
        "statuses": statuses(jumping),
        "statuses_plain": statuses(plain),
        "periods": int(column(jumping, "periods_integrated").sum()),
        "periods_plain": int(column(plain, "periods_integrated").sum()),
    }
