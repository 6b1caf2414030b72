"""Blocks locked by a solid film near resonance: a small difference of two large forces.

The force of the film is then what is left of the springs and of the inertia of the block,
|2K - M omega^2| |X_m|, and it is carried by a relative velocity that is tiny beside the drive's.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.scalar import scalar_amplitudes, scalar_states
from shared.points import (
    amplitudes,
    column,
    description,
    error_bars,
    good,
    log_uniform,
    orbits,
    parameter,
    quantile,
)

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters

_SEED = 23
_INDICES = (-0.8, -2 / 3, -0.5)
_NEARNESS = 0.3  # of 2K / M omega^2 to 1
_EXACT = 1e-11
_PERIODS = 4  # by the scalar drive, from the orbit of the lanes
_RESOLVED = 1e-9
_BALANCED = 1e-5


def run(quick: bool) -> dict[str, Any]:
    """Measure errors of the force at the default, and of both amplitudes against stated ones."""
    drawn = _locked(20 if quick else 400)
    exact, settled = _exact(drawn)
    points, exact = drawn[settled], exact[settled]
    results = orbits(points, Options())
    found = amplitudes(results)
    of_force = np.abs(found[:, 1] / exact[:, 1] - 1.0)
    of_balance = np.abs(exact[:, 1] / balance(points) - 1.0)
    worst = int(np.argmax(of_force))
    return {
        "points": len(drawn),
        "ok": int(good(results).sum()),
        "force_median": quantile(of_force, 50),
        "force_max": float(of_force.max()),
        "balance_median": quantile(of_balance, 50),
        "balance_max": float(of_balance.max()),
        "balance_held": float(np.mean(of_balance <= _BALANCED)),
        **error_bars(points, results, exact, good(results), _RESOLVED),
        "worst": description(points[worst], error=float(of_force[worst])),
    }


def balance(points: np.ndarray) -> np.ndarray:
    """Return force [N] that moves a block with the drive: |2K - M omega^2| |X_m|, (n,)."""
    away = 2.0 * parameter(points, "spring_stiffness") - inertia(points)
    return np.asarray(np.abs(away * parameter(points, "drive_amplitude")))


def inertia(points: np.ndarray) -> np.ndarray:
    """Return M omega^2 [N/m], force over displacement of a block that moves with the drive."""
    mass, omega = parameter(points, "block_mass"), parameter(points, "angular_frequency")
    return np.asarray(mass * omega**2)


def _locked(count: int) -> np.ndarray:
    """Return the first points of a sequence whose film is solid throughout, (count, parameters)."""
    points = _drawn(2 * count)
    results = orbits(points, Options())
    solid = (column(results, "solid_fraction") == 1.0) & (column(results, "melting_count") == 0)
    return points[solid & good(results)][:count]


def _drawn(count: int) -> np.ndarray:
    rng, rows = np.random.default_rng(_SEED), []
    for _ in range(count):
        omega = rng.uniform(5.0, 60.0)
        inertia = Parameters().block_mass * omega**2
        rows.append(
            Parameters(
                temperature=rng.uniform(150.0, 285.0),
                viscosity_coefficient=log_uniform(rng, 1e4, 3e5),
                angular_frequency=omega,
                spring_stiffness=0.5 * inertia * (1.0 + rng.uniform(-_NEARNESS, _NEARNESS)),
                rheological_index=rng.choice(_INDICES),
            )
        )
    return np.array(rows)


def _exact(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes (n, 2) by the scalar drive at 1e-11, and which points have settled."""
    options = Options(rtol=_EXACT, stationary_rtol=_EXACT, max_error=1.0)
    results, finals = compute_orbits(points, options)
    exact, settled = np.empty((len(points), 2)), good(results)
    for i in np.flatnonzero(settled):
        states = scalar_states(points[i], finals[i, :3], _PERIODS, _EXACT)
        exact[i] = scalar_amplitudes(points[i], states[-1], 1, _EXACT)[:2]
    return exact, settled
