"""The motion of the upper block: a sum of tones, of which the paper has one (Eqs. 1 and 2).

Points with a single tone, as in the paper, use separate equations (`UPPER`), because further sines
with amplitude 0 would cost time. In a trajectory the block may instead be pulled, at a velocity
that is piecewise linear.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.options import COSINE, HARMONICS, PULL
from stickslip.parameters import Parameters, ParameterValues


class Tone(NamedTuple):
    """A cosine of the drive, made by `tone`."""

    harmonic: int
    """The frequency, in units of omega."""

    part: str | None
    """The parameter of the amplitude over X_m, negative for the opposite phase. None for the first
    tone, whose amplitude is X_m."""


def tone(harmonic: int, part: str | None = None) -> Tone:
    """Return the tone of a harmonic; `part` is the parameter of its amplitude over X_m.

    Raises ValueError for an even harmonic. The drive must change sign after half a period, because
    the search for orbits and the lanes rely on that symmetry.
    """
    if harmonic % 2 == 0:
        raise ValueError(
            f"tone {harmonic} of the drive: an even harmonic breaks the symmetry of half periods "
            "(x, v, phi, t) -> (-x, -v, phi, t + pi/omega); only odd ones can be computed"
        )
    return Tone(harmonic, part)


TONES: tuple[Tone, ...] = (
    tone(1),
    tone(3, "third_harmonic"),
    tone(5, "fifth_harmonic"),
)
"""The tones of the drive, beginning with the paper's. Another tone needs only its parameter in the
registry, with unit 1 and default 0."""

HARMONIC_AMPLITUDES = tuple(tone.part for tone in TONES if tone.part)
"""The parameters that are 0 if the drive has a single tone."""

_HARMONICS = tuple((Parameters._fields.index(t.part), float(t.harmonic)) for t in TONES if t.part)


# The terms of a tone, as functions of the parameters, its amplitude A [m] and harmonic, and t [s].


@inline
def _displacement(p: Parameters, A: float, harmonic: float, t: float) -> float:
    return A * sine_and_cosine(harmonic * p.angular_frequency * t)[1]


@inline
def _velocity(p: Parameters, A: float, harmonic: float, t: float) -> float:
    omega = harmonic * p.angular_frequency
    return -A * omega * sine_and_cosine(omega * t)[0]


@inline
def _acceleration(p: Parameters, A: float, harmonic: float, t: float) -> float:
    omega = harmonic * p.angular_frequency
    return -A * (omega * omega) * sine_and_cosine(omega * t)[1]


@inline
def _jerk(p: Parameters, A: float, harmonic: float, t: float) -> float:
    omega = harmonic * p.angular_frequency
    return -(omega * omega) * _velocity(p, A, harmonic, t)


@inline
def _amplitude(p: Parameters) -> float:
    return p.drive_amplitude


def _amplitude_of(part: str | None) -> Any:
    """Return the inline function (p) of the amplitude of a tone [m]."""
    if part is None:
        return _amplitude
    place = Parameters._fields.index(part)

    @inline
    def amplitude(p: Parameters) -> float:
        return p.drive_amplitude * p[place]

    return amplitude


def _sum(term: Any, tones: tuple[Tone, ...]) -> Any:
    """Return the inline function (p, ...) of the sum of a term over tones."""
    *before, last = tones
    amplitude, harmonic = _amplitude_of(last.part), float(last.harmonic)

    @inline
    def alone(p: Parameters, *arguments: Any) -> float:
        return term(p, amplitude(p), harmonic, *arguments)

    if not before:
        return alone
    others = _sum(term, tuple(before))

    @inline
    def together(p: Parameters, *arguments: Any) -> float:
        return others(p, *arguments) + alone(p, *arguments)

    return together


class Upper(NamedTuple):
    """The motion of the upper block, as inline functions of (p, t)."""

    displacement: Callable[..., float]
    """X [m], Eq. 1."""

    velocity: Callable[..., float]
    """V [m/s], Eq. 2."""

    acceleration: Callable[..., float]
    """dV/dt [m/s2]."""

    jerk: Callable[..., float]
    """The second derivative of V [m/s3]."""


TONES_OF: Mapping[str, tuple[Tone, ...]] = MappingProxyType({COSINE: TONES[:1], HARMONICS: TONES})
"""The tones of a periodic drive, by the name of the drive."""


def upper_of(tones: tuple[Tone, ...]) -> Upper:
    """Return the motion of the upper block as a sum of tones."""
    return Upper(*(_sum(term, tones) for term in (_displacement, _velocity, _acceleration, _jerk)))


_SECTION = ("section_begin", "begin_displacement", "begin_velocity", "pull_acceleration")

if TYPE_CHECKING:

    class PulledParameters(ParameterValues):
        """Parameters, followed by four numbers of a section of a pull.

        These are the time [s] at which the section begins, X [m] and V [m/s] at this time, and
        dV/dt [m/s2]. |X_m| omega is the largest speed of the whole pull.
        """

        def __getattr__(self, name: str) -> float: ...

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


UPPER: Mapping[str, Upper] = MappingProxyType(
    {name: upper_of(tones) for name, tones in TONES_OF.items()}
    | {PULL: Upper(_pull_displacement, _pull_velocity, _pull_acceleration, _pull_jerk)}
)
"""The motions of the upper block, by the names in `options.Physics.drive`."""

upper_displacement, upper_velocity, upper_acceleration, upper_jerk = UPPER[HARMONICS]
"""(p, t): the motion of the upper block at any point."""


# Terms of a tone in bounds, which are sums over the tones.


@inline
def _largest_displacement(p: Parameters, A: float, harmonic: float) -> float:
    return abs(A)


@inline
def _largest_speed(p: Parameters, A: float, harmonic: float) -> float:
    return abs(A) * (harmonic * p.angular_frequency)


@inline
def _largest_acceleration(p: Parameters, A: float, harmonic: float) -> float:
    return abs(A) * (harmonic * p.angular_frequency) ** 2


@inline
def _acceleration_speed(p: Parameters, A: float, harmonic: float) -> float:
    return harmonic * _largest_speed(p, A, harmonic)


@inline
def _half_way(p: Parameters, A: float, harmonic: float) -> float:
    return harmonic * abs(A)


@inline
def _full_force(p: Parameters, A: float, harmonic: float) -> float:
    omega = harmonic * p.angular_frequency
    inertia = p.block_mass * (omega * omega)
    return max(2.0 * p.spring_stiffness, inertia) * abs(A)


largest_displacement, largest_speed, largest_acceleration = (
    _sum(term, TONES) for term in (_largest_displacement, _largest_speed, _largest_acceleration)
)
"""(p): upper bounds of |X| [m], |V| [m/s] and |dV/dt| [m/s2]."""

acceleration_speed = _sum(_acceleration_speed, TONES)
"""(p): `largest_acceleration` over omega, a speed [m/s]."""

half_way = _sum(_half_way, TONES)
"""(p): upper bound of half the distance that the upper block covers in half a period [m]."""

full_force = _sum(_full_force, TONES)
"""(p): the force that would move springs or inertia with the drive [N], max(2K, M omega^2)|X_m|,
summed over the tones. A locked block needs the difference of the two."""


def tone_amplitudes(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the frequencies (m,) over omega and the amplitudes (n, m) [m] of the tones.

    `points` is an array (n, parameters).
    """
    p = ParameterValues(*points.T)
    amplitudes = [_amplitude_of(tone.part).py_func(p) for tone in TONES]
    return np.array([float(tone.harmonic) for tone in TONES]), np.array(amplitudes).T


