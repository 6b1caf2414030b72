"""Euler-Cromer for many points at once, in lanes: one of the table `options.METHODS`.

Plain iteration of the drive period, then a record, and the error against the adaptive method.
"""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import inline, kernel
from stickslip.compiled.fields import make_map
from stickslip.kernels.adaptive import conversion
from stickslip.kernels.adaptive import driver as adaptive
from stickslip.kernels.adaptive.passes import CYCLE, MEASURE, OUTCOME, Pass, judged
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.layout import write_starts, write_steps
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.families import families
from stickslip.kernels.points import FINAL_COLUMNS, FIRST_STEP, parameters_of
from stickslip.kernels.stability import largest_stable_step
from stickslip.kernels.trajectories import euler_cromer_trajectory
from stickslip.measure.accumulate import RECORD
from stickslip.measure.results import (
    Measured,
    relative_difference,
    write_failure,
    write_result,
)
from stickslip.model import drive
from stickslip.model.scaling import units_of
from stickslip.model.state import STATE, WIDTH, State
from stickslip.numerics.adaptive import OK, STEP_LIMIT
from stickslip.numerics.periodic import search
from stickslip.options import Options
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

NOT_STATIONARY = int(Status.NOT_STATIONARY)

# Points at a time: a search remembers 13 kB of each.
_BLOCK = 2048

# The orbit that a fixed-step one is compared with: its own error at the paper's step is 1e-9.
_REFERENCE_RTOL = 1e-9
_REFERENCE_STEPS = 20_000_000

_UNLIMITED = 2**62

# Both extrema count in the difference of two records, an amplitude is half of theirs.
_AMPLITUDE_PART = 0.5


def compile_for(indices: np.ndarray, options: Options) -> None:
    """Compile or load what points with these rheological indices (n,) need."""
    nobody = np.empty((0, len(Parameters._fields)))
    adaptive.compile_for(indices, options)  # of the reference orbit
    columns = (len(RESULT_COLUMNS), len(FINAL_COLUMNS))
    orbits(nobody, options, *(np.empty((0, count)) for count in columns))
    tasks = March(nobody, np.empty(0, np.int64), np.empty((0, 3)), options.friction).tasks
    noisy = options.noise != "none"
    for family, _ in families(options.friction, indices):
        for measured in (False, True):
            march_kernel(family, noisy, measured)(tasks, np.empty(0, np.int64), 0)


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """Largest fixed step [s] that is stable for each point (n, parameters)."""
    return largest_stable_step(points, options.friction)


def rounding(p: Parameters, options: Options) -> float:
    """Relative speed [m/s] below which the method rounds a cusp of the law: none."""
    return 0.0


def trajectory(
    point: np.ndarray, options: Options, start: np.ndarray, per_period: int, samples: np.ndarray
) -> int:
    """A sampled trajectory, as of `adaptive.driver.trajectory`."""
    march = euler_cromer_trajectory(options.friction)
    return int(march(point, options.settings(), start, per_period, samples))


def orbits(points: np.ndarray, options: Options, results: np.ndarray, finals: np.ndarray) -> None:
    """Stationary orbits; arrays as of `adaptive.driver.orbits`.

    The error estimate compares with the adaptive method from the same stroboscopic state.
    """
    for first in range(0, max(len(points), 1), _BLOCK):  # an empty one compiles
        part = slice(first, first + _BLOCK)
        _Search(np.ascontiguousarray(points[part]), options).run(results[part], finals[part])


