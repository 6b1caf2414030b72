"""The adaptive method for many points at once, in lanes: one of the table `options.METHODS`.

What such a module offers is said in `compile_for`, `orbits`, `trajectory`, `largest_step` and
`rounding`.
"""

from __future__ import annotations

import numpy as np

from stickslip.kernels.adaptive import conversion
from stickslip.kernels.adaptive.passes import (
    ATTEMPTED,
    CYCLE,
    MEASURE,
    OUTCOME,
    REFINEMENT,
    SETTLE,
    TRAVEL,
    Pass,
    Queue,
    new_lanes,
    new_queue,
    pass_kernel,
)
from stickslip.kernels.families import families
from stickslip.kernels.points import FINAL_COLUMNS
from stickslip.kernels.problem import rounding_speed
from stickslip.kernels.trajectories import adaptive_trajectory
from stickslip.model.scaling import Reduced
from stickslip.model.state import WIDTH
from stickslip.numerics.adaptive import OK
from stickslip.options import Options
from stickslip.parameters import Parameters
from stickslip.variables import RESULT_COLUMNS

_INDEX = Reduced._fields.index("rheological_index")

# Attempts of all lanes together in one call of a kernel: about a second.
_WORK = 2_000_000

# The least tolerance: below it rounding decides.
TIGHTEST = 1e-13


def compile_for(indices: np.ndarray, options: Options) -> None:
    """Compile or load what points with these rheological indices (n,) need."""
    nobody = np.empty((0, len(Parameters._fields)))
    columns = (len(RESULT_COLUMNS), len(FINAL_COLUMNS))
    orbits(nobody, options, *(np.empty((0, count)) for count in columns))
    settings = options.settings()
    task = Pass(TRAVEL, settings.rtol, settings.rtol, 0, 0, False)
    for family, _ in families(options.friction, indices):
        pass_kernel(family)(reduced_queue(nobody, options.friction), new_lanes(), task, 0)


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """Largest fixed step [s] that is stable for each point (n, parameters); here any."""
    return np.full(len(points), np.inf)


def rounding(p: Parameters, options: Options) -> float:
    """Relative speed [m/s] below which the method rounds a cusp of the law."""
    return float(rounding_speed(p, options.rtol))


def trajectory(
    point: np.ndarray, options: Options, start: np.ndarray, per_period: int, samples: np.ndarray
) -> int:
    """A sampled trajectory; returns the Status as an integer.

    `point` (parameters,); `start` (WIDTH,) the state at phase 0; `samples`
    (periods*per_period + 1, WIDTH) receives (x, v, phi) at equal times.
    """
    kernel = adaptive_trajectory(options.friction)
    return int(kernel(point, options.settings(), start, per_period, samples))


def orbits(points: np.ndarray, options: Options, results: np.ndarray, finals: np.ndarray) -> None:
    """Stationary orbits.

    Three passes: to the orbit, at `rtol` and in the end a tenth of it; once over the orbit at
    either tolerance. The finer measurement is reported, the difference is its error.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    options
        Tolerances, budgets, friction law.
    results
        (n, columns), written in the order of `variables.RESULT_COLUMNS`.
    finals
        (n, columns), written in the order of `points.FINAL_COLUMNS`.
    """
    settings, law = options.settings(), options.friction
    queue = reduced_queue(points, law)
    halves, steps = 2 * settings.max_periods, settings.max_steps
    task = Pass(SETTLE, settings.rtol, settings.stationary_rtol, halves, steps, settings.accelerate)
    work_through(queue, task, law)
    begins = queue.states.copy()
    work_through(queue, task._replace(mode=MEASURE), law)
    coarse = queue.measured.copy()
    queue.states[:] = begins
    finer = max(REFINEMENT * settings.rtol, TIGHTEST)
    work_through(queue, task._replace(mode=MEASURE, rtol=finer), law)
    conversion.result_kernel(law)(points, queue, begins, coarse, settings.rtol, results)
    finals[:] = begins
    conversion.restore_states(points, finals)


def end_states(
    points: np.ndarray, periods: int, options: Options
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where trajectories are after a number of drive periods from their starts.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    periods
        Drive periods to integrate.
    options
        `rtol`, `max_steps`, `friction`.

    Returns
    -------
    states
        (n, WIDTH): x [m], v [m/s], ln(phi); where the lane stopped unless the status is ok.
    steps
        (n,) attempted steps.
    statuses
        (n,) the Status of each as an integer.
    """
    settings, queue = options.settings(), reduced_queue(points, options.friction)
    queue.counts[:, CYCLE] = 2 * periods
    task = Pass(TRAVEL, settings.rtol, settings.rtol, 0, settings.max_steps, False)
    work_through(queue, task, options.friction)
    conversion.restore_states(points, queue.states)
    return queue.states[:, :WIDTH], queue.counts[:, ATTEMPTED], queue.counts[:, OUTCOME]


def reduced_queue(points: np.ndarray, law: str) -> Queue:
    """The queue of points (n, parameters) in SI units, in their own units, at their starts."""
    n = len(points)
    queue = new_queue(np.empty((n, len(Reduced._fields))), np.empty((n, WIDTH + 1)))
    conversion.reduction_kernel(law)(points, queue.points, queue.states)
    return queue


def work_through(queue: Queue, task: Pass, law: str) -> None:
    """One pass of the points of a queue that are ok so far through the lanes, by family."""
    alive = np.flatnonzero(queue.counts[:, OUTCOME] == OK)
    for family, members in families(law, queue.points[alive, _INDEX]):
        rows = alive[members]
        part, lanes = Queue(*(column[rows] for column in queue)), new_lanes()
        while pass_kernel(family)(part, lanes, task, _WORK) > 0:
            pass
        for whole, piece in zip(queue, part, strict=True):
            whole[rows] = piece
