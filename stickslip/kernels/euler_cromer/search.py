"""Stationary orbits by Euler-Cromer in lanes: plain iteration of the drive period, then a record.

It computes what the scalar `fixed_orbits` computes, for many points side by side.
"""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import door, jit
from stickslip.kernels.euler_cromer.layout import write_starts, write_steps
from stickslip.kernels.euler_cromer.march import FixedLanes
from stickslip.kernels.euler_cromer.scaling import from_lane, step_units
from stickslip.kernels.orbits import (
    _FIXED_REFERENCE,
    _PLENTY,
    _POWER_BALANCE_LIMIT,
    _TIGHTER,
    INVARIANT_VIOLATED,
    _better_cycle,
    _fill,
    _scaled,
    _with_rtol,
)
from stickslip.kernels.problem import log_state
from stickslip.kernels.rows import FIRST_STEP, Settings, fail, parameters_of, period_of
from stickslip.measure import accumulate
from stickslip.model.rhs import State, starting_state
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.euler_cromer_lanes import V, W, X
from stickslip.numerics.periodic import stationarity
from stickslip.numerics.periodic.stationarity import NOT_STATIONARY, closing_cycle

# Points at a time: the search remembers 6 kB of each.
_BLOCK = 2048

# Columns of the notes of a search: as the variables of `stationarity.make_settle`.
_NEWEST, _HELD, _PREVIOUS, _CYCLE = range(4)


def fixed_lane_orbits(
    points: np.ndarray, settings: Settings, results: np.ndarray, finals: np.ndarray
) -> None:
    """Stationary orbits by Euler-Cromer; arrays as for `adaptive_orbits`.

    The error estimate compares with the adaptive method from the same stroboscopic state.
    """
    for first in range(0, len(points), _BLOCK):
        part = slice(first, first + _BLOCK)
        _Search(np.ascontiguousarray(points[part]), settings).run(results[part], finals[part])


class _Search:
    """The way of a block of points from their starts to their result rows."""

    def __init__(self, points: np.ndarray, settings: Settings) -> None:
        count = len(points)
        self.points, self.settings = points, settings
        self.steps, starts = np.empty(count, np.int64), np.empty((count, 3))
        write_steps(points, settings.dt, self.steps)
        write_starts(points, starts)
        self.lanes = FixedLanes(points, self.steps, starts)
        self.used = np.zeros(count, np.int64)
        self.periods = np.zeros(count, np.int64)
        self.status = np.full(count, NOT_STATIONARY)
        self.notes = np.zeros((count, 4), np.int64)

    def run(self, results: np.ndarray, finals: np.ndarray) -> None:
        """Settle, measure, write."""
        self._settle()
        begins = self.lanes.states()
        self._measure()
        conclude(
            self.points, self.settings, self.notes[:, _CYCLE], self.periods, self.status,
            begins, self.lanes.states(), self.lanes.records(), results, finals,
        )  # fmt: skip

    def _settle(self) -> None:
        states = np.empty((len(self.points), stationarity._REMEMBERED, 3))
        begin_searches(self.points, self.steps, self.lanes.tasks.rows, states)
        pending = np.arange(len(self.points))
        for _ in range(self.settings.max_periods):
            pending = self._one_period(pending, measured=False)
            judge(
                self.points, self.steps, self.lanes.tasks.rows, pending,
                self.settings.stationary_rtol, states, self.notes,
            )  # fmt: skip
            settled = self.notes[pending, _CYCLE] > 0
            self.status[pending[settled]] = OK
            pending = pending[~settled]
            if not len(pending):
                return

    def _measure(self) -> None:
        pending = np.flatnonzero(self.status == OK)
        self.lanes.clear_records(pending)
        for done in range(stationarity.LONGEST_CYCLE):
            pending = pending[self.notes[pending, _CYCLE] > done]
            if not len(pending):
                return
            pending = self._one_period(pending, measured=True)

    def _one_period(self, pending: np.ndarray, measured: bool) -> np.ndarray:
        """March through a period; those that did not fail on the way."""
        limits = self.settings.max_steps - self.used[pending]
        self.periods[pending] += 1
        self.lanes.start(pending, limits)
        self.lanes.march(measured)
        outcome = self.lanes.tasks.status[pending]
        outcome[(outcome == OK) & (limits < self.steps[pending])] = STEP_LIMIT
        self.used[pending] += self.lanes.tasks.done[pending]
        self.status[pending[outcome != OK]] = outcome[outcome != OK]
        return pending[outcome == OK]


