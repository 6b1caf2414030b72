"""The adaptive method a drive period at a time: the walk of `kernels/observation.py`."""

from __future__ import annotations

import numpy as np

from stickslip.kernels.adaptive import conversion
from stickslip.kernels.adaptive.passes import ATTEMPTED, CYCLE, OUTCOME, Pass, Queue
from stickslip.kernels.adaptive.queues import part_of, work_through
from stickslip.kernels.adaptive.tangents import Tangents
from stickslip.measure.accumulate import RECORD
from stickslip.numerics.adaptive import OK


class AdaptiveWalk:
    """Points (n, parameters) on their way, from the states of a `queue`, by measuring passes.

    The copies that carry the tangents go through the lanes together with them.
    """

    def __init__(self, points: np.ndarray, queue: Queue, measuring: Pass, law: str) -> None:
        self.points, self.measuring, self.law = points, measuring, law
        self._count = len(points)
        self._both = part_of(queue, np.tile(np.arange(self._count), 2))
        self._both.counts[:, CYCLE], self._both.counts[:, OUTCOME] = 2, OK
        self._tangents = Tangents(self._count, measuring.rtol)

    @property
    def queue(self) -> Queue:
        """That of the points, as it is now."""
        return part_of(self._both, np.arange(self._count))

    def states(self) -> np.ndarray:
        """As `observation.Walk`."""
        states = self.queue.states
        conversion.restore_states(self.points, states)
        return states

    def next_period(self) -> np.ndarray:
        """As `observation.Walk`."""
        states = self._both.states
        self._both.counts[:, ATTEMPTED] = 0  # each period has the whole budget
        states[self._count :] = self._tangents.displaced(states[: self._count])
        work_through(self._both, self.measuring, self.law)
        records = np.empty((self._count, RECORD))
        conversion.write_stretches(self.points, self._both.measured[: self._count], records)
        return records

    def growth(self) -> np.ndarray:
        """As `observation.Walk`; not a number where a copy was lost."""
        states, lost = self._both.states, self._both.counts[self._count :, OUTCOME] != OK
        growth = self._tangents.carried(states[: self._count], states[self._count :])
        return np.where(lost, np.nan, growth)

    def outcomes(self) -> np.ndarray:
        """As `observation.Walk`."""
        return self._both.counts[: self._count, OUTCOME].copy()
