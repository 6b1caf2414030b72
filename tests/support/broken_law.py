"""A law of friction under which orbits are integrated, and measured as if it were another.

Its stress is a tenth higher than that of the power law at gamma = 0, by which `measured_otherwise`
has it measured. An orbit computed so does not balance its power: it must not be believed.
"""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.kernels.problem import ProblemFunctions, problem_functions
from stickslip.model.laws import FrictionLaw
from stickslip.model.models import model_of
from stickslip.options import Physics
from stickslip.parameters import Parameters

NAME = "integrated-10-per-cent-high"
"""Tells what it computes: compiled code is cached under it, and edits of this file go unnoticed."""


@inline
def _stress(p: Parameters, u: float, phi: float) -> float:
    return 1.1 * p.viscosity_coefficient / p.film_thickness * u


@inline
def _slope(p: Parameters, u: float, phi: float) -> float:
    return 1.1 * p.viscosity_coefficient / p.film_thickness


@inline
def _rounded(p: Parameters, u: float, phi: float, u_s: float) -> tuple[float, float, float]:
    slope = 1.1 * p.viscosity_coefficient / p.film_thickness
    return slope * u, slope, 0.0


@inline
def _never(p: Parameters) -> bool:
    return False


@inline
def _scaled(p: Parameters, rate: float, stress: float) -> float:
    return p.viscosity_coefficient * rate / stress


LAW = FrictionLaw(
    name=NAME,
    stress=_stress,
    rounded=_rounded,
    has_cusp=_never,
    stable_slope=_slope,
    scaled={"viscosity_coefficient": _scaled},
    parameters=("viscosity_coefficient",),
)


def measured_otherwise(physics: Physics) -> ProblemFunctions:
    """What `problem_functions` is replaced by."""
    return problem_functions(physics)._replace(equations=model_of(Physics("power-law")).equations)
