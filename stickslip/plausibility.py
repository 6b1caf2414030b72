"""Checks for finished results that are possible but suspicious: reasons to look closer.

The impossible has a status of its own (`invariant_violated`); stability.py checks in advance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import ParameterValues
from stickslip.stability import static_strength
from stickslip.variables import RESULT_COLUMNS

SUSPICIOUS_BALANCE = 1e-3
"""An orbit deserves a look if both its power balance error and its amplitude error exceed this;
beyond 1e-2 the former is a status. Where the force is a few percent of the full one, the balance is
a small difference of large numbers, and the amplitudes are right all the same."""

SUSPICIOUS_STRESS = 1.1
"""Stress relative to its static maximum that fast kinetics would not reach; slow kinetics may."""

# Below this fraction of the full spring force, over A, a stress is too small to be compared.
_SMALL = 0.01

# This many strains give the static maximum to one percent.
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
    """Tell which rows (n, columns) exceed `SUSPICIOUS_BALANCE` in both errors."""
    return np.asarray(np.minimum(results[:, _BALANCE], results[:, _ERROR]) > SUSPICIOUS_BALANCE)


def suspicious_stress(
    points: NDArray[np.float64], results: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Tell which points (n, parameters) exceed the static stress by 10 %; `results`."""
    p = ParameterValues(*points.T)
    stress = np.maximum(np.abs(results[:, _MAX]), np.abs(results[:, _MIN]))
    small = _SMALL * 2.0 * p.spring_stiffness * np.abs(p.drive_amplitude) / p.contact_area
    # A few strains already clear most points; the others get a closer look.
    suspicious = stress > SUSPICIOUS_STRESS * np.maximum(static_strength(points, _SOME), small)
    few = np.flatnonzero(suspicious)
    suspicious[few] = stress[few] > SUSPICIOUS_STRESS * static_strength(points[few])
    return np.asarray(suspicious)