@jit
def _judged(points: np.ndarray, steps: np.ndarray, rows: np.ndarray, i: int) -> State:
    """The state by which repetition is judged."""
    p, row = parameters_of(points[i]), rows[i]
    return _scaled(p, from_lane(step_units(p, steps[i]), (row[X], row[V], row[W])))


@door
def begin_searches(
    points: np.ndarray, steps: np.ndarray, rows: np.ndarray, states: np.ndarray
) -> None:
    """Write the starts into the remembered `states` (n, 257, 3)."""
    for i in range(points.shape[0]):
        states[i, 0] = _judged(points, steps, rows, i)


@door
def judge(
    points: np.ndarray,
    steps: np.ndarray,
    rows: np.ndarray,
    which: np.ndarray,
    tolerance: float,
    states: np.ndarray,
    notes: np.ndarray,
) -> None:
    """Take in the stroboscopic states of the points `which`; write the cycles of settled orbits.

    The verdicts are those of `stationarity.make_settle`.
    """
    for i in which:
        z, note, remembered = _judged(points, steps, rows, i), notes[i], states[i]
        note[_NEWEST] += 1
        remembered[note[_NEWEST] % stationarity._REMEMBERED] = z
        cycle = closing_cycle(remembered, note[_NEWEST], tolerance)
        again = cycle > 0 and cycle == note[_PREVIOUS]
        note[_HELD] = note[_HELD] + 1 if again else min(cycle, 1)
        note[_PREVIOUS] = cycle
        if note[_HELD] >= stationarity._CONFIRMATIONS:
            note[_CYCLE] = cycle


@jit
def _conclude_point(
    point: np.ndarray,
    settings: Settings,
    cycle: int,
    periods: int,
    begin: State,
    end: State,
    record: np.ndarray,
    better: np.ndarray,
    result: np.ndarray,
) -> None:
    p, start = parameters_of(point), starting_state(parameters_of(point))
    tight = _with_rtol(settings, _TIGHTER * _FIXED_REFERENCE)
    first_step = 0.1 * FIRST_STEP * period_of(p)
    _, _, status = _better_cycle(p, tight, log_state(begin), first_step, cycle, _PLENTY, better)
    if status != OK:
        fail(result, periods, status)
        return
    result[6] = accumulate.amplitude_error(p, record, better)
    _fill(p, record, begin, end, cycle, result)
    result[11], result[12] = periods, OK
    if not math.isfinite(result[0] + result[1] + result[6]):
        fail(result, periods, DIVERGED)
        return
    believed = accumulate.balance_kept(p, record, result[7], cycle, _POWER_BALANCE_LIMIT)
    if not (believed and accumulate.bounds_kept(p, record, math.exp(start[2]))):
        fail(result, periods, INVARIANT_VIOLATED)


@door
def conclude(
    points: np.ndarray,
    settings: Settings,
    cycles: np.ndarray,
    periods: np.ndarray,
    statuses: np.ndarray,
    begins: np.ndarray,
    ends: np.ndarray,
    records: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
) -> None:
    """Write result rows and finals from what was measured over whole cycles.

    `begins` and `ends` (n, 3) are the states (x, v, phi) before and after the measurement.
    """
    better = np.empty(accumulate.LENGTH)
    for i in range(points.shape[0]):
        begin = (begins[i, 0], begins[i, 1], begins[i, 2])
        settled, final = log_state(begin), finals[i]
        final[0], final[1], final[2] = settled
        final[3] = FIRST_STEP * period_of(parameters_of(points[i]))
        if statuses[i] != OK:
            fail(results[i], periods[i], statuses[i])
            continue
        end = (ends[i, 0], ends[i, 1], ends[i, 2])
        _conclude_point(
            points[i], settings, cycles[i], periods[i], begin, end, records[i], better, results[i]
        )
