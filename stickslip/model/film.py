"""The lubricant film: free energy, phases and transitions (Eqs. 12-16, 19, 25, 26).

All that depends on the form of the free energy stands here: who adds a term to it, adds it to
`free_energy`, `log_force` and `log_force_slope`.
"""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.parameters import Parameters

MELTED_PART = 0.1
"""A film counts as melted below this part of `solid_threshold`: the hysteresis of the count."""


@inline
def heating(p: Parameters) -> float:
    """2 alpha (T - T_c) [J/m3]: what temperature adds to the melting function, Eq. 15."""
    return 2.0 * p.thermal_coefficient * (p.temperature - p.critical_temperature)


@inline
def free_energy(p: Parameters, phi: float, eps: float) -> float:
    """Free energy density f(phi, eps) [J/m3], Eq. 12."""
    phi2 = phi * phi
    harmonic = 0.5 * melting_function(p, eps) * phi2
    cubic = p.cubic_coefficient / 3.0 * (phi2 * phi)
    return harmonic - cubic + 0.25 * p.quartic_coefficient * (phi2 * phi2)


@inline
def elastic_stress(p: Parameters, phi: float, eps: float) -> float:
    """Elastic shear stress [Pa], Eq. 13."""
    return p.elastic_coefficient * (phi * phi) * eps


@inline
def shear_modulus(p: Parameters, phi: float) -> float:
    """Shear modulus of the film [Pa], Eq. 14."""
    return p.elastic_coefficient * (phi * phi)


@inline
def melting_function(p: Parameters, eps: float) -> float:
    """Melting function B [J/m3], Eq. 15: solid only at B <= 0, liquid only at B >= b^2/4c."""
    return p.elastic_coefficient * (eps * eps) + heating(p)


@inline
def log_force(p: Parameters, phi: float, B: float) -> float:
    """(df/dphi)/phi = B - b phi + c phi^2 [J/m3]: the force on ln(phi), Eqs. 12 and 26."""
    return B - p.cubic_coefficient * phi + p.quartic_coefficient * (phi * phi)


@inline
def log_force_slope(p: Parameters, phi: float) -> float:
    """Derivative of `log_force` with respect to ln(phi) [J/m3]."""
    return phi * (2.0 * p.quartic_coefficient * phi - p.cubic_coefficient)


@inline
def order_parameter_rate(p: Parameters, phi: float, B: float) -> float:
    """Deterministic rate of the order parameter [1/s], Eqs. 25 and 26 without noise."""
    return -p.kinetic_coefficient * phi * log_force(p, phi, B)


@inline
def solid_order_parameter(p: Parameters, B: float) -> float:
    """Stable stationary order parameter phi_plus, Eq. 16; b/2c where the film is liquid only."""
    half = 0.5 * p.cubic_coefficient / p.quartic_coefficient
    inside = half * half - B / p.quartic_coefficient
    return half + math.sqrt(max(inside, 0.0))


@inline
def largest_order_parameter(p: Parameters) -> float:
    """The value that phi never exceeds once below it: phi_plus at rest, above T_c0 b/2c."""
    return solid_order_parameter(p, heating(p))


@inline
def coexistence_limit(p: Parameters) -> float:
    """The B [J/m3] from which on the film is liquid only: b^2/4c, Eq. 17."""
    return p.cubic_coefficient * p.cubic_coefficient / (4.0 * p.quartic_coefficient)


@inline
def melting_strain(p: Parameters) -> float:
    """Strain eps_c0 above which the film melts, Eq. 19; 0 where it is liquid at any strain."""
    if p.elastic_coefficient <= 0.0:
        return 0.0  # no strain melts a film without elasticity
    return math.sqrt(max(coexistence_limit(p) - heating(p), 0.0) / p.elastic_coefficient)


@inline
def solidification_strain(p: Parameters) -> float:
    """Strain eps_c^0 below which a liquid film solidifies, Eq. 20; 0 where it does at none."""
    if p.elastic_coefficient <= 0.0:
        return 0.0
    return math.sqrt(max(-heating(p), 0.0) / p.elastic_coefficient)


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

    Without a cubic term (second-order transition) half the unstrained stationary value.
    """
    if p.cubic_coefficient > 0.0:
        return 0.5 * p.cubic_coefficient / p.quartic_coefficient
    return 0.5 * math.sqrt(max(-heating(p) / p.quartic_coefficient, 0.0))
