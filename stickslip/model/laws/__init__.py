"""Laws of the viscous stress: one file each, which declares all that the rest asks of a law."""

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

    Whatever integrates, measures, scales or bounds the friction asks these and nothing else. The
    stress is odd in the relative velocity `u`; its size falls neither with that nor with the order
    parameter `phi`. They are called in SI units and in those of `model/scaling.py`: numbers with
    units come from `p` alone.
    """

    name: str

    stress: Callable[..., float]
    """(p, u, phi): viscous stress [Pa], exact."""

    rounded: Callable[..., tuple[float, float, float]]
    """(p, u, phi, u_s): stress and its derivatives over `u` [Pa s/m] and over ln(phi) [Pa], with a
    cusp at u = 0 rounded for |u| < u_s: what is integrated. Far from the cusp, and with u_s = 0, it
    is `stress` (a test compares them); a slope that is infinite is huge."""

    has_cusp: Callable[..., bool]
    """(p): whether the slope is infinite at u = 0."""

    stable_slope: Callable[..., float]
    """(p, u, phi): the largest slope over `u` up to this speed and order parameter [Pa s/m], a cusp
    left out: it bounds an explicit step."""

    scaled: Mapping[str, Callable[..., float]] = field(default_factory=dict)
    """The law's parameters in other units, where those of their unit do not tell how: name ->
    function of (p, rate, stress) for units of strain rate [1/s] and stress [Pa]."""

    parameters: tuple[str, ...] = ()
    """The parameters that this law uses, those that it shares with others too."""

    special_indices: tuple[float, ...] = ()
    """Rheological indices that have kernels of their own, in which powers are roots."""


@cache
def friction_law(name: str) -> FrictionLaw:
    """The law of this name among `options.FRICTION_LAWS`; raises KeyError for another."""
    law: Any = import_module(FRICTION_LAWS[name]).LAW
    return law
