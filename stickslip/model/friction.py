"""The friction between the blocks: strain, strain rate and force (Eqs. 4, 5, 8, 10, 24).

`u` is always the relative velocity V - v of the blocks. `model/laws/` has the laws of the viscous
stress.
"""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.parameters import Parameters


@inline
def elastic_strain(p: Parameters, u: float) -> float:
    """Elastic shear strain in the adiabatic limit, Eq. 24."""
    return u * strain_slope(p)


@inline
def strain_slope(p: Parameters) -> float:
    """Derivative of the adiabatic strain with respect to `u` [s/m], Eq. 24."""
    return p.strain_relaxation_time / p.film_thickness


@inline
def strain_rate(p: Parameters, u: float) -> float:
    """Absolute strain rate [1/s], Eq. 8."""
    return abs(u) / p.film_thickness


@inline
def friction_force(p: Parameters, sigma_el: float, sigma_v: float) -> float:
    """Friction force [N] on the lower block, Eqs. 4, 5, 10."""
    return (sigma_el + sigma_v) * p.contact_area
