"""The solid phases of the film, and where it melts and freezes (Eqs. 16-20).

Under a strain the film is stationary where B equals the balance b phi - c phi^2 + ... (`film.py`),
and stable where the balance falls with phi. The paper's balance has one turning point, b/2c. With
more terms it may have three, p < q < r: a soft solid then exists between p and q, and a hard one
above r. Solids between further turning points are found as well, and count as hard.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stickslip.compiled.decorators import inline, jit
from stickslip.model import film
from stickslip.parameters import Parameters

MELTED_PART = 0.1
"""A film counts as melted below this part of `solid_threshold`; the gap is a hysteresis."""

# At the strength of a solid the slope of the log force is 4 (B - heating); this is twice as much.
_ROOM = 8.0

# Below this fraction of `solid_threshold`, with a modulus below 1e-6 of that at the threshold, a
# film moves like a liquid.
_LIQUID = 1e-3

# This many halvings of an interval resolve the last bit of values above 1e-14 of it.
_BISECTIONS = 100

# An order parameter from which a film freezes, if nothing is in its way.
_ALMOST_LIQUID = 1e-9

# Upper bound of order parameters; in the paper's solid they are of order one.
_LARGEST = 1e6


class TurningPoints(NamedTuple):
    """The first order parameters at which the balance turns; infinite if there are no more."""

    soft: float
    """A film is solid from here on."""
    between: float
    """A solid is soft up to here ..."""
    hard: float
    """... and hard from here on."""


class Thresholds(NamedTuple):
    """The limits between phases: order parameters, and the B [J/m3] of the soft solid."""

    solid: float
    """A film counts as solid from here on ..."""
    soft: float
    """... as a soft solid up to here ..."""
    hard: float
    """... and as a hard one from here on; infinite if there is only one solid."""
    weakest: float
    """The soft solid exists above this B ..."""
    strongest: float
    """... and below this one."""


@jit
def balance(p: Parameters, phi: float) -> float:
    """The B [J/m3] at which a film with order parameter `phi` is stationary."""
    return -film.log_force(p, phi, 0.0)


@jit
def _derivative(p: Parameters, order: int, phi: float) -> float:
    """Derivative of the balance, of order 1 or higher."""
    total = 0.0
    for power in range(film.HIGHEST_POWER, order - 1, -1):
        weight = film.balance_coefficient(p, power)
        for lower in range(order):
            weight *= power - lower
        total = total * phi + weight
    return total


@jit
def _next_zero(p: Parameters, order: int, low: float, positive: bool) -> float:
    """First zero above `low` of a derivative of the balance; `positive` is its sign up to there.

    The `order` is 1 or more. Between two zeros of its slope the derivative has at most one zero.
    The recursion also keeps the compiler from inlining this function everywhere.
    """
    if order >= film.HIGHEST_POWER:  # that derivative is constant
        return _LARGEST
    grows = _derivative(p, order + 1, low) > 0.0
    for _ in range(film.HIGHEST_POWER):
        high = _next_zero(p, order + 1, low, grows)
        value = _derivative(p, order, high)
        if value < 0.0 if positive else value > 0.0:
            for _ in range(_BISECTIONS):
                middle = 0.5 * (low + high)
                if (_derivative(p, order, middle) > 0.0) == positive:
                    low = middle
                else:
                    high = middle
            return low
        low, grows = high, not grows
    return _LARGEST


@jit
def next_turning_point(p: Parameters, phi: float, rises: bool) -> float:
    """First turning point of the balance above `phi`; up to there the balance `rises` or falls.

    Infinite if the balance falls forever.
    """
    if phi == math.inf:
        return phi
    if not film.has_higher_terms(p):
        return 0.5 * p.cubic_coefficient / p.quartic_coefficient if rises else math.inf
    found = _next_zero(p, 1, phi, rises)
    return found if rises or found < _LARGEST else math.inf


@jit
def turning_points(p: Parameters) -> TurningPoints:
    """The first turning points of the balance; the first one is 0 if the balance falls from 0."""
    soft = next_turning_point(p, 0.0, True)
    between = next_turning_point(p, soft, False)
    return TurningPoints(soft, between, next_turning_point(p, between, True))


@jit
def _falling_to(p: Parameters, B: float, low: float, high: float) -> float:
    """Order parameter at which the balance is B, between `low` and `high`, where it falls."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if balance(p, middle) > B:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@jit
def _solid_between(p: Parameters, B: float, low: float, high: float) -> float:
    """The stable solid at B where the balance falls between two turning points; -1 if none."""
    if high == math.inf:
        high = 2.0 * low + 1.0
        while balance(p, high) > B:
            high *= 2.0
    return _falling_to(p, B, low, high) if balance(p, low) > B >= balance(p, high) else -1.0


@jit
def hardest(p: Parameters, B: float) -> float:
    """Largest order parameter of a stable solid at B.

    If the film can only be liquid: the order parameter at which the last solid disappears, that is
    at the largest B.
    """
    low = next_turning_point(p, 0.0, True)
    found, lost = -1.0, low
    for _ in range(film.HIGHEST_POWER):  # more passes than solids; one at infinity adds none
        high = next_turning_point(p, low, False)
        found = max(found, _solid_between(p, B, low, high))
        lost = low if balance(p, low) >= balance(p, lost) else lost
        low = next_turning_point(p, high, True)
    return found if found >= 0.0 else lost


