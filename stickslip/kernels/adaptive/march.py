"""The march of the adaptive method by half periods, and its walks by drive periods."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stickslip.kernels.adaptive.passes import (
    MEASURE,
    SEARCH,
    InLanes,
    Pass,
    work_through,
)
from stickslip.kernels.adaptive.tangents import Tangents
from stickslip.kernels.families import Family
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import ATTEMPTED, OUTCOME, Motions, part_of, put_back
from stickslip.measure.accumulate import RECORD
from stickslip.model.models import model_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Physics
from stickslip.status import Status

PENDING = int(Status.PENDING)


class AdaptiveMarch:
    """The motions of points (n, parameters), each in at most `max_steps` altogether.

    Walks of some motions have the tolerance `watched`.
    """

    per_period = 2

    def __init__(
        self,
        points: np.ndarray,
        motions: Motions,
        physics: Physics,
        max_steps: int,
        watched: float = np.nan,
    ) -> None:
        self.points, self.motions, self.physics = points, motions, physics
        self._max_steps, self._watched = max_steps, watched

    def advance(self, family: Family) -> Callable[[np.ndarray], np.ndarray]:
        """Return the function that takes rows half a period further, as in `March`."""
        return InLanes(self.motions, family, Pass(SEARCH, 0, self._max_steps)).go_on

    def walk(self, rows: np.ndarray) -> TangentWalk:
        """Return the motions in these rows (m,), which advance by drive periods."""
        own = part_of(self.motions, rows)
        return TangentWalk(self.points[rows], own, self._watched, self._max_steps, self.physics)

    def rejoin(self, rows: np.ndarray, walk: TangentWalk) -> None:
        """Let the motions in these rows (m,) go on from the states of a walk."""
        put_back(self.motions, rows, walk.motions)


class AdaptiveWalk:
    """The motions of points (n, parameters) from their present states, by measuring passes.

    Each period has the tolerance `rtol` and takes at most `max_steps`.
    """

    def __init__(
        self, points: np.ndarray, motions: Motions, rtol: float, max_steps: int, physics: Physics
    ) -> None:
        self.points, self.rtol, self.max_steps, self.physics = points, rtol, max_steps, physics
        self.motions = self._all = part_of(motions, np.arange(len(points)))
        self.motions.counts[:, OUTCOME] = OK

    def states(self) -> np.ndarray:
        """Return the stroboscopic states (n, columns) in SI units, with the next step."""
        states = self.motions.states.copy()
        conversion_of(self.physics).restore_states(self.points, states)
        return states

    def next_period(self) -> np.ndarray:
        """Advance by a drive period; return its records (n, RECORD) in SI units."""
        self._all.counts[:, ATTEMPTED] = 0  # each period has the whole budget
        work_through(self._all, MEASURE, self.rtol, self.max_steps, self.physics, halves=2)
        records = np.empty((len(self.points), RECORD))
        conversion_of(self.physics).write_stretches(self.points, self.motions.measured, records)
        return records

    def part(self, which: np.ndarray) -> AdaptiveWalk:
        """Return the walk of these motions only, from their present states."""
        rows = np.flatnonzero(which)
        motions = part_of(self.motions, rows)
        return AdaptiveWalk(self.points[rows], motions, self.rtol, self.max_steps, self.physics)

    def outcomes(self) -> np.ndarray:
        """Return the Status (n,) of each motion so far."""
        return self.motions.counts[:, OUTCOME].copy()


class StochasticWalk(AdaptiveWalk):
    """Motions with stochastic noise, whose points have streams."""

    def next_period(self) -> np.ndarray:
        """Advance by a drive period, with the random numbers of that period."""
        records = super().next_period()
        self.motions.points[:, -1] += 1.0  # the last number of a stream: the drive period
        return records


class TangentWalk(AdaptiveWalk):
    """Motions with displaced copies that carry tangents; both share the lanes."""

    def __init__(
        self, points: np.ndarray, motions: Motions, rtol: float, max_steps: int, physics: Physics
    ) -> None:
        super().__init__(points, motions, rtol, max_steps, physics)
        count = len(points)
        # One array holds all motions and copies, so that lanes are full; both are views of it.
        self._all = part_of(self.motions, np.tile(np.arange(count), 2))
        self.motions = Motions(*(column[:count] for column in self._all))
        self._copies = Motions(*(column[count:] for column in self._all))
        self._tangents = Tangents(count, rtol, model_of(physics).components)

    def next_period(self) -> np.ndarray:
        """Displace the copies from the motions, and advance both by a drive period."""
        self._copies.states[:] = self._tangents.displaced(self.motions.states)
        return super().next_period()

    def growth(self) -> np.ndarray:
        """Return the logarithms (n,) of the growth of tangents; NaN where a copy was lost."""
        growth = self._tangents.carried(self.motions.states, self._copies.states)
        return np.where(self._copies.counts[:, OUTCOME] != OK, np.nan, growth)

    def stop(self, which: np.ndarray) -> None:
        """Stop these motions where they are, with the outcome PENDING."""
        for each in (self.motions, self._copies):
            each.counts[which & (each.counts[:, OUTCOME] == OK), OUTCOME] = PENDING
