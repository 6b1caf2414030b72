"""The adaptive method for many points at once, in lanes: one of the table `options.METHODS`.

What such a module offers, `options.OFFERED`, is said in the functions of these names.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from stickslip.kernels.adaptive import tangents
from stickslip.kernels.adaptive.adaptive_trajectory import adaptive_trajectory
from stickslip.kernels.adaptive.conversion import conversion_of
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
from stickslip.kernels.adaptive.rows import Orbits, row_kernels
from stickslip.kernels.adaptive.walk import AdaptiveWalk, StochasticWalk, TangentWalk
from stickslip.kernels.families import FamilyKernel, families
from stickslip.kernels.observation import Watched, spreads_of, watch, write_aperiodic
from stickslip.kernels.points import final_columns
from stickslip.kernels.problem import rounding_speed
from stickslip.kernels.trajectories import new_stream
from stickslip.model.models import model_of
from stickslip.model.scaling import Reduced
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import rest_points
from stickslip.options import Options, Physics, Settings
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

# Measurements that begin off the orbit and are made again, at most; and the longest correction of
# the state by Newton's step, in tolerances.
_MOST_CORRECTIONS = 2
_LONGEST_CORRECTION = 100.0

# A state that comes back farther from where it began, in units of the scaled motion, was not near
# the orbit: at a loose tolerance a film can miss the moment in which it freezes.
_ELSEWHERE = 1e-2

# A cycle whose end differs from its begin by more than this, as repetition is judged, was not that
# of the orbit even where it leads there: of ln(phi), that the search lets go by thousands of
# tolerances, it is 1, and the stress is seven times another one.
_MOVED = 1e-3

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
    """The kernels that points of these kinds (n, k) need besides; see `families.KIND`."""
    settings, width = options.settings(), model_of(options.physics).width
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
    either tolerance. The finer measurement is reported, the difference tells its error. Copies
    displaced a little tell how the orbit attracts, and what an offset from it does to what is
    measured; where that is too much, the measurement is made again from nearer to it. Motions
    that approach no orbit are watched over a window instead.

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
    physics = options.physics
    queue = reduced_queue(points, physics)
    _start_elsewhere(points, starts, queue, physics)
    aperiodic = _settle(points, queue, options, patience)
    orbits = _measure(points, queue, options)
    for _ in range(_MOST_CORRECTIONS):
        rows = _off_the_orbit(points, queue, orbits, options)
        if not len(rows):
            break
        part = part_of(queue, rows)
        part.states[:] = _corrected(part, orbits, rows, options)
        part.counts[:, HALVES] += part.counts[:, CYCLE]
        put_back(orbits, rows, _measure(points[rows], part, options, again=True))
        put_back(queue, rows, part)
    orbits.offsets[_moved(orbits)] = np.nan
    finals[:], ends = orbits.begins, queue.states.copy()
    for states in (finals, ends):
        conversion_of(physics).restore_states(points, states)
    write_results = row_kernels(physics).write_results
    write_results(points, queue, orbits, finals, ends, options.settings().rtol, results)
    for rows, watched in aperiodic:
        _write_aperiodic(points, queue, rows, watched, results, finals)


def stochastic_walk(
    points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
) -> StochasticWalk:
    """Motions with noise by chance, a drive period at a time.

    `points` (n, parameters) in SI units; `starts` (n, columns) as `finals`; `streams` (n, STREAM)
    tell their random numbers apart.
    """
    physics = options.physics
    queue = reduced_queue(points, physics.typical)
    _start_elsewhere(points, starts, queue, physics)
    queue = queue._replace(points=np.hstack([queue.points, streams]))
    return StochasticWalk(points, queue, _measuring(_finer(options), options), physics)


def _start_elsewhere(
    points: np.ndarray, starts: np.ndarray, queue: Queue, physics: Physics
) -> None:
    """Put the points for which a start is given (n, columns) into that state."""
    rows = np.flatnonzero(~np.isnan(starts[:, 0]))
    states = starts[rows].copy()
    conversion_of(physics).scale_states(points[rows], states)
    queue.states[rows, :-1] = states[:, :-1]  # the first step stays short


def _measuring(rtol: float, options: Options) -> Pass:
    """The pass that measures cycles at a tolerance."""
    return Pass(MEASURE, rtol, rtol, 0, options.settings().max_steps, False)


def _finer(options: Options) -> float:
    """The tolerance of the measurement that is reported."""
    return max(REFINEMENT * options.settings().rtol, TIGHTEST)


def _measure(points: np.ndarray, queue: Queue, options: Options, *, again: bool = False) -> Orbits:
    """What is known of settled orbits besides the finer measurement, with which the queue returns.

    The queue begins in states on them. The coarser measurement begins where the finer one ends:
    were the first state off the orbit in a way that is soon forgotten, the two would differ. They
    do, too, where the finer one's state is off the coarser one's orbit, whose cusp is rounded
    farther: `again` lets that be forgotten before.
    """
    settings, physics, finer = options.settings(), options.physics, _finer(options)
    components = model_of(physics).components
    begins = queue.states.copy()
    work_through(queue, _measuring(finer, options), physics)
    coarse = part_of(queue, np.arange(len(points)))
    measuring = _measuring(settings.rtol, options)
    if again:
        work_through(coarse, measuring._replace(mode=TRAVEL), physics)
    began = coarse.states.copy()
    work_through(coarse, measuring, physics)
    queue.counts[:, [ATTEMPTED, OUTCOME]] = coarse.counts[:, [ATTEMPTED, OUTCOME]]
    near = tangents.neighbours_of(queue, began, coarse, settings.rtol, physics)
    begun, ended, others_begun, others_ended = (
        tangents.floored(states, components)
        for states in (begins, queue.states, began, coarse.states)
    )
    missed, others_missed = ended - begun, others_ended - others_begun
    offsets = rest_points(near.maps, missed) - missed
    if not again:  # the motion may have gone elsewhere, and the cycle after it show nothing
        offsets[np.abs(missed[:, :2]).max(axis=1) > _ELSEWHERE] = np.nan
    others_offsets = rest_points(near.maps, others_missed) - others_missed
    return Orbits(
        begins,
        coarse.measured,
        tangents.symmetric(queue, begins, settings.stationary_rtol, finer, physics),
        _spreads(points, queue, begins, _measuring(finer, options), physics),
        near.multipliers,
        near.slopes,
        missed=tangents.weighted(missed, components),
        offsets=offsets,
        shifts=others_ended + others_offsets - (ended + offsets),
    )


def _off_the_orbit(
    points: np.ndarray, queue: Queue, orbits: Orbits, options: Options
) -> np.ndarray:
    """The points (m,) whose measurement began off their orbit, as far as what is measured tells.

    The velocity of a block that is locked by a thin film may be off by very little, and the force
    by half of itself. An order parameter that was far off grows back within the cycle, too late
    for the stress of that cycle, and no small displacement tells it.
    """
    off, rtol = np.zeros(len(points), dtype=bool), options.settings().rtol
    row_kernels(options.physics).write_off_the_orbit(points, queue, orbits, rtol, off)
    off |= _moved(orbits)
    return np.flatnonzero(off & ~np.isnan(orbits.offsets[:, 0]))


def _moved(orbits: Orbits) -> np.ndarray:
    """Which of the cycles (n,) that were measured ended elsewhere than they began."""
    return np.asarray(np.abs(orbits.missed).max(axis=1) > _MOVED)


def _corrected(queue: Queue, orbits: Orbits, rows: np.ndarray, options: Options) -> np.ndarray:
    """States (m, width + 1) nearer to their orbits: a cycle farther than those of these rows.

    And by a step of Newton's, where that is a small one. A long step of ln(phi) is left out: the
    film does not answer to it linearly, and follows the motion, which is corrected.
    """
    states, offsets = queue.states.copy(), orbits.offsets[rows]
    small = np.abs(offsets[:, :2]).max(axis=1) <= _LONGEST_CORRECTION * options.rtol
    weighted = tangents.weighted(offsets, model_of(options.physics).components)
    steps = np.where(np.abs(weighted) <= _MOVED, offsets, 0.0)
    states[small, :-1] += steps[small]
    return states


def _settle(
    points: np.ndarray, queue: Queue, options: Options, patience: int
) -> list[tuple[np.ndarray, Watched]]:
    """Bring the points of the queue to their orbits; those that are aperiodic: rows, and as seen.

    A point that wanders is watched, and goes on with a search for longer cycles where its
    neighbours approach it; where there is none either, it is aperiodic. One that takes longer than
    the patience is left pending.
    """
    settings, physics = options.settings(), options.physics
    task = _search_of(settings)
    if 0 < patience < settings.max_periods:
        work_through(queue, task._replace(max_halves=2 * patience), physics)
        unfinished = np.isin(queue.counts[:, OUTCOME], (NOT_STATIONARY, APERIODIC))
        queue.counts[unfinished, OUTCOME] = int(Status.PENDING)
        return []
    pending, aperiodic = np.arange(len(points)), []
    for late in (False, True):
        part = part_of(queue, pending)
        work_through(part, task._replace(late=late), physics)
        put_back(queue, pending, part)
        pending = pending[part.counts[:, OUTCOME] == APERIODIC]
        if not len(pending):
            break
        watching = _measuring(_watching_tolerance(settings), options)
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
    """The queue of a walk, with what came of it; motions that were stopped go on again."""
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
    conversion_of(options.physics).restore_states(points, queue.states)
    return queue.states[:, :-1], queue.counts[:, ATTEMPTED], queue.counts[:, OUTCOME]
