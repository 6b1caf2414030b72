"""Eyring's law of thermally activated flow, whose stress grows as asinh of the speed."""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters


@inline
def _stress(p: Parameters, u: float, phi: float) -> float:
    x = abs(u) / p.eyring_speed
    size = p.eyring_stress * math.log(x + math.sqrt(x * x + 1.0))
    return math.copysign(size, u)


@inline
def _slope(p: Parameters, u: float) -> float:
    x = u / p.eyring_speed
    return p.eyring_stress / p.eyring_speed / math.sqrt(x * x + 1.0)


@inline
def _rounded(p: Parameters, u: float, phi: float, u_s: float) -> tuple[float, float, float]:
    return _stress(p, u, phi), _slope(p, u), 0.0


@inline
def _never(p: Parameters) -> bool:
    return False


@inline
def _stable_slope(p: Parameters, u: float, phi: float) -> float:
    return _slope(p, 0.0)


LAW = FrictionLaw(
    name="eyring",
    stress=_stress,
    rounded=_rounded,
    has_cusp=_never,
    stable_slope=_stable_slope,
    parameters=("eyring_stress", "eyring_speed"),
)
