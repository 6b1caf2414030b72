"""Blocks locked by a solid film near resonance: a small difference of two large forces.

The force of the film is then what is left of the springs and of the inertia of the block,
|2K - M omega^2| |X_m|, and it is carried by a relative velocity that is tiny beside the drive's.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.scalar import scalar_amplitudes, scalar_states
from shared.points import at, drawn, log_uniform, orbits, parameter, quantile

from stickslip.parameters import Parameters

_INDICES = (-0.8, -2 / 3, -0.5)
_NEARNESS = 0.3  # of 2K / M omega^2 to 1
_EXACT, _RESOLVED = 1e-11, 1e-9
_PERIODS = 4  # by the scalar integrator, from the orbit of the lanes
_BALANCED = 1e-5


def run(quick: bool) -> dict[str, Any]:
    """Measure how far the force is from the balance, and errors against stated ones."""
    points = _locked(20 if quick else 400)
    exact, settled = _exact(points)
    found, exact = orbits(points[settled]), exact[settled]
    off = np.abs(exact[:, 1] / balance(found.points) - 1.0)
    return {
        "points": len(points),
        "ok": int(found.ok.sum()),
        "balance_median": quantile(off, 50),
        "balance_max": float(off.max()),
        "balance_held": float(np.mean(off <= _BALANCED)),
        **found.error_bars(exact, found.ok, _RESOLVED),
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
    found = orbits(drawn(2 * count, 23, _near_resonance))
    solid = (found.solid_fraction == 1.0) & (found.melting_count == 0)
    return found.points[solid & found.ok][:count]


def _near_resonance(rng: np.random.Generator, _: int) -> Parameters:
    omega = rng.uniform(5.0, 60.0)
    inertia = Parameters().block_mass * omega**2
    return Parameters(
        temperature=rng.uniform(150.0, 285.0),
        viscosity_coefficient=log_uniform(rng, 1e4, 3e5),
        angular_frequency=omega,
        spring_stiffness=0.5 * inertia * (1.0 + rng.uniform(-_NEARNESS, _NEARNESS)),
        rheological_index=rng.choice(_INDICES),
    )


def _exact(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return amplitudes (n, 2) by the scalar integrator at 1e-11, and which points have settled."""
    found, exact = orbits(points, max_error=1.0, **at(_EXACT)), np.empty((len(points), 2))
    for i in np.flatnonzero(found.ok):
        states = scalar_states(points[i], found.finals[i, :3], _PERIODS, _EXACT)
        exact[i] = scalar_amplitudes(points[i], states[-1], _EXACT)
    return exact, found.ok
