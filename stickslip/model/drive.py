"""The motion of the upper block: a sum of tones, of which Eqs. 1 and 2 have one.

Points with a single tone, those of the paper, have equations of their own (`UPPER`): further sines
that are multiplied by 0 would cost time. A trajectory may have another motion: pulled at a velocity
that is linear in pieces.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Iterable, Mapping
from functools import reduce
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.options import COSINE, HARMONICS, PULL
from stickslip.parameters import Parameters, ParameterValues


class Tone(NamedTuple):
    """A cosine of the drive: inline functions made by `tone`."""

    harmonic: int
    """Its frequency in units of the drive's."""

    part: str | None
    """The parameter of its amplitude, over X_m; None for the first tone."""

    amplitude: Callable[..., float]
    """(p): its amplitude [m], negative for the opposite phase."""

    displacement: Callable[..., float]
    """(p, t) [m]."""

    velocity: Callable[..., float]
    """(p, t) [m/s]."""

    acceleration: Callable[..., float]
    """(p, t) [m/s2]."""


def tone(harmonic: int, part: str | None = None) -> Tone:
    """Return the tone of a harmonic; `part` is the parameter of its amplitude, over X_m.

    Without one the amplitude is X_m. Raises ValueError for an even harmonic: the drive must change
    sign after half a period, since the search for orbits and the lanes rely on that symmetry.
    """
    if harmonic % 2 == 0:
        raise ValueError(
            f"tone {harmonic} of the drive: an even harmonic breaks the symmetry of half periods "
            "(x, v, phi, t) -> (-x, -v, phi, t + pi/omega); only odd ones can be computed"
        )
    times = float(harmonic)
    amplitude: Any = _amplitude if part is None else _part_of_amplitude(part)

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

    return Tone(harmonic, part, amplitude, displacement, velocity, acceleration)


@inline
def _amplitude(p: Parameters) -> float:
    return p.drive_amplitude


def _part_of_amplitude(name: str) -> Any:
    place = Parameters._fields.index(name)

    @inline
    def amplitude(p: Parameters) -> float:
        return p.drive_amplitude * p[place]

    return amplitude


TONES: tuple[Tone, ...] = (
    tone(1),
    tone(3, "third_harmonic"),
    tone(5, "fifth_harmonic"),
)
"""The tones of the drive, that of the paper first. A further one needs only its parameter in the
registry, of unit 1 and 0 by default."""

HARMONIC_AMPLITUDES = tuple(tone.part for tone in TONES if tone.part)
"""The parameters that are 0 where there is no other tone than the first."""

_HARMONICS = tuple((Parameters._fields.index(t.part), float(t.harmonic)) for t in TONES if t.part)


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
"""The tones that a drive may have, by its name."""


def _upper(tones: tuple[Tone, ...]) -> Upper:
    return Upper(
        displacement=_sum(t.displacement for t in tones),
        velocity=_sum(t.velocity for t in tones),
        acceleration=_sum(t.acceleration for t in tones),
        jerk=_sum(_jerk(t) for t in tones),
    )


_SECTION = ("section_begin", "begin_displacement", "begin_velocity", "pull_acceleration")

if TYPE_CHECKING:

    class PulledParameters(ParameterValues):
        """Parameters, followed by those of a section of a pull.

        The time [s] at which it begins, X [m] and V [m/s] there, and dV/dt [m/s2]. The largest
        speed is that of the whole pull: |X_m| omega.
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
    {name: _upper(tones) for name, tones in TONES_OF.items()}
    | {PULL: Upper(_pull_displacement, _pull_velocity, _pull_acceleration, _pull_jerk)}
)
"""The motions of the upper block by name, `options.Physics.drive`."""

upper_displacement, upper_velocity, upper_acceleration, upper_jerk = UPPER[HARMONICS]
"""(p, t): those of any point."""


def _size(one: Tone, order: int) -> Any:
    """Return the largest absolute value of a tone's derivative of this order, of (p)."""
    amplitude, times = one.amplitude, float(one.harmonic)

    @inline
    def size(p: Parameters) -> float:
        return abs(amplitude(p)) * (times * p.angular_frequency) ** order

    return size


def _scaled_size(one: Tone, order: int, power: int) -> Any:
    """Return `_size` times this power of the harmonic."""
    size, factor = _size(one, order), float(one.harmonic**power)

    @inline
    def scaled_size(p: Parameters) -> float:
        return factor * size(p)

    return scaled_size


largest_displacement, largest_speed, largest_acceleration = (
    _sum(_size(t, order) for t in TONES) for order in range(3)
)
"""(p): upper bounds of the size of X [m], V [m/s] and dV/dt [m/s2]: |X_m| omega^n, summed over the
tones."""

acceleration_speed = _sum(_scaled_size(t, 1, 1) for t in TONES)
"""(p): the speed [m/s] that times omega is `largest_acceleration`."""

half_way = _sum(_scaled_size(t, 0, 1) for t in TONES)
"""(p): upper bound of half the way of the upper block in half a period [m]."""


def _full_force(one: Tone) -> Any:
    amplitude, times = one.amplitude, float(one.harmonic)

    @inline
    def force(p: Parameters) -> float:
        omega = times * p.angular_frequency
        inertia = p.block_mass * (omega * omega)
        return max(2.0 * p.spring_stiffness, inertia) * abs(amplitude(p))

    return force


full_force = _sum(_full_force(t) for t in TONES)
"""(p): force that moves springs or inertia with the drive [N], max(2K, M omega^2)|X_m|, summed over
the tones. A locked block needs the difference of the two."""


def amplitudes_of(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the frequencies (m,) of the tones, over omega, and the amplitudes (n, m) [m].

    `points` (n, parameters).
    """
    p = ParameterValues(*points.T)
    amplitudes = [tone.amplitude.py_func(p) for tone in TONES]  # type: ignore[attr-defined]
    return np.array([float(tone.harmonic) for tone in TONES]), np.array(amplitudes).T


def lengthened(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (n, parameters) with the unit of length in place of X_m.

    That is X_m for a single tone, and with harmonics so long that the drive does not exceed the
    unit of speed. Points without harmonics come back as they are.
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
    p, (harmonics, amplitudes) = ParameterValues(*points.T), amplitudes_of(points)
    omega = np.outer(p.angular_frequency, harmonics)
    inertia = np.asarray(p.block_mass)[:, None] * omega**2
    stiffness = np.maximum(2.0 * np.asarray(p.spring_stiffness)[:, None], inertia)
    return np.asarray((stiffness * np.abs(amplitudes)).sum(axis=1))


@inline
def relative_speed_bound(p: Parameters) -> float:
    """`largest_speed` in units of |X_m| omega: 1 + 3 |a_3| + 5 |a_5|."""
    bound = 1.0
    for place, times in _HARMONICS:
        bound += times * abs(p[place])
    return bound


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
