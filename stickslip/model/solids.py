"""The solid phases of the film, and where it melts and freezes (Eqs. 16-20).

Under a strain the film is stationary where B equals the balance
b phi - c phi^2 + d phi^3 - e phi^4, and stable where that falls. With terms of sixth order the
balance may turn at three order parameters p < q < r: then there are a soft solid between p and q
and a hard one above r. With e = 0 it turns at b/2c alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stickslip.compiled.decorators import inline, jit
from stickslip.model import film
from stickslip.parameters import Parameters

MELTED_PART = 0.1
"""A film counts as melted below this part of `solid_threshold`: the hysteresis of the count."""

# The slope of the log force over B - heating at which a solid has its strength is 4.
_ROOM = 8.0

# A film is liquid for good, for the motion, at this part of `solid_threshold`: a modulus of 1e-6.
_LIQUID = 1e-3

# Halvings of an interval: to the last bit, whatever the interval.
_BISECTIONS = 80


class TurningPoints(NamedTuple):
    """Order parameters at which the balance turns; infinite where it does not turn again."""

    soft: float
    """From here on a film is solid."""
    between: float
    """Up to here on it is a soft solid ..."""
    hard: float
    """... and from here on a hard one."""


class Thresholds(NamedTuple):
    """By what phases are told apart: order parameters, and the B [J/m3] of the soft solid."""

    solid: float
    """From here on a film counts as solid ..."""
    soft: float
    """... up to here on as a soft solid ..."""
    hard: float
    """... and from here on as a hard one; infinite where there is one solid."""
    weakest: float
    """The soft solid exists above this B ..."""
    strongest: float
    """... and below this one."""


@jit
def balance(p: Parameters, phi: float) -> float:
    """The B [J/m3] under which a film with order parameter `phi` is stationary."""
    return -film.log_force(p, phi, 0.0)


@jit
def _polished(p: Parameters, phi: float) -> float:
    """A turning point that rounding has blurred: two of Newton's steps."""
    b, c = p.cubic_coefficient, p.quartic_coefficient
    d, e = p.quintic_coefficient, p.sextic_coefficient
    for _ in range(2):
        slope = b - phi * (2.0 * c - phi * (3.0 * d - phi * (4.0 * e)))
        bend = -2.0 * c + phi * (6.0 * d - phi * (12.0 * e))
        phi -= slope / bend if bend != 0.0 else 0.0
    return phi if phi > 0.0 else 0.0


@jit
def turning_points(p: Parameters) -> TurningPoints:
    """Where the balance turns: the roots of b - 2 c phi + 3 d phi^2 - 4 e phi^3, none negative."""
    b, c = p.cubic_coefficient, p.quartic_coefficient
    d, e = p.quintic_coefficient, p.sextic_coefficient
    if e == 0.0:
        return TurningPoints(0.5 * b / c, math.inf, math.inf)
    # With phi = middle + t: t^3 + 3 linear t - 2 constant = 0.
    middle = 0.25 * d / e
    linear = c / (6.0 * e) - middle * middle
    constant = middle * (middle * middle - 0.25 * c / e) + 0.125 * b / e
    inside = constant * constant + linear * linear * linear
    if inside >= 0.0:
        root = math.sqrt(inside)
        t = _cube_root(constant + root) + _cube_root(constant - root)
        return TurningPoints(_polished(p, middle + t), math.inf, math.inf)
    size = math.sqrt(-linear)
    angle = math.acos(max(-1.0, min(1.0, constant / (size * size * size)))) / 3.0
    third = 2.0 * math.pi / 3.0
    return TurningPoints(
        _polished(p, middle + 2.0 * size * math.cos(angle + third)),
        _polished(p, middle + 2.0 * size * math.cos(angle - third)),
        _polished(p, middle + 2.0 * size * math.cos(angle)),
    )


@jit
def _cube_root(x: float) -> float:
    return math.copysign(abs(x) ** (1.0 / 3.0), x)


