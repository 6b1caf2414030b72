"""What looks wrong in finished results without being impossible: reasons to look closer.

What is impossible is a status (`invariant_violated`); the a priori side is stability.py.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import ParameterValues
from stickslip.stability import static_strength
from stickslip.variables import RESULT_COLUMNS

SUSPICIOUS_BALANCE = 1e-3
"""Power balance error from which an orbit deserves a look where its amplitudes are stated to be
less certain than this, too; 1e-2 is a status. Where the force is a few percent of the full one the
balance is a small difference of large numbers, and the amplitudes are right all the same."""

SUSPICIOUS_STRESS = 1.1
"""Stress over its static maximum that fast kinetics would not reach; slow ones may."""

# Below this part of the full spring force, over A, a stress is too small to be compared.
_SMALL = 0.01

# Strains that give the static maximum to a percent.
_SOME = 12

_MAX, _MIN, _BALANCE, _ERROR = (
    RESULT_COLUMNS.index(name)
    for name in (
        "elastic_stress_max",
        "elastic_stress_min",
        "power_balance_error",
        "amplitude_error",
    )
)


def suspicious_balance(results: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which rows (n, columns) have power balance and amplitudes above `SUSPICIOUS_BALANCE`."""
    return np.asarray(np.minimum(results[:, _BALANCE], results[:, _ERROR]) > SUSPICIOUS_BALANCE)


def suspicious_stress(
    points: NDArray[np.float64], results: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Which points (n, parameters) with results (n, columns) exceed the static stress by 10 %."""
    p = ParameterValues(*points.T)
    stress = np.maximum(np.abs(results[:, _MAX]), np.abs(results[:, _MIN]))
    small = _SMALL * 2.0 * p.spring_stiffness * np.abs(p.drive_amplitude) / p.contact_area
    # Most points are cleared by what some strains already give; the others get a closer look.
    suspicious = stress > SUSPICIOUS_STRESS * np.maximum(static_strength(points, _SOME), small)
    few = np.flatnonzero(suspicious)
    suspicious[few] = stress[few] > SUSPICIOUS_STRESS * static_strength(points[few])
    return np.asarray(suspicious)
