"""The nondimensional model: time 1/omega, length |X_m|, mass M, and the film's in 1/delta.

The equations keep their form under scalings of their units (docs/equations.md). Together these turn
X_m, omega, M, h and delta into 1 (h where the strain follows at once), which leaves few parameters,
no division by a parameter, and a state whose components are the ones that tolerances refer to. A
drive with X_m < 0 is the mirror image of its positive twin.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_tuple_maker
from stickslip.model import film, solids
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import PARAMETERS

LITERALS: Mapping[str, float] = {
    "angular_frequency": 1.0,
    "drive_amplitude": 1.0,
    "block_mass": 1.0,
    "kinetic_coefficient": 1.0,
    "initial_displacement": 0.0,
    "initial_velocity": 0.0,
    "initial_order_parameter": 0.0,
    # The temperature counts as 2 alpha (T - T_c), so that `film.heating` returns it unchanged.
    "thermal_coefficient": 0.5,
    "critical_temperature": 0.0,
}
"""Parameters that have one value in the nondimensional model. They are written out as literals, so
that the compiler removes what they make superfluous."""

HIGHEST = film.HIGHER_COEFFICIENTS
"""The coefficients of the free energy that most films do without."""

KEPT = tuple(name for name in PARAMETERS if name not in LITERALS)
"""The parameters that are left."""

DERIVED = solids.Thresholds._fields
"""What is worth computing once: the thresholds of the phases of a film."""

if TYPE_CHECKING:

    class Reduced(ParameterValues):
        """The parameters that are left, in units of `units_of`; temperature is the heating.

        Behind them `DERIVED`.
        """

else:
    Reduced = namedtuple("Reduced", (*KEPT, *DERIVED), module=__name__)


class Units(NamedTuple):
    """What one unit of the reduced model is; all but `time` change sign with X_m."""

    length: float
    speed: float
    stress: float
    force: float
    time: float
    strain: float


class Scales(NamedTuple):
    """The combinations of parameters by which the others are scaled."""

    omega: float
    length: float
    speed: float
    rate: float
    """Strain rate [1/s] that is 1."""
    energy: float
    """delta/omega [m3/J]: what makes an energy density of the film a number."""
    stress: float
    """What makes a stress a number [1/Pa]."""
    strain: float
    """The strain that is 1."""
    thickness: float
    """The film's, in units of its own."""
    relaxation: float
    """What makes the relaxation time of the strain a number [1/s]."""
    inertia: float
    """M omega^2 [N/m]."""


@inline
def units_of(p: Parameters) -> Units:
    """Units of length [m], speed [m/s], stress [Pa], force [N], time [s] and strain for `p`.

    In the adiabatic limit, as all of this file but `reduction` and `model_values`.
    """
    X_m, omega = p.drive_amplitude, p.angular_frequency
    sign = math.copysign(1.0, X_m)
    return Units(
        X_m,
        X_m * omega,
        sign * (omega / p.kinetic_coefficient),
        p.block_mass * (omega * omega) * X_m,
        1.0 / omega,
        sign,
    )


@inline
def scales_of(p: Parameters) -> Scales:
    """The scales of `p`, in the adiabatic limit."""
    omega, length = p.angular_frequency, abs(p.drive_amplitude)
    rate, energy = length / p.film_thickness * omega, p.kinetic_coefficient / omega
    return Scales(
        omega=omega,
        length=length,
        speed=length * omega,
        rate=rate,
        energy=energy,
        stress=energy,
        strain=1.0,
        thickness=1.0,
        relaxation=rate,  # the strain is a length over h
        inertia=p.block_mass * (omega * omega),
    )


