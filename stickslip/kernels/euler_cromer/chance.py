"""Euler-Cromer with noise by chance: a kick of one size and a random sign every step.

Two-point increments have the moments that weak convergence of first order asks for (Kloeden and
Platen 1992, section 14.1), and one word of random bits serves SIGNS steps. Imported where a
stochastic film is asked for.
"""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.kernels.euler_cromer import judging
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.layout import SLOTS, write_steps
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
from stickslip.model.state import STATE
from stickslip.numerics.adaptive import OK, STEP_LIMIT
from stickslip.numerics.euler_cromer_lanes import Chance, get, put
from stickslip.options import Options

_GROUP, _BITS = SLOTS + STREAM, SLOTS + STREAM + 1


@inline
def _refresh(lane: int, lanes: np.ndarray) -> None:
    low, high = get(lanes, SLOTS + KEY_LOW, lane), get(lanes, SLOTS + KEY_HIGH, lane)
    path, period = get(lanes, SLOTS + PATH, lane), get(lanes, SLOTS + PERIOD, lane)
    count = get(lanes, _GROUP, lane)
    put(lanes, _BITS, lane, signs(low, high, path, period, count))
    put(lanes, _GROUP, lane, count + 1.0)


@inline
def _draw(lanes: np.ndarray, lane: int) -> float:
    sign, others = first_sign(get(lanes, _BITS, lane))
    put(lanes, _BITS, lane, others)
    return sign


def signs_in_lanes() -> Chance:
    """The random signs of lanes."""
    return Chance(SIGNS, _refresh, _draw)


class StochasticWalk:
    """Paths (n,) on their way, a drive period at a time: the walk of observation.py.

    `points` (n, parameters) in SI units; `starts` (n, columns) as finals; `streams` (n, STREAM)
    tell their random numbers apart.
    """

    def __init__(
        self, points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
    ) -> None:
        self.points, self.options = points, options
        self.steps = np.empty(len(points), np.int64)
        write_steps(points, options.dt, self.steps)
        self.steps += -self.steps % SIGNS  # whole groups
        self.march = March(points, self.steps, judging.states_of(starts), options.physics)
        self.march.tasks.rows[:, SLOTS : SLOTS + STREAM] = streams
        self._left = np.full(len(points), options.settings().max_steps)
        self._status = np.full(len(points), OK)

    def states(self) -> np.ndarray:
        """As `observation.Walk`."""
        finals = np.empty((len(self.points), len(STATE) + 1))
        judging.write_finals(self.points, self.march.states(), finals)
        return finals

    def next_period(self) -> np.ndarray:
        """As `observation.Walk`."""
        self._status[(self._status == OK) & (self._left < self.steps)] = STEP_LIMIT
        alive = np.flatnonzero(self._status == OK)
        tasks = self.march.tasks
        tasks.rows[:, _GROUP] = 0.0
        self.march.clear_records(alive)
        self.march.start(alive)
        self.march.march(measured=True)
        self._status[alive] = tasks.status[alive]
        self._left[alive] -= self.steps[alive]
        tasks.rows[:, SLOTS + PERIOD] += 1.0
        return self.march.records(closed=False)

    def outcomes(self) -> np.ndarray:
        """As `observation.Walk`."""
        return self._status.copy()
