"""Motions by the adaptive method, one drive period at a time: walks of `kernels/observation.py`."""

from __future__ import annotations

import numpy as np

from stickslip.kernels.adaptive.conversion import conversion_of
from stickslip.kernels.adaptive.passes import ATTEMPTED, MEASURE, OUTCOME, Queue
from stickslip.kernels.adaptive.queues import part_of, work_through
from stickslip.kernels.adaptive.tangents import Tangents
from stickslip.measure.accumulate import RECORD
from stickslip.model.models import model_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Physics
from stickslip.status import Status

PENDING = int(Status.PENDING)


class AdaptiveWalk:
    """The motions of points (n, parameters) from the states of a `queue`, by measuring passes.

    At the tolerance `rtol`, in at most `max_steps` a period.
    """

    def __init__(
        self, points: np.ndarray, queue: Queue, rtol: float, max_steps: int, physics: Physics
    ) -> None:
        self.points, self.rtol, self.max_steps, self.physics = points, rtol, max_steps, physics
        self.queue = self._lanes = part_of(queue, np.arange(len(points)))
        self.queue.counts[:, OUTCOME] = OK

    def states(self) -> np.ndarray:
        """Return the stroboscopic states (n, columns) in SI units, with the next step."""
        states = self.queue.states.copy()
        conversion_of(self.physics).restore_states(self.points, states)
        return states

    def next_period(self) -> np.ndarray:
        """Advance by a drive period; return its records (n, RECORD) in SI units."""
        self._lanes.counts[:, ATTEMPTED] = 0  # each period has the whole budget
        work_through(self._lanes, MEASURE, self.rtol, self.max_steps, self.physics, halves=2)
        records = np.empty((len(self.points), RECORD))
        conversion_of(self.physics).write_stretches(self.points, self.queue.measured, records)
        return records

    def part(self, which: np.ndarray) -> AdaptiveWalk:
        """Return the walk of these motions alone, from where they are."""
        rows = np.flatnonzero(which)
        queue = part_of(self.queue, rows)
        return AdaptiveWalk(self.points[rows], queue, self.rtol, self.max_steps, self.physics)

    def outcomes(self) -> np.ndarray:
        """Return the Status (n,) of each motion so far."""
        return self.queue.counts[:, OUTCOME].copy()


class StochasticWalk(AdaptiveWalk):
    """Motions with stochastic noise; the points of the queue have streams."""

    def next_period(self) -> np.ndarray:
        """Advance by a drive period, which has random numbers of its own."""
        records = super().next_period()
        self.queue.points[:, -1] += 1.0  # the last number of a stream: the drive period
        return records


class TangentWalk(AdaptiveWalk):
    """Motions with copies that carry tangents; both go through the lanes together."""

    def __init__(
        self, points: np.ndarray, queue: Queue, rtol: float, max_steps: int, physics: Physics
    ) -> None:
        super().__init__(points, queue, rtol, max_steps, physics)
        count = len(points)
        # One queue for motions and copies, so that lanes are full; both are views of it.
        self._lanes = part_of(self.queue, np.tile(np.arange(count), 2))
        self.queue = Queue(*(column[:count] for column in self._lanes))
        self._copies = Queue(*(column[count:] for column in self._lanes))
        self._tangents = Tangents(count, rtol, model_of(physics).components)

    def next_period(self) -> np.ndarray:
        """Advance the motions and copies displaced from them by a drive period."""
        self._copies.states[:] = self._tangents.displaced(self.queue.states)
        return super().next_period()

    def growth(self) -> np.ndarray:
        """Return the logarithms (n,) of the growth of tangents; NaN where a copy was lost."""
        growth = self._tangents.carried(self.queue.states, self._copies.states)
        return np.where(self._copies.counts[:, OUTCOME] != OK, np.nan, growth)

    def stop(self, which: np.ndarray) -> None:
        """Leave these motions where they are, with the outcome PENDING."""
        for queue in (self.queue, self._copies):
            queue.counts[which & (queue.counts[:, OUTCOME] == OK), OUTCOME] = PENDING