class _Search:
    """The way of a block of points from their starts to their result rows."""

    def __init__(self, points: np.ndarray, options: Options) -> None:
        count = len(points)
        self.points, self.options, self.settings = points, options, options.settings()
        self.steps, starts = np.empty(count, np.int64), np.empty((count, 3))
        write_steps(points, self.settings.dt, self.steps)
        write_starts(points, starts)
        self.march = March(points, self.steps, starts, options.friction)
        self.used = np.zeros(count, np.int64)
        self.periods = np.zeros(count, np.int64)
        self.status = np.full(count, NOT_STATIONARY)
        self.memories = np.zeros(count, search.memory_of(WIDTH))

    def run(self, results: np.ndarray, finals: np.ndarray) -> None:
        """Settle, measure, compare, write."""
        self._settle()
        begins, cycles = self.march.states(), self.memories["cycle"].copy()
        self._measure(cycles)
        ends, records = self.march.states(), self.march.records()
        write_finals(self.points, begins, finals)
        better = self._reference(cycles, finals)
        write_results(
            self.points, cycles, self.periods, self.status, begins, ends, records, better, results
        )

    def _settle(self) -> None:
        pending = np.arange(len(self.points))
        start_searches(self.points, self.march.states(), self.memories)
        for _ in range(self.settings.max_periods):
            pending = self._one_period(pending, measured=False)
            verdicts = np.zeros(len(self.points), np.int64)
            judge(
                self.points, self.march.states(), pending, self.settings.stationary_rtol,
                self.memories, verdicts,
            )  # fmt: skip
            settled = verdicts[pending] == search.SETTLED
            self.status[pending[settled]] = OK
            pending = pending[~settled]
            if not len(pending):
                return

    def _measure(self, cycles: np.ndarray) -> None:
        pending = np.flatnonzero(self.status == OK)
        self.march.clear_records(pending)
        for done in range(search.LONGEST_CYCLE_IN_PERIODS):
            pending = pending[cycles[pending] > done]
            if not len(pending):
                return
            pending = self._one_period(pending, measured=True)

    def _one_period(self, pending: np.ndarray, measured: bool) -> np.ndarray:
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

    def _reference(self, cycles: np.ndarray, finals: np.ndarray) -> np.ndarray:
        """The records (n, RECORD) of the adaptive method over the same cycles, in SI units.

        Where it fails, the status of the point becomes that.
        """
        queue = adaptive.reduced_queue(self.points, self.options.friction)
        queue.states[:] = finals
        conversion.scale_states(self.points, queue.states)
        queue.counts[:, CYCLE], queue.counts[:, OUTCOME] = 2 * cycles, self.status
        task = Pass(MEASURE, _REFERENCE_RTOL, _REFERENCE_RTOL, 0, _REFERENCE_STEPS, False)
        adaptive.work_through(queue, task, self.options.friction)
        self.status[:] = queue.counts[:, OUTCOME]
        records = np.empty((len(self.points), RECORD))
        conversion.write_records(self.points, 2 * cycles, queue.measured, records)
        return records


_in_units = make_map(
    "in_units",
    "y, units",
    (f"y[{i}] / units.{c.unit}" if c.unit else f"y[{i}]" for i, c in enumerate(STATE)),
    {},
)


@inline
def _judged(point: np.ndarray, state: np.ndarray) -> State:
    """The state (x, v, phi) as its repetition is judged."""
    y = (state[0], state[1], math.log(state[2]))
    return judged(_in_units(y, units_of(parameters_of(point))))


@kernel
def start_searches(points: np.ndarray, states: np.ndarray, memories: np.ndarray) -> None:
    """Begin the searches `memories` (n,) of points at the states (n, 3), (x, v, phi)."""
    for i in range(points.shape[0]):
        search.start(memories[i], _judged(points[i], states[i]), 1, False, False)


@kernel
def judge(
    points: np.ndarray,
    states: np.ndarray,
    which: np.ndarray,
    tolerance: float,
    memories: np.ndarray,
    verdicts: np.ndarray,
) -> None:
    """Take in the stroboscopic states of some points; write the verdicts of their searches.

    `points` (n, parameters); `states` (n, 3); `which` (m,) indices; `tolerance` the distance from
    the limit to reach; `memories` (n,) and `verdicts` (n,) of `numerics.periodic.search`.
    """
    for i in which:
        z = _judged(points[i], states[i])
        verdicts[i], _, _ = search.judge(memories[i], z, tolerance, 0.0, _UNLIMITED)


@kernel
def write_finals(points: np.ndarray, states: np.ndarray, finals: np.ndarray) -> None:
    """Write states (n, 3), (x, v, phi), as finals (n, columns): (x, v, ln phi), the next step."""
    for i in range(finals.shape[0]):
        finals[i, 0], finals[i, 1] = states[i, 0], states[i, 1]
        finals[i, 2] = math.log(states[i, 2])
        finals[i, 3] = FIRST_STEP * drive.period(parameters_of(points[i]))


@kernel
def write_results(
    points: np.ndarray,
    cycles: np.ndarray,
    periods: np.ndarray,
    statuses: np.ndarray,
    begins: np.ndarray,
    ends: np.ndarray,
    records: np.ndarray,
    better: np.ndarray,
    results: np.ndarray,
) -> None:
    """Write result rows from what was measured over whole cycles.

    `points` (n, parameters); `cycles`, `periods` and `statuses` (n,); `begins` and `ends` (n, 3)
    the states (x, v, phi) before and after; `records` and those of the reference, `better`
    (n, RECORD), in SI units; `results` (n, columns).
    """
    for i in range(results.shape[0]):
        if statuses[i] != OK:
            write_failure(results[i], periods[i], statuses[i])
            continue
        p, cycle = parameters_of(points[i]), 2 * cycles[i]
        measured = Measured(
            records[i],
            cycle,
            (begins[i, 0], begins[i, 1]),
            (ends[i, 0], ends[i, 1]),
            _AMPLITUDE_PART * relative_difference(p, records[i], better[i]),
            periods[i],
        )
        write_result(p, measured, results[i])
