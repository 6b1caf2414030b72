"""The drive of the upper block (Eqs. 1, 2)."""

from __future__ import annotations

import math

from stickslip.compiled import inline


@inline
def upper_displacement(t: float, X_m: float, omega: float) -> float:
    """Displacement X of the upper block [m], Eq. 1."""
    return X_m * math.cos(omega * t)


@inline
def upper_velocity(t: float, X_m: float, omega: float) -> float:
    """Velocity V of the upper block [m/s], Eq. 2."""
    return -X_m * omega * math.sin(omega * t)


@inline
def upper_acceleration(t: float, X_m: float, omega: float) -> float:
    """Acceleration dV/dt of the upper block [m/s2], from Eq. 2."""
    return -X_m * (omega * omega) * math.cos(omega * t)
