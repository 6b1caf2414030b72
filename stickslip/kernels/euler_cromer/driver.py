"""Euler-Cromer for many points at once, in lanes: one of the table `options.METHODS`.

Plain iteration of the drive period, then a record, and the error against the adaptive method.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from stickslip.kernels import observation
from stickslip.kernels.adaptive import driver as adaptive
from stickslip.kernels.adaptive.conversion import conversion_of
from stickslip.kernels.adaptive.queues import reduced_queue
from stickslip.kernels.adaptive.tangents import Tangents, travelled
from stickslip.kernels.euler_cromer import judging
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.layout import write_starts, write_steps
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.euler_cromer.reference import settle_from
from stickslip.kernels.families import FamilyKernel, families
from stickslip.kernels.observation import Watched, spreads_of, watch, write_aperiodic
from stickslip.kernels.points import final_columns
from stickslip.kernels.stability import largest_stable_step
from stickslip.kernels.trajectories import euler_cromer_trajectory, new_stream
from stickslip.model.state import STATE
from stickslip.numerics.adaptive import OK, STEP_LIMIT
from stickslip.numerics.periodic import search
from stickslip.options import NO_NOISE, Options
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

NOT_STATIONARY, APERIODIC = int(Status.NOT_STATIONARY), int(Status.APERIODIC)
PENDING = int(Status.PENDING)

# The strain follows at once: Options refuse a relaxing one with this method.
_WIDTH = len(STATE)

# Points at a time: a search remembers 15 kB of each.
_BLOCK = 2048


def compile_shared(options: Options) -> None:
    """As `adaptive.driver.compile_shared`, whose orbits are the reference."""
    nobody, columns = np.empty((0, len(Parameters._fields))), final_columns(options.physics)
    adaptive.compile_shared(options)
    results, finals = (np.empty((0, len(names))) for names in (RESULT_COLUMNS, columns))
    orbits(nobody, options, finals, results, finals)


def family_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """As `adaptive.driver.family_kernels`."""
    if not options.physics.chance:
        yield from adaptive.family_kernels(kinds, options)  # of the reference orbit
    nobody, nothing = np.empty((0, len(Parameters._fields))), np.empty(0, np.int64)
    tasks = March(nobody, nothing, np.empty((0, len(STATE))), options.physics).tasks
    noisy = options.noise != NO_NOISE
    for family, _ in families(options.physics, kinds):
        for measured in (False, True):
            kernel = march_kernel(family, noisy, measured)
            yield FamilyKernel(kernel, partial(kernel, tasks, nothing, 0))


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """Largest fixed step [s] that is stable for each point (n, parameters)."""
    return largest_stable_step(points, options.friction)


def rounding(p: Parameters, options: Options) -> float:
    """Relative speed [m/s] below which the method rounds a cusp of the law: none."""
    return 0.0


def stochastic_walk(
    points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
) -> Any:
    """Motions with noise by chance, as of `adaptive.driver.stochastic_walk`."""
    from stickslip.kernels.euler_cromer.stochastic_walk import StochasticWalk  # of no use to others

    return StochasticWalk(points, starts, streams, options)


def trajectory(
    point: np.ndarray,
    options: Options,
    start: np.ndarray,
    per_period: int,
    samples: np.ndarray,
    stream: np.ndarray | None = None,
) -> int:
    """A sampled trajectory, as of `adaptive.driver.trajectory`."""
    march, taken = (
        euler_cromer_trajectory(options.physics),
        new_stream() if stream is None else stream,
    )
    return int(march(point, options.settings(), start, per_period, taken, samples))


def orbits(
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
    patience: int = 0,
) -> None:
    """Stationary orbits; arrays as of `adaptive.driver.orbits`.

    The error estimate compares with the orbit on which the adaptive method settles from there.
    """
    for first in range(0, max(len(points), 1), _BLOCK):  # an empty one compiles
        part = slice(first, first + _BLOCK)
        own = np.ascontiguousarray(points[part])
        _Search(own, starts[part], options).run(results[part], finals[part])


class _Search:
    """The way of a block of points from their starts to their result rows."""

    def __init__(self, points: np.ndarray, given: np.ndarray, options: Options) -> None:
        count = len(points)
        self.points, self.options, self.settings = points, options, options.settings()
        self.steps, starts = np.empty(count, np.int64), np.empty((count, 3))
        write_steps(points, self.settings.dt, self.steps)
        write_starts(points, starts)
        elsewhere = ~np.isnan(given[:, 0])
        starts[elsewhere] = judging.states_of(given[elsewhere])
        self.march = March(points, self.steps, starts, options.physics)
        self.used = np.zeros(count, np.int64)
        self.periods = np.zeros(count, np.int64)
        self.status = np.full(count, NOT_STATIONARY)
        self.memories = np.zeros(count, search.memory_of(_WIDTH))

    def run(self, results: np.ndarray, finals: np.ndarray) -> None:
        """Settle, measure, compare, write."""
        aperiodic = self._settle()
        begins, cycles = self.march.states(), self.memories["cycle"].copy()
        self._measure(cycles)
        ends, records = self.march.states(), self.march.records()
        judging.write_finals(self.points, begins, finals)
        known = settle_from(self.points, finals, self.status, self.options)
        orbits = judging.Orbits(
            cycles, self.periods, self.status, begins, ends, records, self._spreads(cycles)
        )
        judging.write_results(self.points, orbits, known, results)
        for rows, watched in aperiodic:
            own = np.empty((len(rows), results.shape[1]))
            write_aperiodic(self.points[rows], watched, self.periods[rows], own)
            results[rows], finals[rows] = own, watched.ends

    def _settle(self) -> list[tuple[np.ndarray, Watched]]:
        """Bring the points to their orbits; those that are aperiodic: rows, and as seen."""
        pending, aperiodic = np.arange(len(self.points)), []
        for late in (False, True):
            states = self.march.states()[pending]
            memories = np.zeros(len(pending), search.memory_of(_WIDTH))
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
        """Iterate to the orbit; the points (m,) that wander instead."""
        wandering = [pending[:0]]
        while len(pending):
            pending = self.one_period(pending, measured=False)
            verdicts = np.zeros(len(self.points), np.int64)
            judging.judge(
                self.points, self.march.states(), pending, self.settings.stationary_rtol,
                self.memories, verdicts,
            )  # fmt: skip
            found = verdicts[pending]
            self.status[pending[found == search.SETTLED]] = OK
            wandering.append(pending[found == search.WANDERING])
            pending = pending[(found != search.SETTLED) & (found != search.WANDERING)]
            pending = pending[self.periods[pending] < self.settings.max_periods]
        return np.concatenate(wandering)

    def _watch(self, wandering: np.ndarray, *, decisive: bool) -> Watched:
        """Watch points (m,) that wander."""
        walk = _Walk(self, wandering)
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
            pending = self.one_period(pending, measured=True)

    def _spreads(self, cycles: np.ndarray) -> np.ndarray:
        """Standard deviations (n, 2) of the amplitudes of single drive periods, SI units."""
        spreads = np.zeros((len(self.points), 2))
        rows = np.flatnonzero((self.status == OK) & (cycles > 1))
        if len(rows):  # once more over the orbit
            spreads[rows] = spreads_of(_Walk(self, rows), cycles[rows])
        return spreads

    def one_period(self, pending: np.ndarray, measured: bool) -> np.ndarray:
        """March through a period; those that did not fail on the way."""
        limits = self.settings.max_steps - self.used[pending]
        self.periods[pending] += 1
        self.march.start(pending, limits)
        self.march.march(measured)
        outcome = self.march.tasks.status[pending]
        outcome[(outcome == OK) & (limits < self.steps[pending])] = STEP_LIMIT
        self.used[pending] += self.march.tasks.done[pending]
        self.status[pending[outcome != OK]] = outcome[outcome != OK]
        return pending[outcome == OK]


class _Walk:
    """Some points (m,) of a search, a drive period at a time: the walk of observation.py.

    Tangents are carried by the adaptive method, from each state to a period later.
    """

    def __init__(self, whole: _Search, rows: np.ndarray) -> None:
        self.whole, self.rows, self.points = whole, rows, whole.points[rows]
        self.whole.status[rows] = OK
        self._before = self.states()
        self._tangents = Tangents(len(rows), observation.RTOL, STATE)

    def states(self) -> np.ndarray:
        """As `observation.Walk`."""
        finals = np.empty((len(self.rows), _WIDTH + 1))
        judging.write_finals(self.points, self.whole.march.states()[self.rows], finals)
        return finals

    def next_period(self) -> np.ndarray:
        """As `observation.Walk`."""
        alive, self._before = self.rows[self.outcomes() == OK], self.states()
        self.whole.march.clear_records(alive)
        self.whole.one_period(alive, measured=True)
        return self.whole.march.records(closed=False)[self.rows]

    def part(self, which: np.ndarray) -> _Walk:
        """As `observation.DivisibleWalk`."""
        return _Walk(self.whole, self.rows[which])

    def growth(self) -> np.ndarray:
        """As `observation.Walk`."""
        physics, n = self.whole.options.physics, len(self.rows)
        reduced, states = reduced_queue(self.points, physics).points, self._before.copy()
        conversion_of(physics).scale_states(self.points, states)
        both = np.concatenate([states, self._tangents.displaced(states)])
        periods, rtol = np.full(2 * n, 2), observation.RTOL
        ends = travelled(np.tile(reduced, (2, 1)), both, periods, rtol, physics)
        return self._tangents.carried(ends[:n], ends[n:])

    def outcomes(self) -> np.ndarray:
        """As `observation.Walk`."""
        return self.whole.status[self.rows]

    def stop(self, which: np.ndarray) -> None:
        """As `observation.TangentWalk`."""
        self.whole.status[self.rows[which & (self.outcomes() == OK)]] = PENDING
