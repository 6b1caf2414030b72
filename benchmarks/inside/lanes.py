"""Passes of many points through the lanes of the adaptive method."""

from __future__ import annotations

import numpy as np

from inside.defaults import PHYSICS, WIDTH, amplitudes_of
from stickslip.kernels.adaptive import passes
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import reduced_queue, work_through
from stickslip.kernels.orbits.settling import Search, settle
from stickslip.measure.accumulate import RECORD
from stickslip.options import Options


def end_states(
    points: np.ndarray, periods: int, options: Options
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return SI states (x, v, ln phi) after some periods, (n, 3), attempted steps and statuses."""
    queue = reduced_queue(points, PHYSICS)
    half_periods(queue)[:] = 2 * periods
    settings = options.settings()
    work_through(queue, passes.TRAVEL, settings.rtol, settings.max_steps, PHYSICS)
    conversion_of(PHYSICS).restore_states(points, queue.states)
    counts = queue.counts
    return queue.states[:, :-1], counts[:, passes.ATTEMPTED], counts[:, passes.OUTCOME]


def lane_end(row: np.ndarray, options: Options, periods: int) -> float:
    """Return the displacement x [m] of a point after some periods in a lane among idle ones."""
    return float(end_states(row[None], periods, options)[0][0, 0])


def search(points: np.ndarray, options: Options) -> passes.Queue:
    """Return a queue of points after the search for their orbits."""
    queue = reduced_queue(points, PHYSICS)
    settings = options.settings()
    halves, steps = 2 * settings.max_periods, settings.max_steps
    distance, accelerate = settings.stationary_rtol, settings.accelerate
    settle(queue, Search(settings.rtol, distance, halves, steps, accelerate), PHYSICS)
    return queue


def attempted(queue: passes.Queue) -> int:
    """Return attempted steps of all points so far."""
    return int(queue.counts[:, passes.ATTEMPTED].sum())


def half_periods(queue: passes.Queue) -> np.ndarray:
    """Return half periods after which each orbit closes: a view, to be changed."""
    return queue.counts[:, passes.CYCLE]


def first_period(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
    """Return SI states (x, v, phi) after a period from the start, (n, 3), and amplitudes."""
    queue, conversion = reduced_queue(points, PHYSICS), conversion_of(PHYSICS)
    half_periods(queue)[:] = 2
    settings = options.settings()
    work_through(queue, passes.MEASURE, settings.rtol, settings.max_steps, PHYSICS)
    records = np.empty((len(points), RECORD))
    conversion.write_records(points, half_periods(queue), queue.measured, records)
    conversion.restore_states(points, queue.states)
    ends = queue.states[:, :WIDTH].copy()
    ends[:, 2] = np.exp(ends[:, 2])
    return ends, amplitudes_of(records)
