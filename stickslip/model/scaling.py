"""The nondimensional model: time 1/omega, length |X_m|, mass M, and the film's in 1/delta.

The equations keep their form under scalings of their units (docs/equations.md). Together these turn
X_m, omega, M, h and delta into 1 (h where the strain follows at once), which leaves few parameters,
no division by a parameter, and a state whose components are the ones that tolerances refer to. A
drive with X_m < 0 is the mirror image of its positive twin.

A parameter is scaled by its unit in the registry. A method that wants other units, as Euler-Cromer
in lanes does, makes `Units` of its own; everything else here serves it as well.
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
from stickslip.model import film, solids
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import PARAMETERS

Literals = Mapping[str, float]
"""Parameters that have one value in units of their own. They are written out as literals, so that
the compiler removes what they make superfluous."""

LITERALS: Literals = {
    "angular_frequency": 1.0,
    "drive_amplitude": 1.0,
    "block_mass": 1.0,
    "kinetic_coefficient": 1.0,
    "initial_displacement": 0.0,
    "initial_velocity": 0.0,
    "initial_order_parameter": 0.0,
    "thermal_coefficient": 0.5,  # 2 alpha is 1
}
"""Those of every model in the units of `units_of`."""

HIGHEST = film.HIGHER_COEFFICIENTS
"""The coefficients of the free energy that most films do without."""

KEPT = tuple(name for name in PARAMETERS if name not in LITERALS)
"""The parameters that are left."""

DERIVED = solids.Thresholds._fields
"""What is worth computing once: the thresholds of the phases of a film."""

if TYPE_CHECKING:

    class Reduced(ParameterValues):
        """The parameters that are left, in units of the point's own, and behind them `DERIVED`."""

else:
    Reduced = namedtuple("Reduced", (*KEPT, *DERIVED), module=__name__)


class Units(NamedTuple):
    """What one unit of each kind of quantity is in SI units.

    Those of the motion, of stress, force and strain, change sign with X_m; so an orbit under a
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
    """A force over a speed."""
    thickness: float
    """A length of the film."""
    strain: float
    stress: float
    modulus: float
    """A stress over a strain."""
    viscosity: float
    """A stress over a rate of strain."""
    area: float
    """A force over a stress."""
    relaxation: float
    """A strain over a rate of strain."""
    energy: float
    """An energy density of the film."""
    temperature: float


@inline
def energy_unit(p: Parameters, time: float) -> float:
    """The energy density of the film [J/m3] that is 1 where this time [s] is: delta is 1 too."""
    return 1.0 / (p.kinetic_coefficient * time)


@inline
def make_units(p: Parameters, time: float, length: float, thickness: float, strain: float) -> Units:
    """The units for `p` that follow from these; the mass is M.

    A stress makes an energy with the strain (Eqs. 12, 13), a temperature by itself (Eq. 15), so
    that 2 alpha is 1. The order parameter is never scaled: laws may depend on it.
    """
    speed = length / time
    force = p.block_mass * speed / time
    energy, slope = energy_unit(p, time), 2.0 * p.thermal_coefficient
    stress = energy / strain
    # Numba takes no choice among so many keywords.
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
"""Which of `Units` a parameter is scaled by, by its unit in the registry."""

_BY_NAME: Mapping[str, str] = {
    "elastic_coefficient": "modulus",
    "film_thickness": "thickness",
    "strain_relaxation_time": "relaxation",
    "contact_area": "area",
}
"""The same for parameters whose unit alone does not tell."""


class UnscaledError(LookupError):
    """A parameter in a unit of which nothing says how it is scaled."""


def _unit_of(name: str) -> int:
    """The place in `Units` of what a parameter is scaled by; raises UnscaledError."""
    unit = PARAMETERS[name].units
    if name not in _BY_NAME and unit not in _BY_UNIT:
        raise UnscaledError(
            f"{name} is in {unit!r}, and nothing says how that is scaled: give it one of the units "
            f"{', '.join(map(repr, _BY_UNIT))}, or add its own to `Units` and `_BY_UNIT` of "
            "model/scaling.py, or `scaled` to the law of friction that has it"
        )
    return Units._fields.index(_BY_NAME.get(name) or _BY_UNIT[unit])


class Scaling(NamedTuple):
    """The nondimensional form of a model."""

    units_of: Callable[[Parameters], Units]
    """Inline: what one unit of each quantity is."""

    literals: tuple[tuple[str, float], ...]
    """Parameters besides `LITERALS` that have one value in it."""


@inline
def units_of(p: Parameters) -> Units:
    """The units in the adiabatic limit."""
    time = 1.0 / p.angular_frequency
    strain = math.copysign(1.0, p.drive_amplitude)
    return make_units(p, time, p.drive_amplitude, p.film_thickness, strain)


FOLLOWING = Scaling(units_of, (("film_thickness", 1.0),))
"""Where the strain follows the relative velocity at once."""


def make_reduction(
    law: FrictionLaw, names: tuple[str, ...]
) -> Callable[[Parameters, Units, np.ndarray], None]:
    """The inline function (p, units, row) that writes these parameters in their units into a row.

    Raises UnscaledError for a parameter whose unit is in no table.
    """
    places = tuple(Parameters._fields.index(name) for name in names)
    # The unit of what the law scales does not tell.
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
    """The same, but the parameter in this slot is scaled by a function of its law."""

    @inline
    def write_with_law(p: Parameters, u: Units, row: np.ndarray) -> None:
        write(p, u, row)
        row[slot] = scaled(p, abs(u.speed / u.thickness), abs(u.stress))

    return write_with_law


@inline
def thresholds_in(u: Units, t: solids.Thresholds) -> solids.Thresholds:
    """The thresholds of the phases of a film in these units."""
    return solids.Thresholds(
        solid=t.solid,
        soft=t.soft,
        hard=t.hard,
        weakest=t.weakest / u.energy,
        strongest=t.strongest / u.energy,
    )


def reduction(law: FrictionLaw, scaling: Scaling) -> Callable[[Parameters, np.ndarray], None]:
    """The inline function (p, row) that writes `Reduced` parameters into a row."""
    write, units_of = make_reduction(law, KEPT), scaling.units_of
    first = len(KEPT)

    @inline
    def write_reduced(p: Parameters, row: np.ndarray) -> None:
        units = units_of(p)
        write(p, units, row)
        t = thresholds_in(units, solids.thresholds(p))
        for i in range(len(t)):
            row[first + i] = t[i]

    return write_reduced


def literals_of(index: float | None, *, higher: bool) -> dict[str, float]:
    """The parameters that are written out as literals for a family of fluids."""
    known = {} if index is None else {"rheological_index": index}
    return known if higher else known | dict.fromkeys(HIGHEST, 0.0)


def make_values(literals: Literals) -> Callable[..., ParameterValues]:
    """The inline function (q) that gives parameters in units of their own as the model takes them.

    `q` has those that are not among the `literals`.
    """
    values: dict[str, Any] = {name: f"q.{name}" for name in PARAMETERS}
    return make_tuple_maker(ParameterValues, "q", values | dict(literals), {})


@cache
def model_values(
    index: float | None, *, higher: bool = True, scaling: Scaling = FOLLOWING
) -> Callable[..., ParameterValues]:
    """The inline function that gives `Reduced` parameters as the model's functions take them.

    With the rheological index as a literal, or that of the parameters for None; with the highest
    coefficients of the free energy only where there are `higher` ones than the paper's.
    """
    literals = {**LITERALS, **dict(scaling.literals), **literals_of(index, higher=higher)}
    return make_values(literals)
