"""Euler-Cromer with stochastic noise, one drive period at a time; imported only where needed."""

from __future__ import annotations

import numpy as np

from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.layout import SLOTS
from stickslip.kernels.euler_cromer.random_signs import GROUP
from stickslip.kernels.plain_iteration.starts import states_of, write_finals, write_steps
from stickslip.kernels.streams import PERIOD, SIGNS, STREAM
from stickslip.model.state import STATE
from stickslip.numerics.adaptive import OK, STEP_LIMIT
from stickslip.options import Options


class StochasticWalk:
    """Paths (n,) that advance one drive period at a time: a walk of observation.py.

    `points` (n, parameters) in SI units; `starts` (n, columns) as finals; `streams` (n, STREAM)
    distinguish their random numbers.
    """

    def __init__(
        self, points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
    ) -> None:
        self.points, self.options = points, options
        self.steps = np.empty(len(points), np.int64)
        write_steps(points, options.dt, self.steps)
        self.steps += -self.steps % SIGNS  # a whole number of groups of steps
        self.march = March(points, self.steps, states_of(starts), options.physics)
        self.march.tasks.rows[:, SLOTS : SLOTS + STREAM] = streams
        self._left = np.full(len(points), options.settings().max_steps)
        self._status = np.full(len(points), OK)

    def states(self) -> np.ndarray:
        """Return the stroboscopic states (n, columns) in SI units, with the next step."""
        finals = np.empty((len(self.points), len(STATE) + 1))
        write_finals(self.points, self.march.states(), finals)
        return finals

    def next_period(self) -> np.ndarray:
        """Advance by a drive period; return its records (n, RECORD) in SI units."""
        self._status[(self._status == OK) & (self._left < self.steps)] = STEP_LIMIT
        alive = np.flatnonzero(self._status == OK)
        tasks = self.march.tasks
        tasks.rows[:, GROUP] = 0.0  # random numbers count within a drive period
        self.march.clear_records(alive)
        self.march.start(alive)
        self.march.march(measured=True)
        self._status[alive] = tasks.status[alive]
        self._left[alive] -= self.steps[alive]
        tasks.rows[:, SLOTS + PERIOD] += 1.0
        return self.march.records(closed=False)

    def outcomes(self) -> np.ndarray:
        """Return the Status (n,) of each path so far."""
        return self._status.copy()
