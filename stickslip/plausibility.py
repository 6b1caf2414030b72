"""What looks wrong in finished results without being impossible: reasons to look closer.

What is impossible is a status (`invariant_violated`); the a priori side is stability.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels import RESULT_COLUMNS
from stickslip.stability import static_strength

DOUBTFUL_BALANCE = 1e-3
"""Power balance error from which an orbit deserves a look; 1e-2 is a status."""

DOUBTFUL_STRESS = 1.1
"""Stress over its static maximum that fast kinetics would not reach; slow ones may."""

# Below this part of the full spring force, over A, a stress is too small to be compared.
_SMALL = 0.01

# Strains that give the static maximum to a percent.
_SOME = 12

_MAX, _MIN, _BALANCE = (
    RESULT_COLUMNS.index(name)
    for name in ("elastic_stress_max", "elastic_stress_min", "power_balance_error")
)


def doubtful_balance(results: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which result rows (n, 13) have a power balance error above `DOUBTFUL_BALANCE`."""
    return np.asarray(results[:, _BALANCE] > DOUBTFUL_BALANCE)


def doubtful_stress(points: NDArray[np.float64], results: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points (n, 20) with results (n, 13) exceed the static maximum of the stress by 10 %."""
    stress = np.maximum(np.abs(results[:, _MAX]), np.abs(results[:, _MIN]))
    X_m, K, A = points[:, 5], points[:, 2], points[:, 12]
    small = _SMALL * 2.0 * K * np.abs(X_m) / A
    # Most points are cleared by what some strains already give; the others get a closer look.
    doubtful = stress > DOUBTFUL_STRESS * np.maximum(static_strength(points, _SOME), small)
    few = np.flatnonzero(doubtful)
    doubtful[few] = stress[few] > DOUBTFUL_STRESS * static_strength(points[few])
    return np.asarray(doubtful)
