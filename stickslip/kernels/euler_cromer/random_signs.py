"""Stochastic noise in Euler-Cromer: in every step a kick of fixed size and random sign.

Two-point increments have the moments that weak convergence of first order requires (Kloeden and
Platen 1992, section 14.1), and one word of random bits serves SIGNS steps. Imported only for
stochastic films.
"""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.kernels.euler_cromer.layout import SLOTS
from stickslip.kernels.streams import (
    KEY_HIGH,
    KEY_LOW,
    PATH,
    PERIOD,
    SIGNS,
    STREAM,
    first_sign,
    signs,
)
from stickslip.numerics.euler_cromer_lanes import Chance, get, put

GROUP, _BITS = SLOTS + STREAM, SLOTS + STREAM + 1
"""Slots after the stream of a lane: groups of signs drawn in this period; remaining signs."""


@inline
def _refresh(lane: int, lanes: np.ndarray) -> None:
    low, high = get(lanes, SLOTS + KEY_LOW, lane), get(lanes, SLOTS + KEY_HIGH, lane)
    path, period = get(lanes, SLOTS + PATH, lane), get(lanes, SLOTS + PERIOD, lane)
    count = get(lanes, GROUP, lane)
    put(lanes, _BITS, lane, signs(low, high, path, period, count))
    put(lanes, GROUP, lane, count + 1.0)


@inline
def _draw(lanes: np.ndarray, lane: int) -> float:
    sign, others = first_sign(get(lanes, _BITS, lane))
    put(lanes, _BITS, lane, others)
    return sign


def signs_in_lanes() -> Chance:
    """Return random signs for lanes."""
    return Chance(SIGNS, _refresh, _draw)
