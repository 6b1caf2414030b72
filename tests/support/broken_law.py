"""A law of friction whose measured stress is a tenth higher than the one that is integrated.

An orbit computed with it does not balance its power: it must not be believed.
"""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters

NAME = "measured-10-per-cent-high"
"""Tells what it computes: compiled code is cached under it, and edits of this file go unnoticed."""


@inline
def _stress(p: Parameters, u: float) -> float:
    return 1.1 * p.viscosity_coefficient / p.film_thickness * u


@inline
def _slope(p: Parameters, u: float) -> float:
    return p.viscosity_coefficient / p.film_thickness


@inline
def _rounded(p: Parameters, u: float, u_s: float) -> tuple[float, float]:
    slope = p.viscosity_coefficient / p.film_thickness
    return slope * u, slope


@inline
def _never(p: Parameters) -> bool:
    return False


@inline
def _scaled(p: Parameters, rate: float, stress: float) -> float:
    return p.viscosity_coefficient * rate / stress


LAW = FrictionLaw(
    name=NAME,
    stress=_stress,
    slope=_slope,
    rounded=_rounded,
    has_cusp=_never,
    thickens=_never,
    stable_slope=_slope,
    scaled={"viscosity_coefficient": _scaled},
    parameters=("viscosity_coefficient",),
)
