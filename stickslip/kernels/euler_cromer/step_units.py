"""The units of fixed-step lanes, as in model/scaling.py but with the step as the unit of time.

The units of strain and length are chosen so that the elastic coefficient and the area are 1, with
which the model's equations need the fewest operations (docs/equations.md).
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.model import film, noise, solids
from stickslip.model.drive import HARMONIC_AMPLITUDES
from stickslip.model.laws import friction_law
from stickslip.model.scaling import (
    KEPT,
    LITERALS,
    Literals,
    Units,
    energy_unit,
    literals_of,
    make_reduction,
    make_units,
    make_values,
    thresholds_in,
)
from stickslip.model.state import State
from stickslip.parameters import Parameters, ParameterValues

_OF_THE_DRIVE = ("angular_frequency", "drive_amplitude")

_OWN_LITERALS: Literals = {
    **{name: value for name, value in LITERALS.items() if name not in _OF_THE_DRIVE},
    "elastic_coefficient": 1.0,
    "contact_area": 1.0,
    "film_thickness": 1.0,
    "noise_intensity": 0.0,  # `D_eff` below takes its place
}

_KEPT = (*_OF_THE_DRIVE, *(name for name in KEPT if name not in _OWN_LITERALS))
"""The remaining parameters; the angular frequency is the phase of the drive per step."""

_DERIVED = (
    *solids.Thresholds._fields,
    "D_eff",
    "least_phi",  # the noise of a single step, below which the typical path has no meaning
    "melted",  # the order parameter below which a film counts as melted
)

if TYPE_CHECKING:

    class StepParameters(ParameterValues):
        """The parameters of a lane: those that remain, then the derived ones."""

        D_eff: float
        least_phi: float
        solid: float
        melted: float
        soft: float
        hard: float
        weakest: float
        strongest: float

        def __getattr__(self, name: str) -> float: ...

else:
    StepParameters = namedtuple(
        "StepParameters", (*_KEPT, *_DERIVED, *HARMONIC_AMPLITUDES), module=__name__
    )


@inline
def step_units(p: Parameters, steps: int) -> Units:
    """Units of a lane with this many steps per period.

    Without elasticity the strain has no effect and its unit is arbitrary, so c, or the coefficient
    of a higher term, replaces a.
    """
    time = 2.0 * math.pi / p.angular_frequency / steps
    highest = p.quartic_coefficient
    for place, _ in film.RESTORING:
        highest = max(highest, p[place])
    a = p.elastic_coefficient if p.elastic_coefficient > 0.0 else highest
    energy = energy_unit(p, time)
    strain = math.copysign(math.sqrt(energy / a), p.drive_amplitude)
    length = p.contact_area * (energy / strain) * (time * time) / p.block_mass
    return make_units(p, time, length, p.film_thickness, strain)


@cache
def step_reduction(law: str) -> Callable[[Parameters, int, np.ndarray], None]:
    """Return the inline function (p, steps, row) that writes `StepParameters` into a row."""
    write, first = make_reduction(friction_law(law), _KEPT), len(_KEPT)
    behind = first + len(solids.Thresholds._fields)
    relaxation = _KEPT.index("strain_relaxation_time")
    harmonics = tuple(map(Parameters._fields.index, HARMONIC_AMPLITUDES))

    @inline
    def write_step_parameters(p: Parameters, steps: int, row: np.ndarray) -> None:
        units = step_units(p, steps)
        write(p, units, row)
        if p.elastic_coefficient == 0.0:
            row[relaxation] = 0.0  # so that the literal 1 for `a` causes no stress
        D_eff = noise.effective_intensity(p) * units.time
        t = thresholds_in(units, solids.thresholds(p))
        # A film that is always solid never melts.
        melted = solids.MELTED_PART * t.solid if t.solid > 0.0 else -1.0
        for i in range(len(t)):
            row[first + i] = t[i]
        row[behind], row[behind + 1], row[behind + 2] = D_eff, math.sqrt(D_eff), melted
        for i in range(len(harmonics)):
            row[behind + 3 + i] = p[harmonics[i]]

    return write_step_parameters


@cache
def step_values(
    index: float | None, *, higher: bool = True, one_tone: bool = False
) -> Callable[..., ParameterValues]:
    """Return the inline function that turns `StepParameters` into the parameters of the model.

    Arguments as in `model_values`.
    """
    known = literals_of(index, higher=higher, one_tone=one_tone)
    return make_values({**_OWN_LITERALS, **known})


@inline
def to_lane(units: Units, y: State) -> State:
    """State (x, v, phi) in the units of a lane."""
    return y[0] / units.length, y[1] / units.speed, y[2]


@inline
def from_lane(units: Units, y: State) -> State:
    """State (x, v, phi) in SI units."""
    return y[0] * units.length, y[1] * units.speed, y[2]
