"""The paper's power law of the viscous stress (Eqs. 6, 7, 9 and 11).

The effective viscosity is a power of the strain rate. The rheological index gamma is negative for a
pseudoplastic, 0 for a Newtonian and positive for a dilatant fluid.
"""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import cube_root, inverse_cube_root, power
from stickslip.model.friction import strain_rate
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters

# The viscous slope of a pseudoplastic fluid is infinite at u = 0; this small strain rate, squared
# and added, keeps the Jacobian finite there.
_SMALLEST_SQUARE = 1e-90**2


@inline
def viscous_stress(p: Parameters, u: float, phi: float) -> float:
    """Viscous shear stress [Pa], Eqs. 6-9; it has the sign of `u` (Eq. 11)."""
    rate = strain_rate(p, u)
    return math.copysign(p.viscosity_coefficient * _rate_power(rate, p.rheological_index), u)


@inline
def rounded_viscous_stress(
    p: Parameters, u: float, phi: float, u_s: float
) -> tuple[float, float, float]:
    """Viscous stress [Pa] and its slope [Pa s/m], with the cusp at u = 0 rounded for |u| < u_s.

    The third value, the derivative with respect to ln(phi), is 0. For gamma < 0 the strain rate in
    the viscosity, Eq. 7, is sqrt(u^2 + u_s^2)/h. The stress is then odd in u, its slope is finite,
    and its relative change is |gamma|/2 (u_s/u)^2. For gamma >= 0 it equals `viscous_stress`.
    """
    h, k, gamma = p.film_thickness, p.viscosity_coefficient, p.rheological_index
    rate = u / h
    if gamma >= 0.0:
        viscosity = k * _square_power(rate * rate, gamma)
        return viscosity * rate, viscosity / h * (1.0 + gamma), 0.0
    rounding = u_s / h
    square = rate * rate + (rounding * rounding + _SMALLEST_SQUARE)
    viscosity = k * _square_power(square, gamma)
    return viscosity * rate, viscosity / h * (1.0 + gamma * (rate * rate / square)), 0.0


@inline
def _has_cusp(p: Parameters) -> bool:
    return p.rheological_index < 0.0


@inline
def _stable_slope(p: Parameters, u: float, phi: float) -> float:
    """Slope at the largest slip; 0 for a pseudoplastic fluid, whose slope peaks at the cusp."""
    return rounded_viscous_stress(p, u, phi, 0.0)[1] if p.rheological_index >= 0.0 else 0.0


@inline
def _scaled_viscosity(p: Parameters, rate: float, stress: float) -> float:
    """The coefficient k in units of `rate` [1/s] and `stress` [Pa]: k rate^(gamma+1)/stress."""
    return p.viscosity_coefficient * _rate_power(rate, p.rheological_index) / stress


@inline
def _square_power(square: float, gamma: float) -> float:
    """square^(gamma/2), without a general power if gamma is +-1/3 or +-2/3."""
    if gamma == 0.0:
        return 1.0
    if gamma == -2.0 / 3.0:
        return inverse_cube_root(square)
    if gamma == 2.0 / 3.0:
        return cube_root(square)
    if gamma == -1.0 / 3.0:
        return math.sqrt(inverse_cube_root(square))
    if gamma == 1.0 / 3.0:
        return math.sqrt(cube_root(square))
    return power(square, 0.5 * gamma)


@inline
def _rate_power(rate: float, gamma: float) -> float:
    """rate^(gamma + 1), without a general power if gamma is +-1/3 or +-2/3."""
    if gamma == 0.0:
        return rate
    if gamma == -2.0 / 3.0:
        return cube_root(rate)
    if gamma == 2.0 / 3.0:
        root = cube_root(rate)
        return rate * (root * root)
    if gamma == -1.0 / 3.0:
        root = cube_root(rate)
        return root * root
    if gamma == 1.0 / 3.0:
        return rate * cube_root(rate)
    return power(rate, gamma + 1.0)


LAW = FrictionLaw(
    name="power-law",
    stress=viscous_stress,
    rounded=rounded_viscous_stress,
    has_cusp=_has_cusp,
    stable_slope=_stable_slope,
    scaled={"viscosity_coefficient": _scaled_viscosity},
    parameters=("viscosity_coefficient", "rheological_index"),
    special_indices=(-2.0 / 3.0, -1.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0),
)
