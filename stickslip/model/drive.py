"""The drive of the upper block (Eqs. 1, 2)."""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.parameters import Parameters


@inline
def period(p: Parameters) -> float:
    """Drive period 2 pi/omega [s]."""
    return 2.0 * math.pi / p.angular_frequency


@inline
def upper_displacement(p: Parameters, t: float) -> float:
    """Displacement X of the upper block [m], Eq. 1."""
    return p.drive_amplitude * sine_and_cosine(p.angular_frequency * t)[1]


@inline
def upper_velocity(p: Parameters, t: float) -> float:
    """Velocity V of the upper block [m/s], Eq. 2."""
    omega = p.angular_frequency
    return -p.drive_amplitude * omega * sine_and_cosine(omega * t)[0]


@inline
def upper_acceleration(p: Parameters, t: float) -> float:
    """Acceleration dV/dt of the upper block [m/s2], from Eq. 2."""
    omega = p.angular_frequency
    return -p.drive_amplitude * (omega * omega) * sine_and_cosine(omega * t)[1]


@inline
def upper_jerk(p: Parameters, t: float) -> float:
    """Second derivative of the velocity V of the upper block [m/s3], from Eq. 2."""
    return -(p.angular_frequency * p.angular_frequency) * upper_velocity(p, t)