_BY_UNIT: Mapping[str, str] = {
    "1": "p.{name}",
    "Pa": "p.{name} * s.stress",
    "Pa s": "p.{name} * s.stress * s.rate",
    "J m-3": "p.{name} * s.energy",
    "N m-1": "p.{name} / s.inertia",
    "N s m-1": "p.{name} / s.inertia * s.omega",
    "s-1": "p.{name} / s.omega",
    "m s-1": "p.{name} / s.speed",
    "m": "p.{name} / s.length",
    "s": "p.{name} * s.omega",
}
"""How a parameter is scaled, by its unit in the registry."""

_SPECIAL: Mapping[str, str] = {
    "temperature": "heating(p) * s.energy",
    "elastic_coefficient": "p.{name} * s.energy * (s.strain * s.strain)",
    "film_thickness": "s.thickness",
    "strain_relaxation_time": "p.{name} * s.relaxation",
    "contact_area": "p.{name} / s.length / s.inertia / s.stress",  # a force over a stress
}


class UnscaledError(LookupError):
    """A parameter in a unit of which nothing says how it is scaled."""


def by_unit(name: str, table: Mapping[str, str]) -> str:
    """How a parameter is scaled by its unit in the registry; raises UnscaledError."""
    unit = PARAMETERS[name].units
    if unit not in table:
        raise UnscaledError(
            f"{name} is in {unit!r}, and nothing says how that is scaled: give it one of the units "
            f"{', '.join(map(repr, table))}, or add its own to `_BY_UNIT` of model/scaling.py and "
            "of kernels/euler_cromer/scaling.py, or `scaled` to the law of friction that has it"
        )
    return table[unit]


class Scaling(NamedTuple):
    """The nondimensional form of a model."""

    units_of: Callable[[Parameters], Units]
    """Inline: what one unit of the reduced model is."""

    scales_of: Callable[[Parameters], Scales]
    """Inline: by what the parameters are scaled."""

    literals: tuple[tuple[str, float], ...]
    """Parameters besides `LITERALS` that have one value in it."""


FOLLOWING = Scaling(units_of, scales_of, (("film_thickness", 1.0),))
"""Where the strain follows the relative velocity at once."""


def reduction(law: FrictionLaw, scaling: Scaling) -> Callable[[Parameters], Reduced]:
    """The inline function that gives the parameters `p` in the units of a scaling.

    Raises UnscaledError for a parameter whose unit is in no table.
    """
    scales_of = scaling.scales_of
    names: dict[str, Any] = {f"law_{name}": function for name, function in law.scaled.items()}
    by_law = {name: f"law_{name}(p, s.rate, 1.0 / s.stress)" for name in law.scaled}
    values = {
        name: by_law.get(name) or _SPECIAL.get(name) or by_unit(name, _BY_UNIT) for name in KEPT
    }
    written = {name: expression.format(name=name) for name, expression in values.items()}
    written |= {name: f"t.{name}" for name in DERIVED}
    written |= {name: f"t.{name} * s.energy" for name in ("weakest", "strongest")}
    make = make_tuple_maker(Reduced, "p, s, t", written, names | {"heating": film.heating})

    @inline
    def reduced(p: Parameters) -> Reduced:
        return make(p, scales_of(p), solids.thresholds(p))

    return reduced


def literals_of(index: float | None, *, sextic: bool) -> dict[str, float]:
    """The parameters that are written out as literals for a family of fluids."""
    known = {} if index is None else {"rheological_index": index}
    return known if sextic else known | dict.fromkeys(HIGHEST, 0.0)


@cache
def model_values(
    index: float | None, *, sextic: bool = True, scaling: Scaling = FOLLOWING
) -> Callable[..., ParameterValues]:
    """The inline function that gives reduced parameters as the model's functions take them.

    With the rheological index as a literal, or that of the parameters for None; with the highest
    coefficients of the free energy only where it is `sextic`.
    """
    values: dict[str, Any] = {name: f"q.{name}" for name in KEPT} | dict(LITERALS)
    values |= dict(scaling.literals) | literals_of(index, sextic=sextic)
    return make_tuple_maker(ParameterValues, "q", values, {})
