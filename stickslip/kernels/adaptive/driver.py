"""The adaptive method for many points at once, in lanes: one of the table `options.METHODS`.

What such a module offers is said in `compile_shared`, `family_kernels`, `orbits`,
`stochastic_walk`, `trajectory`, `largest_step` and `rounding`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from stickslip.kernels.adaptive import conversion, tangents
from stickslip.kernels.adaptive.passes import (
    APERIODIC,
    ATTEMPTED,
    CYCLE,
    HALVES,
    MEASURE,
    NOT_STATIONARY,
    OUTCOME,
    REFINEMENT,
    SETTLE,
    TIGHTEST,
    TRAVEL,
    Pass,
    Queue,
    new_lanes,
    new_queue,
    pass_kernel,
)
from stickslip.kernels.adaptive.queues import part_of, put_back, reduced_queue, work_through
from stickslip.kernels.adaptive.walk import AdaptiveWalk, StochasticWalk, TangentWalk
from stickslip.kernels.families import FamilyKernel, families
from stickslip.kernels.observation import Watched, spreads_of, watch, write_aperiodic
from stickslip.kernels.points import final_columns
from stickslip.kernels.problem import rounding_speed
from stickslip.kernels.trajectories import adaptive_trajectory, new_stream
from stickslip.model.scaling import Reduced
from stickslip.model.state import components_of
from stickslip.numerics.adaptive import OK
from stickslip.options import RELAXING, Options, Physics, Settings
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

# Wandering motions are watched with this part of the tolerance, but not more finely than this for
# its own sake.
_WATCHED_PART, _WATCHED = 1e-2, 1e-8

# The largest distance to a limit that counts as none: beyond it long cycles close by accident.
_LOOSEST = 1e-4


def compile_shared(options: Options) -> None:
    """Compile or load what all points need."""
    nobody, columns = np.empty((0, len(Parameters._fields))), final_columns(options.physics)
    results, finals = (np.empty((0, len(names))) for names in (RESULT_COLUMNS, columns))
    orbits(nobody, options, finals, results, finals)


def family_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """The kernels that points of these kinds (n, 2) need besides; see `families.KIND`."""
    settings, width = options.settings(), len(components_of(options.strain))
    task = Pass(TRAVEL, settings.rtol, settings.rtol, 0, 0, False)
    for family, _ in families(options.physics, kinds):
        nobody = new_queue(np.empty((0, len(Reduced._fields))), np.empty((0, width + 1)))
        kernel = pass_kernel(family)
        yield FamilyKernel(kernel, partial(kernel, nobody, new_lanes(width), task, 0))


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """Largest fixed step [s] that is stable for each point (n, parameters); here any."""
    return np.full(len(points), np.inf)


def rounding(p: Parameters, options: Options) -> float:
    """Relative speed [m/s] below which the method rounds a cusp of the law."""
    return float(rounding_speed(p, options.rtol))


def trajectory(
    point: np.ndarray,
    options: Options,
    start: np.ndarray,
    per_period: int,
    samples: np.ndarray,
    stream: np.ndarray | None = None,
) -> int:
    """A sampled trajectory; returns the Status as an integer.

    `point` (parameters,); `start` (width,) the state at phase 0; `samples`
    (periods*per_period + 1, width) receives (x, v, phi, ...) at equal times; `stream`, as of
    `trajectories.new_stream`, the random numbers where the noise is left to chance, is moved on.
    """
    kernel, taken = adaptive_trajectory(options.physics), new_stream() if stream is None else stream
    return int(kernel(point, options.settings(), start, per_period, taken, samples))


def orbits(
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
    patience: int = 0,
) -> None:
    """Stationary orbits.

    Three passes: to the orbit, at `rtol` and in the end a tenth of it; once over the orbit at
    either tolerance. The finer measurement is reported, the difference is its error. Copies
    displaced a little tell how the orbit attracts. Motions that approach no orbit are watched over
    a window instead.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    options
        Tolerances, budgets, the physics.
    starts
        (n, columns) states to start from, as `finals`; a row of NaN means the point's own start.
    results
        (n, columns), written in the order of `variables.RESULT_COLUMNS`.
    finals
        (n, columns), written in the order of `points.final_columns`.
    patience
        Drive periods after which a point is left pending; 0 for as long as it takes.
    """
    settings, physics = options.settings(), options.physics
    queue = reduced_queue(points, physics)
    _start_elsewhere(points, starts, queue, physics)
    measuring = Pass(MEASURE, settings.rtol, settings.rtol, 0, settings.max_steps, False)
    finer = measuring._replace(rtol=max(REFINEMENT * settings.rtol, TIGHTEST))
    watching = measuring._replace(rtol=_watching_tolerance(settings))
    aperiodic = _settle(points, queue, options, watching, patience)
    begins = queue.states.copy()
    work_through(queue, measuring, physics)
    coarse, ends = queue.measured.copy(), queue.states.copy()
    queue.states[:] = begins
    work_through(queue, finer, physics)
    orbits = conversion.Orbits(
        begins,
        coarse,
        ends,
        tangents.symmetric(queue, begins, settings.stationary_rtol, finer.rtol, physics),
        _spreads(points, queue, begins, finer, physics),
        tangents.multipliers_of(queue, begins, ends, settings.rtol, physics),
    )
    relaxing = physics.strain == RELAXING
    conversion.write_results(points, queue, orbits, settings.rtol, relaxing, results)
    finals[:] = begins
    conversion.restore_states(points, finals, relaxing)
    for rows, watched in aperiodic:
        _write_aperiodic(points, queue, rows, watched, results, finals)


def stochastic_walk(
    points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
) -> StochasticWalk:
    """Motions with noise by chance, a drive period at a time.

    `points` (n, parameters) in SI units; `starts` (n, columns) as `finals`; `streams` (n, STREAM)
    tell their random numbers apart.
    """
    settings, physics = options.settings(), options.physics
    queue = reduced_queue(points, physics.typical)
    _start_elsewhere(points, starts, queue, physics)
    queue = queue._replace(points=np.hstack([queue.points, streams]))
    finer = max(REFINEMENT * settings.rtol, TIGHTEST)
    task = Pass(MEASURE, finer, finer, 0, settings.max_steps, False)
    return StochasticWalk(points, queue, task, physics)


def _start_elsewhere(
    points: np.ndarray, starts: np.ndarray, queue: Queue, physics: Physics
) -> None:
    """Put the points for which a start is given (n, columns) into that state."""
    rows = np.flatnonzero(~np.isnan(starts[:, 0]))
    states = starts[rows].copy()
    conversion.scale_states(points[rows], states, physics.strain == RELAXING)
    queue.states[rows, :-1] = states[:, :-1]  # the first step stays short


def _settle(
    points: np.ndarray, queue: Queue, options: Options, watching: Pass, patience: int
) -> list[tuple[np.ndarray, Watched]]:
    """Bring the points of the queue to their orbits; those that are aperiodic: rows, and as seen.

    A point that wanders is watched, and goes on with a search for longer cycles where its neighbours
    approach it; where there is none either, it is aperiodic. One that takes longer than the patience
    is left pending.
    """
    settings, physics = options.settings(), options.physics
    task = _search_of(settings)
    if 0 < patience < settings.max_periods:
        work_through(queue, task._replace(max_halves=2 * patience), physics)
        late = np.isin(queue.counts[:, OUTCOME], (NOT_STATIONARY, APERIODIC))
        queue.counts[late, OUTCOME] = int(Status.PENDING)
        return []
    pending, aperiodic = np.arange(len(points)), []
    for late in (False, True):
        part = part_of(queue, pending)
        work_through(part, task._replace(late=late), physics)
        put_back(queue, pending, part)
        pending = pending[part.counts[:, OUTCOME] == APERIODIC]
        if not len(pending):
            break
        walk = TangentWalk(points[pending], part_of(queue, pending), watching, physics)
        watched = watch(walk, settings.window, decisive=late)
        put_back(queue, pending, _after_watching(walk, watched))
        found = watched.aperiodic
        aperiodic.append((pending[found], watched.part(found)))
        pending = pending[queue.counts[pending, OUTCOME] == OK]
    return aperiodic


def _watching_tolerance(settings: Settings) -> float:
    """The tolerance with which wandering motions are watched.

    Chaos enlarges what the integrator adds, until it decides on the statistics: so it is finer than
    what is asked for, but the statistics are no better than their window.
    """
    finer = min(max(_WATCHED_PART * settings.rtol, _WATCHED), REFINEMENT * settings.rtol)
    return max(finer, TIGHTEST)


def _search_of(settings: Settings) -> Pass:
    """The pass that brings points to their orbits."""
    distance = min(settings.stationary_rtol, _LOOSEST)
    halves, steps = 2 * settings.max_periods, settings.max_steps
    return Pass(SETTLE, settings.rtol, distance, halves, steps, settings.accelerate)


def _after_watching(walk: TangentWalk, watched: Watched) -> Queue:
    """The queue of a walk, with what came of it; motions that were stopped are on their way again."""
    queue = walk.queue
    outcomes = queue.counts[:, OUTCOME]
    queue.counts[:, HALVES] += 2 * watched.periods
    outcomes[outcomes == int(Status.PENDING)] = OK
    outcomes[watched.aperiodic] = APERIODIC
    return queue


def _write_aperiodic(
    points: np.ndarray,
    queue: Queue,
    rows: np.ndarray,
    watched: Watched,
    results: np.ndarray,
    finals: np.ndarray,
) -> None:
    """Write the rows (m,) that are aperiodic, with arrays as of `orbits`."""
    own = np.empty((len(rows), results.shape[1]))
    write_aperiodic(points[rows], watched, (queue.counts[rows, HALVES] + 1) // 2, own)
    results[rows], finals[rows] = own, watched.ends


def _spreads(
    points: np.ndarray, queue: Queue, begins: np.ndarray, measuring: Pass, physics: Physics
) -> np.ndarray:
    """Standard deviations (n, 2) of the amplitudes of single drive periods, SI units."""
    spreads = np.zeros((len(points), 2))
    rows = np.flatnonzero((queue.counts[:, OUTCOME] == OK) & (queue.counts[:, CYCLE] > 2))
    if len(rows):
        part, cycles = part_of(queue, rows), queue.counts[rows, CYCLE]
        part.states[:] = begins[rows]
        periods = np.where(cycles % 2 == 1, cycles, cycles // 2)
        spreads[rows] = spreads_of(AdaptiveWalk(points[rows], part, measuring, physics), periods)
    return spreads


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
        (n, width): x [m], v [m/s], ln(phi) ...; where the lane stopped unless the status is ok.
    steps
        (n,) attempted steps.
    statuses
        (n,) the Status of each as an integer.
    """
    settings, queue = options.settings(), reduced_queue(points, options.physics)
    queue.counts[:, CYCLE] = 2 * periods
    task = Pass(TRAVEL, settings.rtol, settings.rtol, 0, settings.max_steps, False)
    work_through(queue, task, options.physics)
    conversion.restore_states(points, queue.states, options.strain == RELAXING)
    return queue.states[:, :-1], queue.counts[:, ATTEMPTED], queue.counts[:, OUTCOME]
