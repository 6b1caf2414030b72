"""Points taken from period to period by the march that a method supplies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from stickslip.kernels.plain_iteration.starts import states_of, write_starts, write_steps
from stickslip.model.state import STATE
from stickslip.numerics.adaptive import OK
from stickslip.options import Options, Physics
from stickslip.status import Status

NOT_STATIONARY = int(Status.NOT_STATIONARY)

WIDTH = len(STATE)
"""State variables: the strain follows instantly."""


class March(Protocol):
    """Points (n,) that a method takes through drive periods with a fixed step."""

    def states(self) -> np.ndarray:
        """Return the current states (x, v, phi) in SI units, (n, 3)."""
        ...

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        """Take the points with the indices `which` (m,) through a drive period from phase 0.

        Each in at most `limits` (m,) steps, with a record if `measured`. Returns the Status (m,):
        OK at the end of the period, STEP_LIMIT or DIVERGED.
        """
        ...

    def clear_records(self, which: np.ndarray) -> None:
        """Clear the records of the points with the indices `which` (m,)."""
        ...

    def records(self, closed: bool = True) -> np.ndarray:
        """Return the records (n, RECORD) in SI units, of orbits if `closed`, else of stretches."""
        ...


MakeMarch = Callable[[np.ndarray, np.ndarray, np.ndarray, Physics], March]
"""(points, steps, states, physics): the march of points (n, parameters) in SI units from the states
(n, 3), (x, v, phi), at phase 0, with `steps` (n,) a drive period."""


class Motions:
    """The motions of points (n, parameters): their `march`, and per point `periods` and `status`.

    `starts` (n, columns) are initial states, as finals; a row of NaN stands for the point's own.
    The status is NOT_STATIONARY until the outcome is known.
    """

    def __init__(
        self, make_march: MakeMarch, points: np.ndarray, starts: np.ndarray, options: Options
    ) -> None:
        count, settings = len(points), options.settings()
        self.points, self.physics = points, options.physics
        self._steps, states = np.empty(count, np.int64), np.empty((count, WIDTH))
        write_steps(points, settings.dt, self._steps)
        write_starts(points, states)
        elsewhere = ~np.isnan(starts[:, 0])
        states[elsewhere] = states_of(starts[elsewhere])
        self.march = make_march(points, self._steps, states, options.physics)
        self._left = np.full(count, settings.max_steps)
        self.periods = np.zeros(count, np.int64)
        self.status = np.full(count, NOT_STATIONARY)

    def next_period(self, which: np.ndarray, *, measured: bool) -> np.ndarray:
        """Take some points (m,) through a period; return those that did not fail."""
        self.periods[which] += 1
        outcome = self.march.period(which, self._left[which], measured=measured)
        self._left[which] -= self._steps[which]
        self.status[which[outcome != OK]] = outcome[outcome != OK]
        return which[outcome == OK]
