"""Stochastic noise in Euler-Cromer, a kick of fixed size and random sign in every step.

Two-point increments have the moments that weak convergence of first order requires (Kloeden and
Platen 1992, section 14.1), and one word of random bits is enough for SIGNS steps. Only stochastic
films import this module.
"""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.kernels.euler_cromer.lanes import March
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
from stickslip.options import Physics

GROUP, _BITS = SLOTS + STREAM, SLOTS + STREAM + 1
"""Two slots after the stream of a lane, for the groups of signs drawn in this period and for the
remaining signs."""


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


SIGNS_IN_LANES = Chance(SIGNS, _refresh, _draw)
"""The random signs of lanes."""


class StochasticMarch(March):
    """A march with the random numbers of `streams` (n, STREAM), in whole groups of steps."""

    def __init__(
        self,
        streams: np.ndarray,
        points: np.ndarray,
        steps: np.ndarray,
        states: np.ndarray,
        physics: Physics,
    ) -> None:
        steps += -steps % SIGNS  # in place: the budget of the motions counts these steps
        super().__init__(points, steps, states, physics)
        self.tasks.rows[:, SLOTS : SLOTS + STREAM] = streams

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        """Take the points through a period as `March` does, with the period's random numbers."""
        rows = self.tasks.rows
        rows[:, GROUP] = 0.0  # random numbers are counted within a drive period
        outcome = super().period(which, limits // SIGNS * SIGNS, measured=measured)
        rows[:, SLOTS + PERIOD] += 1.0
        return outcome