@jit
def _falling_to(p: Parameters, B: float, low: float, high: float) -> float:
    """Where between `low` and `high` the balance, which falls there, is B."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if balance(p, middle) > B:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@jit
def hardest(p: Parameters, B: float) -> float:
    """The largest order parameter of a stable solid; where the film is liquid only, the last one.

    That is the one at which the solid is lost under the largest B.
    """
    turns = turning_points(p)
    last = turns.soft if turns.hard == math.inf else turns.hard
    if balance(p, last) > B:
        beyond = 2.0 * last + 1.0
        while balance(p, beyond) > B:
            beyond *= 2.0
        return _falling_to(p, B, last, beyond)
    if last > turns.soft and balance(p, turns.soft) > B:
        return _falling_to(p, B, turns.soft, turns.between)
    return last if balance(p, last) >= balance(p, turns.soft) else turns.soft


@jit
def next_phase(p: Parameters, phi: float, B: float) -> float:
    """The order parameter to which a film goes from `phi` under a constant B [J/m3]; 0 if liquid.

    Down the free energy, to the first minimum on the way: it may pass a phase that does not exist.
    """
    turns, force = turning_points(p), film.log_force(p, phi, B)
    soft = hard = -1.0
    if turns.soft < turns.between and balance(p, turns.soft) > B:
        if turns.between == math.inf:
            hard = hardest(p, B)
        elif balance(p, turns.between) < B:
            soft = _falling_to(p, B, turns.soft, turns.between)
    if turns.hard < math.inf and balance(p, turns.hard) > B:
        hard = hardest(p, B)
    if force > 0.0:  # it falls
        return hard if 0.0 < hard <= phi else soft if 0.0 < soft <= phi else 0.0
    if force < 0.0:  # it rises
        return soft if soft >= phi else hard
    return phi


@jit
def strongest(p: Parameters) -> float:
    """The B [J/m3] from which on the film is liquid only."""
    turns = turning_points(p)
    soft = balance(p, turns.soft)
    return soft if turns.hard == math.inf else max(soft, balance(p, turns.hard))


@inline
def solid_order_parameter(p: Parameters, B: float) -> float:
    """Stable stationary order parameter phi_plus, Eq. 16, of the hardest solid.

    Where the film is liquid only, that at which the last solid is lost: b/2c.
    """
    if p.sextic_coefficient > 0.0:
        return hardest(p, B)
    half = 0.5 * p.cubic_coefficient / p.quartic_coefficient
    inside = half * half - B / p.quartic_coefficient
    return half + math.sqrt(max(inside, 0.0))


@inline
def largest_order_parameter(p: Parameters) -> float:
    """The value that phi never exceeds once below it: phi_plus at rest, above T_c0 b/2c."""
    return solid_order_parameter(p, film.heating(p))


@inline
def coexistence_limit(p: Parameters) -> float:
    """The B [J/m3] from which on the film is liquid only: b^2/4c, Eq. 17."""
    if p.sextic_coefficient > 0.0:
        return strongest(p)
    return p.cubic_coefficient * p.cubic_coefficient / (4.0 * p.quartic_coefficient)


@inline
def melting_strain(p: Parameters) -> float:
    """Strain eps_c0 above which the film melts, Eq. 19; 0 where it is liquid at any strain."""
    if p.elastic_coefficient <= 0.0:
        return 0.0  # no strain melts a film without elasticity
    return math.sqrt(max(coexistence_limit(p) - film.heating(p), 0.0) / p.elastic_coefficient)


@inline
def solidification_strain(p: Parameters) -> float:
    """Strain eps_c^0 below which a liquid film solidifies, Eq. 20; 0 where it does at none."""
    if p.elastic_coefficient <= 0.0:
        return 0.0
    return math.sqrt(max(-film.heating(p), 0.0) / p.elastic_coefficient)


@inline
def melting_temperature(p: Parameters, eps: float) -> float:
    """Temperature T_c0 [K] above which a film under this strain melts, Eq. 17."""
    return solidification_temperature(p, eps) + coexistence_limit(p) / (2.0 * p.thermal_coefficient)


@inline
def solidification_temperature(p: Parameters, eps: float) -> float:
    """Temperature T_c^0 [K] below which a liquid film under this strain solidifies, Eq. 18."""
    harmonic = p.elastic_coefficient * (eps * eps)
    return p.critical_temperature - harmonic / (2.0 * p.thermal_coefficient)


@inline
def solid_threshold(p: Parameters) -> float:
    """Order parameter from which a film counts as solid: b/2c, below the solid branch of Eq. 16.

    With terms of sixth order the first turning point. Where that is 0 (a second-order transition)
    half the unstrained stationary value.
    """
    if p.sextic_coefficient > 0.0:
        first = turning_points(p).soft
        return first if first > 0.0 else 0.5 * hardest(p, film.heating(p))
    if p.cubic_coefficient > 0.0:
        return 0.5 * p.cubic_coefficient / p.quartic_coefficient
    return 0.5 * math.sqrt(max(-film.heating(p) / p.quartic_coefficient, 0.0))


@inline
def thresholds(p: Parameters) -> Thresholds:
    """By what the phases of a film are told apart."""
    if p.sextic_coefficient == 0.0:
        return Thresholds(solid_threshold(p), math.inf, math.inf, 0.0, 0.0)
    turns = turning_points(p)
    if turns.hard == math.inf:
        return Thresholds(solid_threshold(p), math.inf, math.inf, 0.0, 0.0)
    weakest, strongest = balance(p, turns.between), balance(p, turns.soft)
    return Thresholds(solid_threshold(p), turns.between, turns.hard, weakest, strongest)


@inline
def parts_never(p: Parameters, lowest: float, highest: float) -> bool:
    """Whether neighbouring motions do not part while phi of both is between these two values.

    Where the force does not fall with the relative velocity, M dv^2/2 + K dx^2 of their difference
    never grows. It does not in a liquid, which has no elasticity to speak of. Nor does it in a
    solid whose order parameter follows the strain at once, where that is below its strength: the
    stress a phi^2 eps rises while d ln(phi)/d ln(eps) = -2 (B - heating)/(slope of the log force)
    stays above -1/2, here with as much room again (docs/decisions/stationarity.md).
    """
    heating, threshold = film.heating(p), solid_threshold(p)
    liquid = highest <= _LIQUID * threshold
    slope, stretched = film.log_force_slope(p, lowest), balance(p, lowest) - heating
    solid = lowest >= threshold and slope > _ROOM * max(stretched, 0.0)
    moved = p.spring_stiffness > 0.0 and p.viscosity_coefficient > 0.0
    return moved and (liquid or solid)


@inline
def is_soft(phases: Thresholds, phi: float, B: float) -> bool:
    """Whether a film is a soft solid: not merely on its way through, where that does not exist."""
    within = (phi >= phases.solid) & (phi <= phases.soft)
    return within & (phases.weakest < B) & (phases.strongest > B)
