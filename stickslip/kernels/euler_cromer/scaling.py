"""The units of the fixed-step lanes: those of model/units.py, and the step for the unit of time.

The units of strain, stress, force and of the order parameter are free as well, and make the
elastic coefficient and the area 1. What is left are eight parameters, and no length of the step:
an equation of the model takes the fewest operations that way (docs/equations.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.model import film, friction, noise
from stickslip.model.rhs import State
from stickslip.model.scaling import Reduced, reduced, units_of
from stickslip.parameters import Parameters, ParameterValues


class StepUnits(NamedTuple):
    """What one unit of a lane is in SI units; all but `phi` change sign with X_m."""

    length: float
    speed: float
    phi: float
    stress: float
    force: float


class StepParameters(NamedTuple):
    """What distinguishes a lane: symbols as in `Reduced`, then what is derived from them."""

    heating: float
    k: float
    K: float
    tau: float
    b: float
    c: float
    D_eff: float
    gamma: float
    least_phi: float
    """The noise of a single step, below which its typical path has no meaning."""
    angle: float
    """Phase of the drive in a step."""
    solid: float
    """Order parameter from which a film counts as solid ..."""
    melted: float
    """... and up to which it counts as melted."""


@inline
def _scales(q: Reduced, angle: float) -> tuple[float, float]:
    """Strain and square of the order parameter in units of a lane, where they are 1 in `q`'s.

    Without elasticity the strain has no effect, and its unit is free: c takes the place of a.
    """
    strain = math.sqrt(angle * (q.a if q.a > 0.0 else q.c))
    return strain, (angle * angle) * q.A * (q.a if q.a > 0.0 else q.c) / strain


@inline
def step_units(p: Parameters, steps: int) -> StepUnits:
    """Units of a lane with the parameters `p` that takes `steps` steps a drive period."""
    q, units, angle = reduced(p), units_of(p), 2.0 * math.pi / steps
    _, phi_square = _scales(q, angle)
    return StepUnits(
        units.length,
        units.speed / angle,
        1.0 / math.sqrt(phi_square),
        units.stress / ((angle * angle) * q.A),
        units.force / (angle * angle),
    )


@inline
def step_parameters(p: Parameters, steps: int) -> StepParameters:
    """The parameters `p` in the units of `step_units`."""
    q, angle = reduced(p), 2.0 * math.pi / steps
    strain, phi_square = _scales(q, angle)
    D_eff = noise.effective_intensity(q.D) * angle * phi_square
    solid = math.sqrt(phi_square) * film.solid_threshold(
        p.temperature,
        p.thermal_coefficient,
        p.critical_temperature,
        p.cubic_coefficient,
        p.quartic_coefficient,
    )
    return StepParameters(
        heating=q.heating * angle,
        # The same power as in a step, so that their errors for a rounded gamma cancel.
        k=(angle * angle) * q.A * friction.viscous_stress(1.0 / angle, 1.0, q.k, q.gamma),
        K=q.K * (angle * angle),
        tau=q.tau * strain / angle if q.a > 0.0 else 0.0,
        b=q.b * angle / math.sqrt(phi_square),
        c=q.c * angle / phi_square,
        D_eff=D_eff,
        gamma=q.gamma,
        least_phi=math.sqrt(D_eff),
        angle=angle,
        solid=solid,
        melted=film.MELTED_PART * solid if solid > 0.0 else -1.0,  # always solid: never melted
    )


@inline
def model_values(s: StepParameters, gamma: float) -> ParameterValues:
    """The parameters of a lane as the model's functions take them.

    The ones are literal, so that in a function with a literal `gamma` the compiler removes what
    they make superfluous: divisions, branches and the general power.
    """
    return ParameterValues(
        s.heating, s.k, s.K, gamma, s.angle, 1.0, 1.0, 0.0, 0.0, 0.0,
        1.0, s.tau, 1.0, 1.0, 0.5, 0.0, 1.0, s.b, s.c, 0.0,
    )  # fmt: skip


@inline
def to_lane(units: StepUnits, y: State) -> State:
    """The state (x, v, phi) in the units of a lane."""
    return y[0] / units.length, y[1] / units.speed, y[2] / units.phi


@inline
def from_lane(units: StepUnits, y: State) -> State:
    """The state (x, v, phi) in SI units."""
    return y[0] * units.length, y[1] * units.speed, y[2] * units.phi
