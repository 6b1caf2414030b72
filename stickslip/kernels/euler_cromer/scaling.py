"""The units of the fixed-step lanes: those of model/scaling.py, and the step for the unit of time.

The units of strain, stress, force and of the order parameter are free as well, and make the
elastic coefficient and the area 1. No length of the step is left: an equation of the model takes
the fewest operations that way (docs/equations.md).
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_tuple_maker
from stickslip.measure.results import RecordUnits
from stickslip.model import film, noise, solids
from stickslip.model.models import model_of
from stickslip.model.scaling import (
    KEPT,
    LITERALS,
    Reduced,
    by_unit,
    literals_of,
    model_values,
    units_of,
)
from stickslip.model.state import State
from stickslip.options import Physics
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import PARAMETERS

_OWN_LITERALS: Mapping[str, float] = {
    **LITERALS,
    "elastic_coefficient": 1.0,
    "contact_area": 1.0,
    "film_thickness": 1.0,
    "noise_intensity": 0.0,  # `D_eff` below stands for it
}

_KEPT = tuple(name for name in KEPT if name not in _OWN_LITERALS)

_DERIVED = (
    "angle",  # phase of the drive in a step
    "D_eff",
    "least_phi",  # the noise of a single step, below which its typical path has no meaning
    "solid",  # order parameter from which a film counts as solid ...
    "melted",  # ... and up to which it counts as melted
    "soft",  # up to here a solid is soft ...
    "hard",  # ... and from here on hard
    "weakest",  # the soft solid exists above this B ...
    "strongest",  # ... and below this one
)

if TYPE_CHECKING:

    class StepParameters(ParameterValues):
        """What distinguishes a lane: the parameters that are left, then what is derived."""

        angle: float
        D_eff: float
        least_phi: float
        solid: float
        melted: float
        soft: float
        hard: float
        weakest: float
        strongest: float

else:
    StepParameters = namedtuple("StepParameters", (*_KEPT, *_DERIVED), module=__name__)


class StepUnits(NamedTuple):
    """What one unit of a lane is in SI units; all but `phi` change sign with X_m."""

    length: float
    speed: float
    phi: float
    stress: float
    force: float


class _Scales(NamedTuple):
    """Units of a lane, seen from the nondimensional model."""

    angle: float
    strain: float
    """The strain that is 1 there."""
    phi: float
    """The order parameter that is 1 there."""
    stress: float
    """angle^2 A: what makes a stress of the nondimensional model one of the lane."""


@inline
def _scales(q: Reduced, angle: float) -> _Scales:
    """Without elasticity the strain has no effect, and its unit is free: c or higher for a."""
    highest = q.quartic_coefficient
    for k, _ in film.restoring_terms(q):
        highest = max(highest, k)
    a = q.elastic_coefficient if q.elastic_coefficient > 0.0 else highest
    strain, stress = math.sqrt(angle * a), (angle * angle) * q.contact_area
    return _Scales(angle, strain, math.sqrt(stress * a / strain), stress)


@inline
def _relaxation_time(q: Reduced, s: _Scales) -> float:
    return q.strain_relaxation_time * s.strain / s.angle if q.elastic_coefficient > 0.0 else 0.0


_BY_UNIT: Mapping[str, str] = {
    "1": "q.{name}",
    "J m-3": "q.{name} * s.angle / s.phi**{phi_power}",
    "Pa": "q.{name} * s.stress",
    "Pa s": "q.{name} * s.stress / s.angle",
    "N m-1": "q.{name} * (s.angle * s.angle)",
    "N s m-1": "q.{name} * s.angle",
    "s-1": "q.{name} * s.angle",
    "m s-1": "q.{name} * s.angle",
    "m": "q.{name}",
    "s": "q.{name} / s.angle",
}
"""How a parameter of the nondimensional model is scaled, by its unit in the registry."""

_SPECIAL: Mapping[str, str] = {
    "temperature": "q.{name} * s.angle",
    "strain_relaxation_time": "relaxation_time(q, s)",
    "angle": "s.angle",
    "D_eff": "effective_intensity(v) * s.angle * (s.phi * s.phi)",
    "least_phi": "sqrt(effective_intensity(v) * s.angle * (s.phi * s.phi))",
    "solid": "s.phi * t.solid",
    "melted": "melted_part * s.phi * t.solid if t.solid > 0.0 else -1.0",  # solid: never melted
    "soft": "s.phi * t.soft",
    "hard": "s.phi * t.hard",
    "weakest": "q.weakest * s.angle",
    "strongest": "q.strongest * s.angle",
}


@cache
def step_reduction(physics: Physics) -> Callable[[Parameters, int], StepParameters]:
    """The inline function (p, steps) that gives the parameters of a lane with that many steps."""
    model = model_of(physics)
    law, reduced = model.equations.law, model.reduced
    values_of = model_values(None)
    by_law = {name: f"law_{name}(v, 1.0 / s.angle, 1.0 / s.stress)" for name in law.scaled}

    def expression(name: str) -> str:
        known = by_law.get(name) or _SPECIAL.get(name)
        if known is None:
            known = by_unit(name, _BY_UNIT)
            return known.format(name=name, phi_power=PARAMETERS[name].phi_power)
        return known.format(name=name)

    names: dict[str, Any] = {f"law_{name}": function for name, function in law.scaled.items()}
    names |= {"effective_intensity": noise.effective_intensity, "sqrt": math.sqrt}
    names |= {"relaxation_time": _relaxation_time, "melted_part": solids.MELTED_PART}
    fields = {name: expression(name) for name in (*_KEPT, *_DERIVED)}
    make = make_tuple_maker(StepParameters, "q, v, s, t", fields, names)

    @inline
    def step_parameters(p: Parameters, steps: int) -> StepParameters:
        q = reduced(p)
        scales = _scales(q, 2.0 * math.pi / steps)
        return make(q, values_of(q), scales, solids.thresholds(p))

    return step_parameters


@cache
def step_units_of(physics: Physics) -> Callable[[Parameters, int], StepUnits]:
    """The inline function (p, steps) that gives the units of a lane with that many steps."""
    reduced = model_of(physics).reduced

    @inline
    def step_units(p: Parameters, steps: int) -> StepUnits:
        units, angle = units_of(p), 2.0 * math.pi / steps
        s = _scales(reduced(p), angle)
        return StepUnits(
            units.length,
            units.speed / angle,
            1.0 / s.phi,
            units.stress / s.stress,
            units.force / (angle * angle),
        )

    return step_units


@inline
def record_units(units: StepUnits, steps: int) -> RecordUnits:
    """The units of a record that is kept in a lane, with so many steps a period."""
    return RecordUnits(units.length, units.stress, units.force, units.phi, 2.0 / steps)


@cache
def step_values(index: float | None, *, sextic: bool = True) -> Callable[..., ParameterValues]:
    """The inline function that gives the parameters of a lane as the model's functions take them.

    Arguments as of `model_values`.
    """
    values: dict[str, Any] = {name: f"s.{name}" for name in _KEPT} | dict(_OWN_LITERALS)
    values["angular_frequency"] = "s.angle"
    values |= literals_of(index, sextic=sextic)
    return make_tuple_maker(ParameterValues, "s", values, {})


@inline
def to_lane(units: StepUnits, y: State) -> State:
    """The state (x, v, phi) in the units of a lane."""
    return y[0] / units.length, y[1] / units.speed, y[2] / units.phi


@inline
def from_lane(units: StepUnits, y: State) -> State:
    """The state (x, v, phi) in SI units."""
    return y[0] * units.length, y[1] * units.speed, y[2] * units.phi
