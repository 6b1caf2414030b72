"""Laws of the viscous stress, one file each, with everything that other code needs of a law."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any

from stickslip.options import FRICTION_LAWS


@dataclass(frozen=True)
class FrictionLaw:
    """A law of the viscous stress, in inline functions of the parameters `p`.

    The code that integrates, measures, scales or bounds the friction uses these alone. The stress
    is odd in the relative velocity `u`; its size decreases neither with that nor with the order
    parameter `phi`. The functions are called in SI units and in those of `model/scaling.py`, so
    dimensional numbers must come from `p`.
    """

    name: str

    stress: Callable[..., float]
    """(p, u, phi): viscous stress [Pa], exact."""

    rounded: Callable[..., tuple[float, float, float]]
    """(p, u, phi, u_s): stress and its derivatives with respect to `u` [Pa s/m] and ln(phi) [Pa],
    with a cusp at u = 0 rounded for |u| < u_s. This is what is integrated. Far from the cusp, and
    for u_s = 0, it equals `stress` (a test compares them); an infinite slope is huge but finite."""

    has_cusp: Callable[..., bool]
    """(p): whether the slope is infinite at u = 0."""

    stable_slope: Callable[..., float]
    """(p, u, phi): the largest slope with respect to `u` [Pa s/m] up to this speed and order
    parameter, except at a cusp: it bounds an explicit step."""

    scaled: Mapping[str, Callable[..., float]] = field(default_factory=dict)
    """Parameters that do not scale by their unit: name -> function of (p, rate, stress) that gives
    the value in units of strain rate `rate` [1/s] and `stress` [Pa]."""

    parameters: tuple[str, ...] = ()
    """The parameters that this law uses, including those it shares with other laws."""

    special_indices: tuple[float, ...] = ()
    """Rheological indices with specialised kernels, in which powers are roots."""


@cache
def friction_law(name: str) -> FrictionLaw:
    """Return the law of this name in `options.FRICTION_LAWS`; raises KeyError for another."""
    law: Any = import_module(FRICTION_LAWS[name]).LAW
    return law
