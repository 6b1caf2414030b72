"""Passes of many points through the lanes of the adaptive method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from inside.defaults import PHYSICS, WIDTH, amplitudes_of
from stickslip.kernels.adaptive import passes
from stickslip.kernels.adaptive.conversion import conversion_of
from stickslip.kernels.adaptive.queues import reduced_queue, work_through
from stickslip.measure.accumulate import (
    RECORD,
)
from stickslip.options import Options


def lane_end(row: np.ndarray, options: Options, periods: int) -> float:
    """The displacement x [m] of a point after some periods in one of the lanes; others are idle."""
    queue = reduced_queue(row[None], PHYSICS)
    queue.counts[:, passes.CYCLE] = 2 * periods
    task = search_pass(options)._replace(mode=passes.TRAVEL)
    work_through(queue, task, PHYSICS)
    states = queue.states.copy()
    conversion_of(PHYSICS).restore_states(row[None], states)
    return float(states[0, 0])


class Attempts(NamedTuple):
    """Attempted steps of all points by what they were for.

    The finer measurement is reported; the one at the tolerance itself is there for the error.
    """

    search: int
    measurement: int
    finer_measurement: int


def search(points: np.ndarray, options: Options) -> passes.Queue:
    """A queue of points after the search for their orbits."""
    queue = reduced_queue(points, PHYSICS)
    work_through(queue, search_pass(options), PHYSICS)
    return queue


def attempts_of(points: np.ndarray, options: Options) -> Attempts:
    """What the three passes of `compute_orbits` take."""
    queue, task = reduced_queue(points, PHYSICS), search_pass(options)
    measure = task._replace(mode=passes.MEASURE)
    finer = measure._replace(rtol=passes.REFINEMENT * options.rtol)
    counted = []
    for each in (task, measure, finer):
        before, begins = attempted(queue), queue.states.copy()
        work_through(queue, each, PHYSICS)
        counted.append(attempted(queue) - before)
        if each is measure:
            queue.states[:] = begins
    return Attempts(*counted)


def attempted(queue: passes.Queue) -> int:
    """Attempted steps of all points so far."""
    return int(queue.counts[:, passes.ATTEMPTED].sum())


def succeeded(queue: passes.Queue) -> np.ndarray:
    """Which points are ok so far."""
    return queue.counts[:, passes.OUTCOME] == 0


def half_periods(queue: passes.Queue) -> np.ndarray:
    """Half periods after which each orbit closes: a view, to be changed."""
    return queue.counts[:, passes.CYCLE]


def chosen(queue: passes.Queue, rows: np.ndarray) -> passes.Queue:
    """A copy of some rows of a queue."""
    return passes.Queue(*(array[rows] for array in queue))


def measured(
    queue: passes.Queue, points: np.ndarray, options: Options
) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes of stress [Pa] and force [N], (n, 2), by one measurement, and the states after it.

    `queue` is left as it is.
    """
    fresh = passes.Queue(*(array.copy() for array in queue))
    work_through(fresh, search_pass(options)._replace(mode=passes.MEASURE), PHYSICS)
    records = np.empty((len(points), RECORD))
    conversion_of(PHYSICS).write_records(points, half_periods(fresh), fresh.measured, records)
    return amplitudes_of(records), fresh.states


def first_period(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
    """States (x, v, phi) in SI units after a period from the start, (n, 3), and its amplitudes."""
    queue = reduced_queue(points, PHYSICS)
    half_periods(queue)[:] = 2
    amplitudes, states = measured(queue, points, options)
    conversion_of(PHYSICS).restore_states(points, states)
    ends = states[:, :WIDTH].copy()
    ends[:, 2] = np.exp(ends[:, 2])
    return ends, amplitudes


def search_pass(options: Options) -> passes.Pass:
    settings = options.settings()
    return passes.Pass(
        passes.SETTLE,
        settings.rtol,
        settings.stationary_rtol,
        2 * settings.max_periods,
        settings.max_steps,
        settings.accelerate,
    )
