"""The lubricant film: free energy, elasticity and kinetics (Eqs. 12-15, 25, 26).

The terms of the free energy are declared with their coefficients in `variables.py`: those of the
paper, -b/3 phi^3 + c/4 phi^4, those that let a soft solid exist beside a hard one, -d/5 phi^5 +
e/6 phi^6, and whatever is added there. The paper's stand here as equations; the sums of all others
are written from their declarations, and the compiler leaves them out where the coefficients are 0.
`solids.py` finds the phases.
"""

from __future__ import annotations

from typing import Any

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_function, make_map
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS

_TERMS = [variable for variable in PARAMETERS.values() if variable.phi_power]
_PAPER = ("cubic_coefficient", "quartic_coefficient")
_OTHERS = [term for term in _TERMS if term.name not in _PAPER]

HIGHEST_POWER = max(term.phi_power for term in _TERMS)
"""The highest power of phi in the force on ln(phi)."""

HIGHER_COEFFICIENTS = tuple(term.name for term in _OTHERS)
"""The coefficients of the terms that the paper, and most films, do without."""


def _sum_of_others(name: str, weighed: str) -> Any:
    """The inline function (p, phi) of the sum of the others' terms, nested: one product a power.

    A term is its sign times what is `weighed`, written with its coefficient {k}, its power {n} in
    the force on ln(phi) and its {degree} in the free energy, times phi^n.
    """
    powers, nested = [term.phi_power for term in _OTHERS], ""
    for power in range(max(powers), min(powers) - 1, -1):
        terms = [
            ("+ " if term.phi_sign > 0 else "- ")
            + weighed.format(k=f"p.{term.name}", n=power, degree=power + 2)
            for term in _OTHERS
            if term.phi_power == power
        ]
        nested = " ".join([f"phi * ({nested})", *terms] if nested else terms)
    lowest = " * ".join(["phi"] * min(powers))
    return make_function(name, "p, phi", [f"return ({nested}) * ({lowest})"], {})


_energy_of_others = _sum_of_others("energy_of_others", "{k} / {degree}.0")  # over phi^2
_force_of_others = _sum_of_others("force_of_others", "{k}")
_slope_of_others = _sum_of_others("slope_of_others", "{n}.0 * {k}")

has_higher_terms = make_function(
    "has_higher_terms",
    "p",
    [f"return {' | '.join(f'(p.{name} != 0.0)' for name in HIGHER_COEFFICIENTS)}"],
    {},
)
"""Inline (p): whether the free energy has terms that the paper does without."""


def _in_balance(power: int) -> str:
    """What multiplies this power of phi in the balance: the force on ln(phi) with another sign."""
    terms = [term for term in _TERMS if term.phi_power == power]
    signed = [f"{'- ' if term.phi_sign > 0 else '+ '}p.{term.name}" for term in terms]
    return " ".join(signed) or "0.0"


balance_coefficients = make_map(
    "balance_coefficients",
    "p",
    [_in_balance(power + 1) for power in range(HIGHEST_POWER)],
    {},
)
"""Inline (p): by what phi, phi^2, ... are multiplied in the B under which a film is stationary."""

restoring_terms = make_map(
    "restoring_terms",
    "p",
    [f"(p.{term.name}, {term.phi_power}.0)" for term in _OTHERS if term.phi_sign > 0],
    {},
)
"""Inline (p): the others' coefficients that bound the order parameter, each with its power."""


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
    """Melting function B [J/m3], Eq. 15: solid only at B <= 0, liquid only at B >= b^2/4c."""
    return p.elastic_coefficient * (eps * eps) + heating(p)


@inline
def log_force(p: Parameters, phi: float, B: float) -> float:
    """(df/dphi)/phi = B - b phi + c phi^2 and the others [J/m3]: the force on ln(phi).

    Eqs. 12 and 26.
    """
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
