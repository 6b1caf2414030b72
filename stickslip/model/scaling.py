"""The nondimensional model: time 1/omega, length |X_m|, mass M, energy density omega/delta.

The equations keep their form in other units (docs/equations.md). In these units X_m, omega, M,
delta and, with an adiabatic strain, h are 1. That leaves few parameters and no division by a
parameter, and tolerances apply to the components of the state directly. A drive with X_m < 0 is
the mirror image of the one with -X_m.

With harmonics the unit of length exceeds |X_m| (`drive.lengthened`), so that the drive stays within
the unit of speed, to which errors and distances refer.

The unit of a parameter in the registry determines its scaling. A method that needs other units, as
Euler-Cromer in lanes does, makes its own `Units` and uses everything else here.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_tuple_maker
from stickslip.model import drive, film, solids
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import PARAMETERS

Literals = Mapping[str, float]
"""Parameters with the same value at every point, in the units of the point. As compiled literals
they let the compiler remove superfluous operations."""

LITERALS: Literals = {
    "angular_frequency": 1.0,
    "block_mass": 1.0,
    "kinetic_coefficient": 1.0,
    "initial_displacement": 0.0,
    "initial_velocity": 0.0,
    "initial_order_parameter": 0.0,
    "thermal_coefficient": 0.5,  # 2 alpha is 1
}
"""The literals of all models in the units of `units_of`."""

HIGHEST = film.HIGHER_COEFFICIENTS
"""The coefficients of the free energy that are 0 for most films."""

OF_HARMONICS = ("drive_amplitude", *drive.HARMONIC_AMPLITUDES)
"""The parameters of a drive with harmonics. With a single tone the first is 1 and the others 0."""

KEPT = tuple(name for name in PARAMETERS if name not in LITERALS and name not in OF_HARMONICS)
"""The remaining parameters."""

DERIVED = solids.Thresholds._fields
"""Derived values, computed once per point: the thresholds between the phases of a film."""

if TYPE_CHECKING:

    class Reduced(ParameterValues):
        """`KEPT` parameters in the units of the point, then `DERIVED` and `OF_HARMONICS`."""

        def __getattr__(self, name: str) -> float: ...

else:
    Reduced = namedtuple("Reduced", (*KEPT, *DERIVED, *OF_HARMONICS), module=__name__)


class Units(NamedTuple):
    """The unit of each kind of quantity, in SI units.

    The units of motion, stress, force and strain change sign with X_m, so that an orbit under a
    mirrored drive is the same orbit.
    """

    number: float
    time: float
    frequency: float
    length: float
    speed: float
    mass: float
    force: float
    stiffness: float
    damping: float
    """Force divided by speed."""
    thickness: float
    """Length across the film."""
    strain: float
    stress: float
    modulus: float
    """Stress divided by strain."""
    viscosity: float
    """Stress divided by strain rate."""
    area: float
    """Force divided by stress."""
    relaxation: float
    """Strain divided by strain rate."""
    energy: float
    """Energy density of the film."""
    temperature: float


@inline
def energy_unit(p: Parameters, time: float) -> float:
    """Unit of energy density [J/m3] that makes delta 1, for a unit of time [s]."""
    return 1.0 / (p.kinetic_coefficient * time)


@inline
def make_units(p: Parameters, time: float, length: float, thickness: float, strain: float) -> Units:
    """Return all units for `p`, from these four; the unit of mass is M.

    Stress times strain is an energy density (Eqs. 12, 13); the unit of temperature makes 2 alpha
    equal to 1 (Eq. 15). The order parameter is never scaled, because laws may depend on it.
    """
    speed = length / time
    force = p.block_mass * speed / time
    energy, slope = energy_unit(p, time), 2.0 * p.thermal_coefficient
    stress = energy / strain
    # In a variable, because Numba compiles no conditional among so many keywords.
    temperature = energy / slope if slope > 0.0 else math.inf
    return Units(
        number=1.0,
        time=time,
        frequency=1.0 / time,
        length=length,
        speed=speed,
        mass=p.block_mass,
        force=force,
        stiffness=force / length,
        damping=force / speed,
        thickness=thickness,
        strain=strain,
        stress=stress,
        modulus=stress / strain,
        viscosity=stress * thickness / speed,
        area=force / stress,
        relaxation=strain * thickness / speed,
        energy=energy,
        temperature=temperature,
    )


_BY_UNIT: Mapping[str, str] = {
    "1": "number",
    "K": "temperature",
    "kg": "mass",
    "Pa": "stress",
    "Pa s": "viscosity",
    "J m-3": "energy",
    "N": "force",
    "N m-1": "stiffness",
    "N s m-1": "damping",
    "s-1": "frequency",
    "rad s-1": "frequency",
    "m s-1": "speed",
    "m": "length",
    "s": "time",
}
"""The field of `Units` that scales a parameter, by its unit in the registry."""

_BY_NAME: Mapping[str, str] = {
    "elastic_coefficient": "modulus",
    "film_thickness": "thickness",
    "strain_relaxation_time": "relaxation",
    "contact_area": "area",
}
"""The field of `Units` for parameters whose unit is ambiguous."""


class UnscaledError(LookupError):
    """The unit of a parameter has no declared scaling."""


def _unit_of(name: str) -> int:
    """Return the index in `Units` of the scale of a parameter; raises UnscaledError."""
    unit = PARAMETERS[name].units
    if name not in _BY_NAME and unit not in _BY_UNIT:
        raise UnscaledError(
            f"{name} is in {unit!r}, and nothing says how that is scaled: give it one of the units "
            f"{', '.join(map(repr, _BY_UNIT))}, or add its own to `Units` and `_BY_UNIT` of "
            "model/scaling.py, or declare it in `scaled` of its law of friction"
        )
    return Units._fields.index(_BY_NAME.get(name) or _BY_UNIT[unit])


class Scaling(NamedTuple):
    """The nondimensional form of a model."""

    units_of: Callable[[Parameters], Units]
    """(p), inline: the unit of each quantity."""

    literals: tuple[tuple[str, float], ...]
    """Further parameters with the same value at every point, as in `LITERALS`."""


@inline
def units_of(p: Parameters) -> Units:
    """Return the units in the adiabatic limit."""
    time = 1.0 / p.angular_frequency
    strain = math.copysign(1.0, p.drive_amplitude)
    return make_units(p, time, p.drive_amplitude, p.film_thickness, strain)


FOLLOWING = Scaling(units_of, (("film_thickness", 1.0),))
"""The scaling in the adiabatic limit, where the strain follows the relative velocity instantly."""


def make_reduction(
    law: FrictionLaw, names: tuple[str, ...]
) -> Callable[[Parameters, Units, np.ndarray], None]:
    """Return the inline function (p, units, row) that writes scaled parameters into a row.

    Raises UnscaledError for a parameter whose unit is in no table.
    """
    places = tuple(Parameters._fields.index(name) for name in names)
    # The law scales some parameters; the values written for them here are overwritten below.
    units = tuple(0 if name in law.scaled else _unit_of(name) for name in names)
    directed = tuple(PARAMETERS[name].directed for name in names)

    @inline
    def write_by_unit(p: Parameters, u: Units, row: np.ndarray) -> None:
        for slot in range(len(places)):
            unit = u[units[slot]]
            unit = unit if directed[slot] else abs(unit)
            row[slot] = p[places[slot]] / unit

    write: Any = write_by_unit
    for name, scaled in law.scaled.items():
        write = _with_law(write, names.index(name), scaled)
    return write


def _with_law(write: Any, slot: int, scaled: Callable[..., float]) -> Any:
    """Return `write` extended by the parameter in a slot, which a function of the law scales."""

    @inline
    def write_with_law(p: Parameters, u: Units, row: np.ndarray) -> None:
        write(p, u, row)
        row[slot] = scaled(p, abs(u.speed / u.thickness), abs(u.stress))

    return write_with_law


@inline
def thresholds_in(u: Units, t: solids.Thresholds) -> solids.Thresholds:
    """Return the thresholds between the phases of a film in these units."""
    return solids.Thresholds(
        solid=t.solid,
        soft=t.soft,
        hard=t.hard,
        weakest=t.weakest / u.energy,
        strongest=t.strongest / u.energy,
    )


def reduction(law: FrictionLaw, scaling: Scaling) -> Callable[[Parameters, np.ndarray], None]:
    """Return the inline function (p, row) that writes `Reduced` parameters into a row."""
    write, units_of = make_reduction(law, KEPT), scaling.units_of
    first = len(KEPT)
    harmonics = tuple(map(Parameters._fields.index, drive.HARMONIC_AMPLITUDES))

    @inline
    def write_reduced(p: Parameters, row: np.ndarray) -> None:
        units = units_of(p)
        write(p, units, row)
        t = thresholds_in(units, solids.thresholds(p))
        for i in range(len(t)):
            row[first + i] = t[i]
        # The amplitude is the unit of length, or a part of it that only the caller knows. (In the
        # loop above, it and the harmonics would change how the compiler groups divisions, and so
        # the last bits.)
        row[first + len(DERIVED)] = 1.0
        for i in range(len(harmonics)):
            row[first + len(DERIVED) + 1 + i] = p[harmonics[i]]

    return write_reduced


def literals_of(index: float | None, *, higher: bool, one_tone: bool) -> dict[str, float]:
    """Return the parameters that are compiled as literals for a family of fluids."""
    known = {} if index is None else {"rheological_index": index}
    absent = (() if higher else HIGHEST) + (drive.HARMONIC_AMPLITUDES if one_tone else ())
    return known | dict.fromkeys(absent, 0.0)


def make_values(literals: Literals) -> Callable[..., ParameterValues]:
    """Return the inline function (q) from scaled parameters to the parameters of the model.

    `q` has the parameters that are not `literals`.
    """
    values: dict[str, Any] = {name: f"q.{name}" for name in PARAMETERS}
    return make_tuple_maker(ParameterValues, "q", values | dict(literals), {})


@cache
def model_values(
    index: float | None,
    *,
    higher: bool = True,
    one_tone: bool = False,
    scaling: Scaling = FOLLOWING,
) -> Callable[..., ParameterValues]:
    """Return the inline function from `Reduced` parameters to the parameters of the model.

    The rheological index is the literal `index`, or if None, comes from the parameters. Without
    `higher` terms the coefficients beyond the paper's free energy are the literal 0; with
    `one_tone` so are the harmonics of the drive.
    """
    known = literals_of(index, higher=higher, one_tone=one_tone)
    own = {"drive_amplitude": 1.0} if one_tone else {}
    return make_values({**LITERALS, **dict(scaling.literals), **known, **own})
