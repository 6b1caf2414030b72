"""Stationary orbits by plain iteration: settle, measure, compare with the adaptive method.

For every march, tangents and reference orbits are computed by the adaptive method.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.kernels.adaptive import driver as adaptive
from stickslip.kernels.families import FamilyKernel
from stickslip.kernels.observation import Watched, aperiodic_rows, spreads_of, watch
from stickslip.kernels.plain_iteration import judging
from stickslip.kernels.plain_iteration.comparison import settle_from
from stickslip.kernels.plain_iteration.motions import NOT_STATIONARY, WIDTH, MakeMarch, Motions
from stickslip.kernels.plain_iteration.plain_walk import PENDING, PlainWalk
from stickslip.kernels.plain_iteration.starts import write_finals
from stickslip.kernels.points import write_results
from stickslip.measure.accumulate import INTEGRALS
from stickslip.measure.results import Measured
from stickslip.measure.window import amplitudes_of
from stickslip.numerics.adaptive import OK
from stickslip.numerics.periodic import search
from stickslip.options import Options
from stickslip.status import Status

APERIODIC = int(Status.APERIODIC)

# Points at a time: a search keeps 15 kB for each.
POINTS_AT_A_TIME = 2048


def reference_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """Yield the kernels of the reference orbits of points of these kinds (n, k).

    There are none if the noise is stochastic.
    """
    if not options.physics.chance:
        yield from adaptive.family_kernels(kinds, options)


def write_orbits(
    make_march: MakeMarch,
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
) -> None:
    """Compute stationary orbits by a march; arrays as in `adaptive.driver.orbits`.

    The error estimate compares with the orbit on which the adaptive method settles from there.
    """
    for first in range(0, max(len(points), 1), POINTS_AT_A_TIME):  # an empty block compiles
        part = slice(first, first + POINTS_AT_A_TIME)
        motions = Motions(make_march, np.ascontiguousarray(points[part]), starts[part], options)
        _Search(motions, options).run(results[part], finals[part])


class _Search:
    """The computation of a block of points, from their starts to their result rows."""

    def __init__(self, motions: Motions, options: Options) -> None:
        self.motions, self.options, self.settings = motions, options, options.settings()
        self.points, self.march, self.status = motions.points, motions.march, motions.status
        self.memories = np.zeros(len(self.points), search.memory_of(WIDTH))

    def run(self, results: np.ndarray, finals: np.ndarray) -> None:
        """Settle, measure, compare and write the results."""
        periods, aperiodic = self.motions.periods, self._settle()
        begins, cycles = self.march.states(), self.memories["cycle"].copy()
        self._measure(cycles)
        ends, records = self.march.states(), self.march.records()
        write_finals(self.points, begins, finals)
        known = settle_from(self.points, finals, self.status, self.options)
        records[self.status != OK] = 0.0  # what a march left there that did not come to its end
        errors = np.empty(len(self.points))
        judging.write_errors(self.points, records, known.records, errors)
        integrals, uncertainties = list(INTEGRALS), np.zeros_like(records)
        known_integrals = known.integrals * (2 * cycles)[:, None]
        uncertainties[:, integrals] = np.abs(records[:, integrals] - known_integrals)
        measured = Measured(
            records=records,
            uncertainties=uncertainties,
            cycles=2 * cycles,
            begins=begins,
            ends=ends,
            symmetric=known.symmetric,
            amplitudes=amplitudes_of(records),
            errors=errors,
            spreads=self._spreads(cycles),
            multipliers=known.multipliers,
            exponents=np.full(len(self.points), np.nan),
            periods=periods,
            statuses=self.status,
        )
        write_results(self.points, measured, results)
        for rows, watched in aperiodic:
            results[rows] = aperiodic_rows(self.points[rows], watched, periods[rows])
            finals[rows] = watched.ends

    def _settle(self) -> list[tuple[np.ndarray, Watched]]:
        """Bring the points to their orbits; return rows and records of the aperiodic ones."""
        pending, aperiodic = np.arange(len(self.points)), []
        for late in (False, True):
            states = self.march.states()[pending]
            memories = np.zeros(len(pending), search.memory_of(WIDTH))
            judging.start_searches(self.points[pending], states, memories, late)
            self.memories[pending] = memories
            pending = self._search(pending)
            if not len(pending):
                break
            watched = self._watch(pending, decisive=late)
            aperiodic.append((pending[watched.aperiodic], watched.part(watched.aperiodic)))
            pending = pending[self.status[pending] == NOT_STATIONARY]
        return aperiodic

    def _search(self, pending: np.ndarray) -> np.ndarray:
        """Iterate to the orbit; return the points (m,) that wander instead."""
        wandering = [pending[:0]]
        while len(pending):
            pending = self.motions.next_period(pending, measured=False)
            verdicts = np.zeros(len(self.points), np.int64)
            judging.judge(
                self.points, self.march.states(), pending, self.settings.stationary_rtol,
                self.memories, verdicts,
            )  # fmt: skip
            found = verdicts[pending]
            self.status[pending[found == search.SETTLED]] = OK
            wandering.append(pending[found == search.WANDERING])
            pending = pending[(found != search.SETTLED) & (found != search.WANDERING)]
            pending = pending[self.motions.periods[pending] < self.settings.max_periods]
        return np.concatenate(wandering)

    def _watch(self, wandering: np.ndarray, *, decisive: bool) -> Watched:
        """Watch points (m,) that wander, and set their status."""
        walk = PlainWalk(self.motions, wandering)
        watched = watch(walk, self.settings.window, decisive=decisive)
        goes_on = np.isin(walk.outcomes(), (OK, PENDING))
        self.status[wandering] = np.where(goes_on, NOT_STATIONARY, walk.outcomes())
        self.status[wandering[watched.aperiodic]] = APERIODIC
        return watched

    def _measure(self, cycles: np.ndarray) -> None:
        pending = np.flatnonzero(self.status == OK)
        self.march.clear_records(pending)
        for done in range(search.LONGEST_CYCLE_IN_PERIODS):
            pending = pending[cycles[pending] > done]
            if not len(pending):
                return
            pending = self.motions.next_period(pending, measured=True)

    def _spreads(self, cycles: np.ndarray) -> np.ndarray:
        """Return the standard deviations (n, 2) of amplitudes of single drive periods, SI units."""
        spreads = np.zeros((len(self.points), 2))
        rows = np.flatnonzero((self.status == OK) & (cycles > 1))
        if len(rows):  # once more over the orbit
            spreads[rows] = spreads_of(PlainWalk(self.motions, rows), cycles[rows])
        return spreads
