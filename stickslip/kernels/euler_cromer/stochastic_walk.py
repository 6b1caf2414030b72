"""Euler-Cromer with stochastic noise, one drive period at a time; imported only where needed."""

from __future__ import annotations

from functools import partial

import numpy as np

from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.layout import SLOTS
from stickslip.kernels.euler_cromer.random_signs import GROUP
from stickslip.kernels.plain_iteration.march import PlainMarch, PlainWalk
from stickslip.kernels.streams import PERIOD, SIGNS, STREAM
from stickslip.options import Options, Physics


class _RandomMarch(March):
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
        """Take the points through a period as `March` does, by its own random numbers."""
        rows = self.tasks.rows
        rows[:, GROUP] = 0.0  # random numbers count within a drive period
        outcome = super().period(which, limits // SIGNS * SIGNS, measured=measured)
        rows[:, SLOTS + PERIOD] += 1.0
        return outcome


def make_stochastic_walk(
    points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
) -> PlainWalk:
    """Return motions with stochastic noise; arguments as in `adaptive.driver.stochastic_walk`."""
    march = PlainMarch(partial(_RandomMarch, streams), points, starts, options)
    return march.walk(np.arange(len(points)))
