"""Some motions of a plain iteration, one drive period at a time: a walk of observation.py."""

from __future__ import annotations

import numpy as np

from stickslip.kernels import observation
from stickslip.kernels.adaptive.conversion import conversion_of
from stickslip.kernels.adaptive.queues import reduced_queue
from stickslip.kernels.adaptive.tangents import Tangents, travelled
from stickslip.kernels.plain_iteration.motions import WIDTH, Motions
from stickslip.kernels.plain_iteration.starts import write_finals
from stickslip.model.state import STATE
from stickslip.numerics.adaptive import OK
from stickslip.status import Status

PENDING = int(Status.PENDING)


class PlainWalk:
    """The `rows` (m,) of some motions, which go on from their present states.

    The adaptive method carries the tangents, from each state to a period later.
    """

    def __init__(self, motions: Motions, rows: np.ndarray) -> None:
        self._motions, self._rows, self._points = motions, rows, motions.points[rows]
        motions.status[rows] = OK
        self._before = self.states()
        self._tangents = Tangents(len(rows), observation.RTOL, STATE)

    def states(self) -> np.ndarray:
        """Return the stroboscopic states (m, columns) in SI units, with the next step."""
        finals = np.empty((len(self._rows), WIDTH + 1))
        write_finals(self._points, self._motions.march.states()[self._rows], finals)
        return finals

    def next_period(self) -> np.ndarray:
        """Advance by a drive period; return its records (m, RECORD) in SI units."""
        march, alive = self._motions.march, self._rows[self.outcomes() == OK]
        self._before = self.states()
        march.clear_records(alive)
        self._motions.next_period(alive, measured=True)
        return march.records(closed=False)[self._rows]

    def part(self, which: np.ndarray) -> PlainWalk:
        """Return the walk of these motions alone, from where they are."""
        return PlainWalk(self._motions, self._rows[which])

    def growth(self) -> np.ndarray:
        """Return the logarithms (m,) of the growth of tangent vectors over the last period."""
        physics, n = self._motions.physics, len(self._rows)
        reduced, states = reduced_queue(self._points, physics).points, self._before.copy()
        conversion_of(physics).scale_states(self._points, states)
        both = np.concatenate([states, self._tangents.displaced(states)])
        periods, rtol = np.full(2 * n, 2), observation.RTOL
        ends = travelled(np.tile(reduced, (2, 1)), both, periods, rtol, physics)
        return self._tangents.carried(ends[:n], ends[n:])

    def outcomes(self) -> np.ndarray:
        """Return the Status (m,) of each motion so far."""
        return self._motions.status[self._rows]

    def stop(self, which: np.ndarray) -> None:
        """Leave these motions where they are, with the outcome PENDING."""
        self._motions.status[self._rows[which & (self.outcomes() == OK)]] = PENDING
