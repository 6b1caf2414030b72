"""Many points at once, in lanes: the friendly side of kernels/passes.py."""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.kernels.adaptive import passes
from stickslip.kernels.adaptive.recording import RECORD
from stickslip.kernels.adaptive.results import reduce_points, restore_states, write_results
from stickslip.kernels.rows import RESULT_COLUMNS, Settings
from stickslip.model.scaling import Reduced
from stickslip.numerics.adaptive import OK
from stickslip.parameters import Parameters

_GAMMA = Reduced._fields.index("gamma")

# Attempts of all lanes together in one call of a door: about a second.
_WORK = 2_000_000

# The least tolerance: below it rounding decides.
_TIGHTEST = 1e-13


def _fluids(gammas: np.ndarray) -> list[tuple[Any, np.ndarray]]:
    """The door for each kind of fluid that occurs, with the rows that it is for."""
    special = passes.SPECIAL_PASSES
    kinds = [(door, np.flatnonzero(gammas == gamma)) for gamma, door in special.items()]
    others = np.flatnonzero(~np.isin(gammas, list(special)))
    return [(door, rows) for door, rows in [*kinds, (passes.general_pass, others)] if len(rows)]


def _work_through(queue: passes.Queue, task: passes.Pass) -> None:
    """One pass of the points of a queue that are ok so far through the lanes, fluid by fluid."""
    alive = np.flatnonzero(queue.counts[:, passes.OUTCOME] == OK)
    for door, chosen in _fluids(queue.points[alive, _GAMMA]):
        rows = alive[chosen]
        part, at_work = passes.Queue(*(column[rows] for column in queue)), passes.new_lanes()
        while door(part, at_work, task, _WORK) > 0:
            pass
        for whole, piece in zip(queue, part, strict=True):
            whole[rows] = piece


def compile_lanes(gammas: np.ndarray, settings: Settings) -> None:
    """Compile or load what points with these rheological indices need."""
    nobody = np.empty((0, len(Parameters._fields)))
    lane_orbits(nobody, settings, np.empty((0, len(RESULT_COLUMNS))), np.empty((0, 4)))
    task = passes.Pass(passes.TRAVEL, settings.rtol, settings.rtol, 0, 0, False)
    for door, _ in _fluids(gammas):
        door(_queue(nobody), passes.new_lanes(), task, 0)


def lane_orbits(
    points: np.ndarray, settings: Settings, results: np.ndarray, finals: np.ndarray
) -> None:
    """Stationary orbits by the adaptive method in lanes; arrays as for `kernels.adaptive_orbits`.

    Three passes: to the orbit, at `settings.rtol` and in the end a tenth of it; once over the
    orbit at either tolerance. The finer measurement is reported, the difference is its error.
    """
    queue, coarse = _queue(points), np.zeros((len(points), RECORD))
    halves, steps = 2 * settings.max_periods, settings.max_steps
    task = passes.Pass(
        passes.SETTLE, settings.rtol, settings.stationary_rtol, halves, steps, settings.accelerate
    )
    _work_through(queue, task)
    begins = queue.states.copy()
    _work_through(queue, task._replace(mode=passes.MEASURE))
    coarse[:] = queue.measured
    queue.states[:] = begins
    finer = max(passes.REFINEMENT * settings.rtol, _TIGHTEST)
    _work_through(queue, task._replace(mode=passes.MEASURE, rtol=finer))
    write_results(
        points, queue.counts, queue.ratios, begins, queue.states, coarse, queue.measured,
        settings.rtol, results,
    )  # fmt: skip
    finals[:] = begins
    restore_states(points, finals)


def lane_end_states(
    points: np.ndarray, periods: int, settings: Settings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where trajectories are after a number of drive periods from their starts.

    Parameters
    ----------
    points
        (n, 20) parameters in SI units, in the order of `Parameters._fields`.
    periods
        Drive periods to integrate.
    settings
        `rtol` and `max_steps`.

    Returns
    -------
    states
        (n, 3): x [m], v [m/s], ln(phi).
    steps
        (n,) attempted steps.
    statuses
        (n,) the Status of each as an integer.
    """
    queue = _queue(points)
    queue.counts[:, passes.CYCLE] = 2 * periods
    steps = settings.max_steps
    _work_through(queue, passes.Pass(passes.TRAVEL, settings.rtol, settings.rtol, 0, steps, False))
    restore_states(points, queue.states)
    return queue.states[:, :3], queue.counts[:, passes.ATTEMPTED], queue.counts[:, passes.OUTCOME]


def _queue(points: np.ndarray) -> passes.Queue:
    n = len(points)
    queue = passes.Queue(
        points=np.empty((n, len(Reduced._fields))),
        states=np.empty((n, passes.STATE_COLUMNS)),
        counts=np.zeros((n, passes.COUNT_COLUMNS), np.int64),
        measured=np.zeros((n, RECORD)),
        ratios=np.zeros(n),
    )
    reduce_points(points, queue.points, queue.states)
    return queue