def lengthened(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (n, parameters) with the unit of length in place of X_m.

    The unit is X_m for a single tone. With harmonics it is longer, so that the drive does not
    exceed the unit of speed. Points without harmonics are returned unchanged.
    """
    places = [place for place, _ in _HARMONICS]
    if not np.any(points[:, places]):
        return points
    longer = points.copy()
    bound = 1.0 + sum(times * np.abs(points[:, place]) for place, times in _HARMONICS)
    longer[:, Parameters._fields.index("drive_amplitude")] *= bound
    return longer


def full_forces(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `full_force` [N] of points (n, parameters), (n,)."""
    p, (harmonics, amplitudes) = ParameterValues(*points.T), tone_amplitudes(points)
    omega = np.outer(p.angular_frequency, harmonics)
    inertia = np.asarray(p.block_mass)[:, None] * omega**2
    stiffness = np.maximum(2.0 * np.asarray(p.spring_stiffness)[:, None], inertia)
    return np.asarray((stiffness * np.abs(amplitudes)).sum(axis=1))


@inline
def highest_harmonic(p: Parameters) -> float:
    """The highest frequency of the drive in units of omega."""
    highest = 1.0
    for place, times in _HARMONICS:
        if p[place] != 0.0:
            highest = max(highest, times)
    return highest


@inline
def period(p: Parameters) -> float:
    """Drive period 2 pi/omega [s]."""
    return 2.0 * math.pi / p.angular_frequency