@jit
def next_phase(p: Parameters, phi: float, B: float) -> float:
    """Order parameter that a film reaches from `phi` at a constant B [J/m3]; 0 if liquid.

    It moves down the free energy to the first minimum, past phases that do not exist at this B.
    """
    force, below, low = film.log_force(p, phi, B), 0.0, next_turning_point(p, 0.0, True)
    for _ in range(film.HIGHEST_POWER):
        high = next_turning_point(p, low, False)
        solid = _solid_between(p, B, low, high)
        if force < 0.0 and solid >= phi:  # it rises
            return solid
        below = solid if 0.0 <= solid <= phi else below
        low = next_turning_point(p, high, True)
    return phi if force == 0.0 else below


@jit
def _softest(p: Parameters) -> float:
    """Order parameter into which a film freezes without a barrier; the hardest above T_c."""
    soft = next_phase(p, _ALMOST_LIQUID, film.heating(p))
    return soft if soft > 0.0 else hardest(p, film.heating(p))


@jit
def strongest(p: Parameters) -> float:
    """The B [J/m3] above which the film can only be liquid."""
    return balance(p, hardest(p, math.inf))


@inline
def solid_order_parameter(p: Parameters, B: float) -> float:
    """Stable stationary order parameter phi_plus, Eq. 16, of the hardest solid.

    If the film can only be liquid: the order parameter at which the last solid disappears, b/2c.
    """
    if film.has_higher_terms(p):
        return hardest(p, B)
    half = 0.5 * p.cubic_coefficient / p.quartic_coefficient
    inside = half * half - B / p.quartic_coefficient
    return half + math.sqrt(max(inside, 0.0))


@inline
def largest_order_parameter(p: Parameters) -> float:
    """The bound that phi never crosses from below: phi_plus at rest, or b/2c above T_c0."""
    return solid_order_parameter(p, film.heating(p))


@inline
def coexistence_limit(p: Parameters) -> float:
    """The B [J/m3] above which the film can only be liquid: b^2/4c, Eq. 17."""
    if film.has_higher_terms(p):
        return strongest(p)
    return p.cubic_coefficient * p.cubic_coefficient / (4.0 * p.quartic_coefficient)


@inline
def melting_strain(p: Parameters) -> float:
    """Strain eps_c0 above which the film melts, Eq. 19; 0 if always liquid or not elastic."""
    if p.elastic_coefficient <= 0.0:
        return 0.0  # no strain melts a film without elasticity
    return math.sqrt(max(coexistence_limit(p) - film.heating(p), 0.0) / p.elastic_coefficient)


@inline
def solidification_strain(p: Parameters) -> float:
    """Strain eps_c^0 below which a liquid film solidifies, Eq. 20; 0 if never, or not elastic."""
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
    """Order parameter above which a film is solid: b/2c, below the solid branch of Eq. 16.

    With more terms it is the first turning point. If that is 0 (a second-order transition), it is
    half the stationary order parameter without strain, of the softest solid.
    """
    if film.has_higher_terms(p):
        first = next_turning_point(p, 0.0, True)
        return first if first > 0.0 else 0.5 * _softest(p)
    if p.cubic_coefficient > 0.0:
        return 0.5 * p.cubic_coefficient / p.quartic_coefficient
    return 0.5 * math.sqrt(max(-film.heating(p) / p.quartic_coefficient, 0.0))


@inline
def thresholds(p: Parameters) -> Thresholds:
    """The limits between the phases of a film; a third solid counts as hard."""
    solid = solid_threshold(p)
    turns = turning_points(p)
    if turns.hard == math.inf:
        return Thresholds(solid, math.inf, math.inf, 0.0, 0.0)
    weakest, strongest = balance(p, turns.between), balance(p, turns.soft)
    return Thresholds(solid, turns.between, turns.hard, weakest, strongest)


@inline
def parts_never(p: Parameters, lowest: float, highest: float) -> bool:
    """Return whether neighbouring motions cannot separate while phi is between these values.

    As long as the force does not fall with the relative velocity, M dv^2/2 + K dx^2 of their
    difference cannot grow. In a liquid the force does not fall, because the elasticity is
    negligible. Nor does it fall in a solid below its strength whose order parameter follows the
    strain instantly: the stress a phi^2 eps rises while d ln(phi)/d ln(eps) = -2 (B - heating)/
    (slope of the log force) is above -1/2, a condition applied here with a margin of a factor of
    two (docs/decisions/stationarity.md).
    """
    heating, threshold = film.heating(p), solid_threshold(p)
    liquid = highest <= _LIQUID * threshold
    slope, stretched = film.log_force_slope(p, lowest), balance(p, lowest) - heating
    solid = lowest >= threshold and slope > _ROOM * max(stretched, 0.0)
    moved = p.spring_stiffness > 0.0 and p.viscosity_coefficient > 0.0
    return moved and (liquid or solid)


@inline
def is_soft(phases: Thresholds, phi: float, B: float) -> bool:
    """Return whether a film is a soft solid, not just passing through at a B where none exists."""
    within = (phi >= phases.solid) & (phi <= phases.soft)
    return within & (phases.weakest < B) & (phases.strongest > B)
