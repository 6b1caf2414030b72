"""The lubricant film: free energy, phases and transitions (Eqs. 12-16, 19, 25, 26).

All that depends on the form of the free energy stands here and in `solids.py`, which finds its
phases. Terms of fifth and sixth order, -d/5 phi^5 + e/6 phi^6, let a soft solid exist beside a hard
one; where e = 0 the compiler leaves them out.
"""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.parameters import Parameters


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
    low = harmonic - cubic + 0.25 * p.quartic_coefficient * (phi2 * phi2)
    high = p.sextic_coefficient / 6.0 * phi - p.quintic_coefficient / 5.0
    return low if p.sextic_coefficient == 0.0 else low + high * (phi2 * phi2 * phi)


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
    """(df/dphi)/phi = B - b phi + c phi^2 - d phi^3 + e phi^4 [J/m3]: the force on ln(phi).

    Eqs. 12 and 26.
    """
    low = B - p.cubic_coefficient * phi + p.quartic_coefficient * (phi * phi)
    high = p.sextic_coefficient * phi - p.quintic_coefficient
    return low if p.sextic_coefficient == 0.0 else low + high * (phi * phi * phi)


@inline
def log_force_slope(p: Parameters, phi: float) -> float:
    """Derivative of `log_force` with respect to ln(phi) [J/m3]."""
    low = phi * (2.0 * p.quartic_coefficient * phi - p.cubic_coefficient)
    high = 4.0 * p.sextic_coefficient * phi - 3.0 * p.quintic_coefficient
    return low if p.sextic_coefficient == 0.0 else low + high * (phi * phi * phi)


@inline
def order_parameter_rate(p: Parameters, phi: float, B: float) -> float:
    """Deterministic rate of the order parameter [1/s], Eqs. 25 and 26 without noise."""
    return -p.kinetic_coefficient * phi * log_force(p, phi, B)
