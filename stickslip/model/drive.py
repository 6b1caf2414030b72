"""The drive of the upper block (Eqs. 1, 2): a sum of tones, of which the paper has one.

A trajectory may have another one: pulled at a velocity that is linear in pieces.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Iterable
from functools import reduce
from typing import TYPE_CHECKING, Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.parameters import Parameters, ParameterValues


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


def _sum(terms: Iterable[Any]) -> Any:
    """Return the inline function of the sum of these, which have the same arguments."""
    return reduce(_plus, terms)


def _plus(one: Any, other: Any) -> Any:
    @inline
    def both(*arguments: Any) -> float:
        return one(*arguments) + other(*arguments)

    return both


def _jerk(one: Tone) -> Any:
    velocity, times = one.velocity, float(one.harmonic)

    @inline
    def jerk(p: Parameters, t: float) -> float:
        omega = times * p.angular_frequency
        return -(omega * omega) * velocity(p, t)

    return jerk


def _size(one: Tone, order: int) -> Any:
    """Return the largest absolute value of a tone's derivative of this order, of (p)."""
    amplitude, times = one.amplitude, float(one.harmonic)

    @inline
    def size(p: Parameters) -> float:
        return abs(amplitude(p)) * (times * p.angular_frequency) ** order

    return size


HIGHEST_HARMONIC = max(t.harmonic for t in TONES)

upper_displacement = _sum(t.displacement for t in TONES)
"""(p, t): displacement X of the upper block [m], Eq. 1."""

upper_velocity = _sum(t.velocity for t in TONES)
"""(p, t): velocity V of the upper block [m/s], Eq. 2."""

upper_acceleration = _sum(t.acceleration for t in TONES)
"""(p, t): acceleration dV/dt of the upper block [m/s2], from Eq. 2."""

upper_jerk = _sum(_jerk(t) for t in TONES)
"""(p, t): second derivative of the velocity V of the upper block [m/s3], from Eq. 2."""


class Drive(NamedTuple):
    """A motion of the upper block: inline functions of (p, t)."""

    displacement: Callable[..., float]
    """X [m]."""

    velocity: Callable[..., float]
    """V [m/s]."""

    acceleration: Callable[..., float]
    """dV/dt [m/s2]."""

    jerk: Callable[..., float]
    """The second derivative of V [m/s3]."""


OSCILLATION = Drive(upper_displacement, upper_velocity, upper_acceleration, upper_jerk)
"""The periodic drive of the paper, which orbits have."""

largest_displacement, largest_speed, largest_acceleration = (
    _sum(_size(t, order) for t in TONES) for order in range(3)
)
"""(p): upper bounds of the size of X [m], V [m/s] and dV/dt [m/s2]: |X_m| omega^n."""


@inline
def period(p: Parameters) -> float:
    """Drive period 2 pi/omega [s]."""
    return 2.0 * math.pi / p.angular_frequency


_SECTION = ("section_begin", "begin_displacement", "begin_velocity", "pull_acceleration")

if TYPE_CHECKING:

    class PulledParameters(ParameterValues):
        """Parameters, followed by those of a section of a pull.

        The time [s] at which it begins, X [m] and V [m/s] there, and dV/dt [m/s2]. The largest
        speed is that of the whole pull: |X_m| omega.
        """

else:
    PulledParameters = namedtuple(
        "PulledParameters", (*ParameterValues._fields, *_SECTION), module=__name__
    )


@inline
def _pull_displacement(p: PulledParameters, t: float) -> float:
    since = t - p.section_begin
    return p.begin_displacement + (p.begin_velocity + 0.5 * p.pull_acceleration * since) * since


@inline
def _pull_velocity(p: PulledParameters, t: float) -> float:
    return p.begin_velocity + p.pull_acceleration * (t - p.section_begin)


@inline
def _pull_acceleration(p: PulledParameters, t: float) -> float:
    return p.pull_acceleration


@inline
def _pull_jerk(p: PulledParameters, t: float) -> float:
    return 0.0


PULL = Drive(_pull_displacement, _pull_velocity, _pull_acceleration, _pull_jerk)
"""A section of a pull, at a velocity that is linear in time; of `PulledParameters`."""
