"""The paper's law with a viscosity that grows with the order parameter as 1 + kappa phi^2."""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.model.laws import FrictionLaw, power_law
from stickslip.parameters import Parameters

_paper_slope = power_law.LAW.stable_slope


@inline
def _growth(p: Parameters, phi: float) -> float:
    return 1.0 + p.viscosity_growth * (phi * phi)


@inline
def _stress(p: Parameters, u: float, phi: float) -> float:
    return _growth(p, phi) * power_law.viscous_stress(p, u, phi)


@inline
def _rounded(p: Parameters, u: float, phi: float, u_s: float) -> tuple[float, float, float]:
    stress, slope, _ = power_law.rounded_viscous_stress(p, u, phi, u_s)
    growth = _growth(p, phi)
    return growth * stress, growth * slope, 2.0 * (growth - 1.0) * stress


@inline
def _stable_slope(p: Parameters, u: float, phi: float) -> float:
    return _growth(p, phi) * _paper_slope(p, u, phi)


LAW = FrictionLaw(
    name="of-the-solid",
    stress=_stress,
    rounded=_rounded,
    has_cusp=power_law.LAW.has_cusp,
    stable_slope=_stable_slope,
    scaled=power_law.LAW.scaled,
    parameters=(*power_law.LAW.parameters, "viscosity_growth"),
    special_indices=power_law.LAW.special_indices,
)
