"""The drive of the upper block (Eqs. 1, 2): a sum of tones, of which the paper has one."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.parameters import Parameters


class Tone(NamedTuple):
    """A cosine of the drive: inline functions made by `tone`."""

    harmonic: int
    """Its frequency in units of the drive's."""

    amplitude: Callable[..., float]
    """(p): its amplitude [m], negative for the opposite phase."""

    displacement: Callable[..., float]
    """(p, t) [m]."""

    velocity: Callable[..., float]
    """(p, t) [m/s]."""

    acceleration: Callable[..., float]
    """(p, t) [m/s2]."""


def tone(harmonic: int, amplitude: Callable[[Parameters], float]) -> Tone:
    """Return the tone of a harmonic; its `amplitude` [m] is an inline function of the parameters.

    Raises ValueError for an even harmonic: the drive must change sign after half a period, since
    the search for orbits and the lanes rely on that symmetry.
    """
    if harmonic % 2 == 0:
        raise ValueError(
            f"tone {harmonic} of the drive: an even harmonic breaks the symmetry of half periods "
            "(x, v, phi, t) -> (-x, -v, phi, t + pi/omega); only odd ones can be computed"
        )
    times = float(harmonic)

    @inline
    def displacement(p: Parameters, t: float) -> float:
        return amplitude(p) * sine_and_cosine(times * p.angular_frequency * t)[1]

    @inline
    def velocity(p: Parameters, t: float) -> float:
        omega = times * p.angular_frequency
        return -amplitude(p) * omega * sine_and_cosine(omega * t)[0]

    @inline
    def acceleration(p: Parameters, t: float) -> float:
        omega = times * p.angular_frequency
        return -amplitude(p) * (omega * omega) * sine_and_cosine(omega * t)[1]

    return Tone(harmonic, amplitude, displacement, velocity, acceleration)


@inline
def _amplitude(p: Parameters) -> float:
    return p.drive_amplitude


TONES: tuple[Tone, ...] = (
    tone(1, _amplitude),
)  # fmt: skip
"""The tones of the drive. A further one needs its amplitude in the registry, `directed` because it
changes sign in the mirror image of the motion."""


def _sum(terms: list[Any]) -> Any:
    """Return the inline function (p, t) of the sum of these."""
    total = terms[0]
    for term in terms[1:]:
        total = _plus(total, term)
    return total


def _plus(one: Any, other: Any) -> Any:
    @inline
    def both(p: Parameters, t: float) -> float:
        return one(p, t) + other(p, t)

    return both


def _jerk(one: Tone) -> Any:
    velocity, times = one.velocity, float(one.harmonic)

    @inline
    def jerk(p: Parameters, t: float) -> float:
        omega = times * p.angular_frequency
        return -(omega * omega) * velocity(p, t)

    return jerk


def _size(one: Tone, order: int) -> Any:
    """Return the largest absolute value of a tone's derivative of this order, of (p, t)."""
    amplitude, times = one.amplitude, float(one.harmonic)

    @inline
    def size(p: Parameters, t: float) -> float:
        return abs(amplitude(p)) * (times * p.angular_frequency) ** order

    return size


_displacement, _velocity = _sum([t.displacement for t in TONES]), _sum([t.velocity for t in TONES])
_acceleration = _sum([t.acceleration for t in TONES])
_jerks = _sum([_jerk(t) for t in TONES])
_sizes = tuple(_sum([_size(t, order) for t in TONES]) for order in range(3))
_largest_displacement, _largest_speed, _largest_acceleration = _sizes

HIGHEST_HARMONIC = max(t.harmonic for t in TONES)


@inline
def period(p: Parameters) -> float:
    """Drive period 2 pi/omega [s]."""
    return 2.0 * math.pi / p.angular_frequency


@inline
def upper_displacement(p: Parameters, t: float) -> float:
    """Displacement X of the upper block [m], Eq. 1."""
    return _displacement(p, t)


@inline
def upper_velocity(p: Parameters, t: float) -> float:
    """Velocity V of the upper block [m/s], Eq. 2."""
    return _velocity(p, t)


@inline
def upper_acceleration(p: Parameters, t: float) -> float:
    """Acceleration dV/dt of the upper block [m/s2], from Eq. 2."""
    return _acceleration(p, t)


@inline
def upper_jerk(p: Parameters, t: float) -> float:
    """Second derivative of the velocity V of the upper block [m/s3], from Eq. 2."""
    return _jerks(p, t)


@inline
def largest_speed(p: Parameters) -> float:
    """Upper bound of the speed of the upper block [m/s]: |X_m| omega."""
    return _largest_speed(p, 0.0)


@inline
def largest_displacement(p: Parameters) -> float:
    """Upper bound of the displacement of the upper block [m]: |X_m|."""
    return _largest_displacement(p, 0.0)


@inline
def largest_acceleration(p: Parameters) -> float:
    """Upper bound of the acceleration of the upper block [m/s2]: |X_m| omega^2."""
    return _largest_acceleration(p, 0.0)
