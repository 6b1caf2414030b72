"""Motions that the march of a method takes from period to period, and their walks."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from stickslip.compiled.decorators import kernel
from stickslip.kernels.adaptive.tangents import Tangents, travelled
from stickslip.kernels.families import Family
from stickslip.kernels.orbits import watching
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import ATTEMPTED, DONE, OUTCOME, motions_of
from stickslip.kernels.parameter_rows import FIRST_STEP, parameters_of
from stickslip.model import drive
from stickslip.model.rhs import starting_state
from stickslip.model.state import STATE
from stickslip.numerics.adaptive import OK
from stickslip.options import Options, Physics
from stickslip.status import Status

PENDING = int(Status.PENDING)

WIDTH = len(STATE)
"""The number of state variables; the strain follows instantly."""

_LEAST = float(np.finfo(float).tiny)


class March(Protocol):
    """Points (n,) that a method takes through drive periods with a fixed step."""

    def states(self) -> np.ndarray:
        """Return the present states (x, v, phi) in SI units, (n, 3)."""

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        """Take the points with the indices `which` (m,) through a drive period from phase 0.

        Each takes at most `limits` (m,) steps, with a record if `measured`. Return the Status (m,),
        which is OK at the end of the period, or STEP_LIMIT or DIVERGED.
        """

    def clear_records(self, which: np.ndarray) -> None:
        """Clear the records of the points with the indices `which` (m,)."""

    def records(self, closed: bool = True) -> np.ndarray:
        """Return the records (n, RECORD) in SI units, of orbits if `closed`, else of stretches."""


MakeMarch = Callable[[np.ndarray, np.ndarray, np.ndarray, Physics], March]
"""(points, steps, states, physics) -> the march of points (n, parameters) in SI units from states
(n, 3), (x, v, phi), at phase 0, with `steps` (n,) per drive period."""


class PlainMarch:
    """The motions of points (n, parameters), which a march advances by whole drive periods.

    `starts` (n, columns) are initial states, as finals; a row of NaN stands for the start of the
    point. `own` is the march of the method, and `periods` (n,) counts its periods.
    """

    per_period = 1

    def __init__(
        self, make_march: MakeMarch, points: np.ndarray, starts: np.ndarray, options: Options
    ) -> None:
        count, settings = len(points), options.settings()
        self.points, self.physics = points, options.physics
        self.motions = motions_of(points, options.physics.typical, starts)
        self._steps, states = np.empty(count, np.int64), np.empty((count, WIDTH))
        write_steps(points, settings.dt, self._steps)
        write_starts(points, states)
        elsewhere = ~np.isnan(starts[:, 0])
        given = starts[elsewhere]
        states[elsewhere] = np.column_stack([given[:, 0], given[:, 1], np.exp(given[:, 2])])
        self.own = make_march(points, self._steps, states, options.physics)
        self._left = np.full(count, settings.max_steps)
        self.periods = np.zeros(count, np.int64)

    def advance(self, family: Family) -> Callable[[np.ndarray], np.ndarray]:  # noqa: ARG002 - March
        """Return the function that takes all given rows (m,) a period further."""

        def period(which: np.ndarray) -> np.ndarray:
            self.next_period(which, measured=False)
            finals = np.ascontiguousarray(self.finals()[which])
            conversion_of(self.physics.typical).scale_states(self.points[which], finals)
            self.motions.ahead[which, 0, : WIDTH + 1] = finals
            self.motions.counts[which, DONE] = self.motions.counts[which, OUTCOME] == OK
            return which

        return period

    def next_period(self, which: np.ndarray, *, measured: bool) -> np.ndarray:
        """Take some points (m,) through a period; return the points that did not fail."""
        counts = self.motions.counts
        self.periods[which] += 1
        outcome = self.own.period(which, self._left[which], measured=measured)
        self._left[which] -= self._steps[which]
        counts[which, ATTEMPTED] += self._steps[which]
        counts[which, OUTCOME] = outcome
        return which[outcome == OK]

    def finals(self) -> np.ndarray:
        """Return the present states (n, columns) as in finals, in SI units, with the next step."""
        return finals_of(self.points, self.own.states())

    def walk(self, rows: np.ndarray) -> PlainWalk:
        """Return the motions in these rows (m,), which advance by drive periods."""
        return PlainWalk(self, rows)

    def rejoin(self, rows: np.ndarray, walk: PlainWalk) -> None:
        """Do nothing, as a walk has moved the motions."""


class PlainWalk:
    """The `rows` (m,) of a march, which go on from their present states.

    The adaptive method integrates the tangents from each state over a period.
    """

    def __init__(self, march: PlainMarch, rows: np.ndarray) -> None:
        self._march, self._rows, self._points = march, rows, march.points[rows]
        march.motions.counts[rows, OUTCOME] = OK
        self._before = self.states()
        self._tangents = Tangents(len(rows), watching.RTOL, STATE)

    def states(self) -> np.ndarray:
        """Return the stroboscopic states (m, columns) in SI units, with the next step."""
        return self._march.finals()[self._rows]

    def next_period(self) -> np.ndarray:
        """Advance by a drive period; return its records (m, RECORD) in SI units."""
        own, alive = self._march.own, self._rows[self.outcomes() == OK]
        self._before = self.states()
        own.clear_records(alive)
        self._march.next_period(alive, measured=True)
        return own.records(closed=False)[self._rows]

    def part(self, which: np.ndarray) -> PlainWalk:
        """Return the walk of these motions only, from their present states."""
        return PlainWalk(self._march, self._rows[which])

    def growth(self) -> np.ndarray:
        """Return the logarithms (m,) of the growth of tangent vectors over the last period."""
        physics, n = self._march.physics, len(self._rows)
        points, states = self._march.motions.points[self._rows], self._before.copy()
        conversion_of(physics).scale_states(self._points, states)
        both = np.concatenate([states, self._tangents.displaced(states)])
        periods, rtol = np.full(2 * n, 2), watching.RTOL
        ends = travelled(np.tile(points, (2, 1)), both, periods, rtol, physics)
        return self._tangents.carried(ends[:n], ends[n:])

    def outcomes(self) -> np.ndarray:
        """Return the Status (m,) of each motion so far."""
        return self._march.motions.counts[self._rows, OUTCOME]

    def stop(self, which: np.ndarray) -> None:
        """Stop these motions where they are, with the outcome PENDING."""
        stopped = self._rows[which & (self.outcomes() == OK)]
        self._march.motions.counts[stopped, OUTCOME] = PENDING


# --- starts of periods ----------------------------------------------------------------------------


@kernel
def write_steps(points: np.ndarray, dt: float, steps: np.ndarray) -> None:
    """Write the number of equal steps per period, each of at most `dt`."""
    for i in range(points.shape[0]):
        steps[i] = math.ceil(drive.period(parameters_of(points[i])) / dt)


@kernel
def write_starts(points: np.ndarray, states: np.ndarray) -> None:
    """Write the starts (x, v, phi) of points (n, parameters), in SI units, into `states` (n, 3)."""
    for i in range(points.shape[0]):
        x, v, psi = starting_state(parameters_of(points[i]))
        states[i, 0], states[i, 1], states[i, 2] = x, v, math.exp(psi)


def finals_of(points: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return states (n, 3), (x, v, phi), as finals (n, columns), (x, v, ln phi) and next step."""
    finals = np.empty((len(points), states.shape[1] + 1))
    _write_finals(points, states, finals)
    return finals


@kernel
def _write_finals(points: np.ndarray, states: np.ndarray, finals: np.ndarray) -> None:
    for i in range(finals.shape[0]):
        finals[i, 0], finals[i, 1] = states[i, 0], states[i, 1]
        finals[i, 2] = math.log(max(states[i, 2], _LEAST))  # phi of a liquid film underflows
        finals[i, 3] = FIRST_STEP * drive.period(parameters_of(points[i]))
