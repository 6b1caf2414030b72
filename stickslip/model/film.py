"""The lubricant film: free energy, phases and transitions (Eqs. 12-20, 25, 26)."""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline


@inline
def free_energy(
    phi: float, eps: float, T: float, alpha: float, T_c: float, a: float, b: float, c: float
) -> float:
    """Free energy density f(phi, eps) [J/m3], Eq. 12."""
    phi2 = phi * phi
    elastic = 0.5 * a * phi2 * (eps * eps)
    return alpha * (T - T_c) * phi2 + elastic - b / 3.0 * (phi2 * phi) + 0.25 * c * (phi2 * phi2)


@inline
def elastic_stress(phi: float, eps: float, a: float) -> float:
    """Elastic shear stress [Pa], Eq. 13."""
    return a * (phi * phi) * eps


@inline
def shear_modulus(phi: float, a: float) -> float:
    """Shear modulus of the film [Pa], Eq. 14."""
    return a * (phi * phi)


@inline
def melting_function(eps: float, T: float, alpha: float, T_c: float, a: float) -> float:
    """Melting function B [J/m3], Eq. 15: solid only at B <= 0, liquid only at B >= b^2/4c."""
    return a * (eps * eps) + 2.0 * alpha * (T - T_c)


@inline
def solid_order_parameter(B: float, b: float, c: float) -> float:
    """Stable stationary order parameter phi_plus, Eq. 16; NaN where the film is liquid only."""
    return 0.5 * b / c + math.sqrt((0.5 * b / c) ** 2 - B / c)


@inline
def unstable_order_parameter(B: float, b: float, c: float) -> float:
    """Unstable stationary order parameter phi_minus, Eq. 16; NaN where the film is liquid only."""
    return 0.5 * b / c - math.sqrt((0.5 * b / c) ** 2 - B / c)


@inline
def melting_temperature(
    eps: float, alpha: float, T_c: float, a: float, b: float, c: float
) -> float:
    """Temperature T_c0 [K] above which a film at strain `eps` melts, Eq. 17."""
    return T_c - a * eps**2 / (2.0 * alpha) + b**2 / (8.0 * alpha * c)


@inline
def solidification_temperature(eps: float, alpha: float, T_c: float, a: float) -> float:
    """Temperature T_c^0 [K] below which a film at strain `eps` solidifies, Eq. 18."""
    return T_c - a * eps**2 / (2.0 * alpha)


@inline
def melting_strain(T: float, alpha: float, T_c: float, a: float, b: float, c: float) -> float:
    """Strain eps_c0 above which the film melts, Eq. 19; NaN where it is liquid at any strain."""
    return math.sqrt(2.0 * alpha * (T_c - T) / a + b**2 / (4.0 * a * c))


@inline
def solidification_strain(T: float, alpha: float, T_c: float, a: float) -> float:
    """Strain eps_c^0 below which the film solidifies, Eq. 20; NaN above T_c."""
    return math.sqrt(2.0 * alpha * (T_c - T) / a)


@inline
def order_parameter_rate(phi: float, B: float, b: float, c: float, delta: float) -> float:
    """Deterministic rate of the order parameter [1/s], Eqs. 25 and 26 without noise."""
    return -delta * phi * log_force(phi, B, b, c)


@inline
def log_force(phi: float, B: float, b: float, c: float) -> float:
    """(df/dphi)/phi = B - b phi + c phi^2 [J/m3]: the force on ln(phi), Eqs. 12 and 26."""
    return B - b * phi + c * (phi * phi)


@inline
def log_force_slope(phi: float, b: float, c: float) -> float:
    """Derivative of `log_force` with respect to ln(phi) [J/m3]."""
    return phi * (2.0 * c * phi - b)


@inline
def solid_threshold(T: float, alpha: float, T_c: float, b: float, c: float) -> float:
    """Order parameter from which a film counts as solid: b/2c, below the solid branch of Eq. 16.

    Without a cubic term (second-order transition) half the unstrained stationary value.
    """
    if b > 0.0:
        return 0.5 * b / c
    return 0.5 * math.sqrt(max(2.0 * alpha * (T_c - T) / c, 0.0))


MELTED_PART = 0.1
"""A film counts as melted below this part of `solid_threshold`: the hysteresis of the count."""


@inline
def largest_order_parameter(T: float, alpha: float, T_c: float, b: float, c: float) -> float:
    """The value that phi never exceeds once below it: phi_plus at rest, above T_c0 b/2c."""
    inside = (0.5 * b / c) ** 2 - 2.0 * alpha * (T - T_c) / c
    return 0.5 * b / c + math.sqrt(max(inside, 0.0))
