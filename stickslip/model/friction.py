"""The friction between the blocks: strain, stresses and force (Eqs. 4-11, 24).

`u` is the relative velocity V - v of the blocks everywhere.
"""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import cube_root, inverse_cube_root, power

# The viscous slope of a pseudoplastic fluid is infinite at u = 0; a strain rate this small
# stands for 0 there and keeps the Jacobian finite.
_SMALLEST_STRAIN_RATE = 1e-90
_SMALLEST_SQUARE = _SMALLEST_STRAIN_RATE**2


@inline
def elastic_strain(u: float, tau: float, h: float) -> float:
    """Elastic shear strain in the adiabatic limit, Eq. 24."""
    return u * (tau / h)


@inline
def strain_rate(u: float, h: float) -> float:
    """Absolute strain rate [1/s], Eq. 8."""
    return abs(u) / h


@inline
def effective_viscosity(rate: float, k: float, gamma: float) -> float:
    """Effective viscosity [Pa s] at the strain rate `rate` [1/s], Eq. 7."""
    return k * rate**gamma


@inline
def viscous_stress(u: float, h: float, k: float, gamma: float) -> float:
    """Viscous shear stress [Pa], Eqs. 6-9; it has the sign of `u` (Eq. 11)."""
    return math.copysign(k * _rate_power(strain_rate(u, h), gamma), u)


@inline
def viscous_stress_slope(u: float, h: float, k: float, gamma: float) -> float:
    """Derivative of the viscous stress with respect to `u` [Pa s/m]; huge, not infinite, at 0."""
    rate = strain_rate(u, h)
    rate = _SMALLEST_STRAIN_RATE if rate < _SMALLEST_STRAIN_RATE else rate  # NaN stays NaN
    return k * (gamma + 1.0) / h * _relative_rate_power(rate, gamma)


@inline
def rounded_viscous_stress(
    u: float, u_s: float, h: float, k: float, gamma: float
) -> tuple[float, float]:
    """Viscous stress [Pa] and its slope [Pa s/m], with the cusp at u = 0 rounded for |u| < u_s.

    For gamma < 0 the strain rate in the viscosity, Eq. 7, is sqrt(u^2 + u_s^2)/h: odd in u, the
    slope finite, the relative change of the stress |gamma|/2 (u_s/u)^2. For gamma >= 0 it is
    `viscous_stress`.
    """
    rate = u / h
    if gamma >= 0.0:
        viscosity = k * _square_power(rate * rate, gamma)
        return viscosity * rate, viscosity / h * (1.0 + gamma)
    rounding = u_s / h
    square = rate * rate + (rounding * rounding + _SMALLEST_SQUARE)
    viscosity = k * _square_power(square, gamma)
    return viscosity * rate, viscosity / h * (1.0 + gamma * (rate * rate / square))


@inline
def _square_power(square: float, gamma: float) -> float:
    """square^(gamma/2), without a general power for the three fluids of the paper."""
    if gamma == 0.0:
        return 1.0
    if gamma == -2.0 / 3.0:
        return inverse_cube_root(square)
    if gamma == 2.0 / 3.0:
        return cube_root(square)
    return power(square, 0.5 * gamma)


@inline
def _rate_power(rate: float, gamma: float) -> float:
    """rate^(gamma + 1), without a general power for the three fluids of the paper."""
    if gamma == 0.0:
        return rate
    if gamma == -2.0 / 3.0:
        return cube_root(rate)
    if gamma == 2.0 / 3.0:
        root = cube_root(rate)
        return rate * (root * root)
    return power(rate, gamma + 1.0)


@inline
def _relative_rate_power(rate: float, gamma: float) -> float:
    """rate^gamma for rate > 0, from what `_rate_power` computes at the same rate."""
    if gamma == 0.0:
        return 1.0
    if gamma == -2.0 / 3.0:
        inverse = inverse_cube_root(rate)
        return inverse * inverse
    if gamma == 2.0 / 3.0:
        root = cube_root(rate)
        return root * root
    return power(rate, gamma + 1.0) / rate


@inline
def friction_force(sigma_el: float, sigma_v: float, A: float) -> float:
    """Friction force [N] on the lower block, Eqs. 4, 5, 10."""
    return (sigma_el + sigma_v) * A
