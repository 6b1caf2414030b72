"""The drive of the upper block (Eqs. 1, 2)."""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine


@inline
def upper_displacement(t: float, X_m: float, omega: float) -> float:
    """Displacement X of the upper block [m], Eq. 1."""
    return X_m * sine_and_cosine(omega * t)[1]


@inline
def upper_velocity(t: float, X_m: float, omega: float) -> float:
    """Velocity V of the upper block [m/s], Eq. 2."""
    return -X_m * omega * sine_and_cosine(omega * t)[0]


@inline
def upper_acceleration(t: float, X_m: float, omega: float) -> float:
    """Acceleration dV/dt of the upper block [m/s2], from Eq. 2."""
    return -X_m * (omega * omega) * sine_and_cosine(omega * t)[1]
