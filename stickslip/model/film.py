"""The lubricant film: free energy, elasticity and kinetics (Eqs. 12-15, 25, 26).

`variables.py` declares the terms of the free energy with their coefficients: the paper's,
-b/3 phi^3 + c/4 phi^4, two that allow a soft and a hard solid, -d/5 phi^5 + e/6 phi^6, and any
further terms that are added there. The paper's terms are written out here. The sums of all others
are generated from the declarations; the compiler removes them where the coefficients are 0.
`solids.py` finds the phases.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_function
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS, ParameterVariable

_TERMS = [variable for variable in PARAMETERS.values() if variable.phi_power]
_PAPER = ("cubic_coefficient", "quartic_coefficient")
_OTHERS = [term for term in _TERMS if term.name not in _PAPER]

HIGHEST_POWER = max(term.phi_power for term in _TERMS)
"""The highest power of phi in the force on ln(phi)."""

HIGHER_COEFFICIENTS = tuple(term.name for term in _OTHERS)
"""The coefficients of terms beyond the paper's, which most films do not have."""


def _place(term: ParameterVariable) -> int:
    return Parameters._fields.index(term.name)


RESTORING = tuple((_place(t), t.phi_power) for t in _OTHERS if t.phi_sign > 0)
"""The terms beyond the paper's that bound the order parameter: index in `Parameters`, power."""


def _sum_of_others(name: str, weight: Callable[[int], float]) -> Any:
    """Return the inline function (p, phi) of the sum of all terms beyond the paper's.

    The sum uses Horner's scheme. Each term is the product of its sign, the `weight` of its power in
    the force on ln(phi), its coefficient and this power of phi.
    """
    total = "0.0"
    for power in range(HIGHEST_POWER, 0, -1):
        terms = (term for term in _OTHERS if term.phi_power == power)
        factors = (f" + {t.phi_sign * weight(power)!r} * p[{_place(t)}]" for t in terms)
        total = f"({total}{''.join(factors)}) * phi"
    return make_function(name, "p, phi", [f"return {total}"], {})


_energy_of_others = _sum_of_others("energy_of_others", lambda power: 1.0 / (power + 2))  # / phi^2
_force_of_others = _sum_of_others("force_of_others", lambda _: 1.0)
_slope_of_others = _sum_of_others("slope_of_others", float)

_NONZERO = "".join(f" | (p[{_place(term)}] != 0.0)" for term in _OTHERS)
_has_others = make_function("has_others", "p", [f"return False{_NONZERO}"], {})

_PLACES = tuple(_place(term) for term in _TERMS)
_POWERS = tuple(term.phi_power for term in _TERMS)
_SIGNS = tuple(float(term.phi_sign) for term in _TERMS)


@inline
def has_higher_terms(p: Parameters) -> bool:
    """Return whether the free energy has terms beyond the paper's."""
    return _has_others(p)


@inline
def balance_coefficient(p: Parameters, power: int) -> float:
    """Coefficient of a power of phi in the B of a stationary film [J/m3]."""
    total = 0.0
    for i in range(len(_PLACES)):
        total -= _SIGNS[i] * p[_PLACES[i]] if _POWERS[i] == power else 0.0
    return total


@inline
def heating(p: Parameters) -> float:
    """2 alpha (T - T_c) [J/m3]: the thermal part of the melting function, Eq. 15."""
    return 2.0 * p.thermal_coefficient * (p.temperature - p.critical_temperature)


@inline
def free_energy(p: Parameters, phi: float, eps: float) -> float:
    """Free energy density f(phi, eps) [J/m3], Eq. 12."""
    phi2 = phi * phi
    harmonic = 0.5 * melting_function(p, eps) * phi2
    cubic = p.cubic_coefficient / 3.0 * (phi2 * phi)
    low = harmonic - cubic + 0.25 * p.quartic_coefficient * (phi2 * phi2)
    return low + _energy_of_others(p, phi) * phi2 if has_higher_terms(p) else low


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
    """Melting function B [J/m3], Eq. 15: only solid at B <= 0, only liquid at B >= b^2/4c."""
    return p.elastic_coefficient * (eps * eps) + heating(p)


@inline
def log_force(p: Parameters, phi: float, B: float) -> float:
    """Force on ln(phi) [J/m3], Eqs. 12 and 26: (df/dphi)/phi = B - b phi + c phi^2 + ..."""
    low = B - p.cubic_coefficient * phi + p.quartic_coefficient * (phi * phi)
    return low + _force_of_others(p, phi) if has_higher_terms(p) else low


@inline
def log_force_slope(p: Parameters, phi: float) -> float:
    """Derivative of `log_force` with respect to ln(phi) [J/m3]."""
    low = phi * (2.0 * p.quartic_coefficient * phi - p.cubic_coefficient)
    return low + _slope_of_others(p, phi) if has_higher_terms(p) else low


@inline
def order_parameter_rate(p: Parameters, phi: float, B: float) -> float:
    """Deterministic rate of the order parameter [1/s], Eqs. 25 and 26 without noise."""
    return -p.kinetic_coefficient * phi * log_force(p, phi, B)
