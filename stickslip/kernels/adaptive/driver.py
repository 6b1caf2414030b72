"""The adaptive method for many points at once, in lanes, a module in the table `options.METHODS`.

Every module in that table has the functions in `options.OFFERED`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from stickslip.kernels.adaptive import tangents
from stickslip.kernels.adaptive.adaptive_trajectory import adaptive_trajectory
from stickslip.kernels.adaptive.march import AdaptiveMarch, AdaptiveWalk, StochasticWalk
from stickslip.kernels.adaptive.mirror_images import symmetric
from stickslip.kernels.adaptive.passes import (
    MEASURE,
    TRAVEL,
    VARY,
    Pass,
    new_lanes,
    pass_kernel,
    work_through,
)
from stickslip.kernels.adaptive.rows import Orbits, measured_of, row_kernels
from stickslip.kernels.families import FamilyKernel, families
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.finding import find_orbits
from stickslip.kernels.orbits.motions import (
    ATTEMPTED,
    CYCLE,
    HALVES,
    OUTCOME,
    Motions,
    motions_of,
    new_motions,
    part_of,
    put_back,
)
from stickslip.kernels.orbits.settling import (
    APERIODIC,
    NOT_STATIONARY,
    REFINEMENT,
    TIGHTEST,
    Search,
    search_kernels,
    settle,
)
from stickslip.kernels.orbits.watching import Watched, aperiodic_rows, spreads_of
from stickslip.kernels.parameter_rows import write_results
from stickslip.model.drive import lengthened
from stickslip.model.models import model_of
from stickslip.model.scaling import Reduced
from stickslip.numerics.adaptive import OK
from stickslip.numerics.spectrum import rest_points
from stickslip.options import Options, Settings
from stickslip.status import Status

# The largest number of repetitions of a measurement that began off the orbit, and the longest
# correction of the state by a Newton step, in tolerances.
_MOST_CORRECTIONS = 2
_LONGEST_CORRECTION = 100.0

# A state that returns farther than this from its start, in units of the scaled motion, was not near
# the orbit. At a loose tolerance a film can miss the moment at which it freezes.
_ELSEWHERE = 1e-2

# If the end of a cycle differs from its start by more than this, weighted as in the test of
# repetition, the cycle is not on the orbit, even if it ends there. The limit is a difference of 1
# in ln(phi). The search accepts differences of up to thousands of tolerances, and the stress can
# then differ by a factor of seven.
_MOVED = 1e-3

# Wandering motions are watched with this fraction of the tolerance. The second number limits how
# fine this fraction may make it.
_WATCHED_PART, _WATCHED = 1e-2, 1e-8

# The largest distance at which a limit counts as reached; beyond it long cycles close by accident.
_LOOSEST = 1e-4

trajectory_kernel = adaptive_trajectory


def family_kernels(kinds: np.ndarray, options: Options) -> Iterator[FamilyKernel]:
    """Yield the additional kernels for points of these kinds (n, k), as in `families.KIND`."""
    width, no_rows = model_of(options.physics).width, np.empty(0, np.int64)
    for family, _ in families(options.physics, kinds):
        no_points = new_motions(np.empty((0, len(Reduced._fields))), np.empty((0, width + 1)))
        kernel, nothing = pass_kernel(family), Pass(TRAVEL, 0, 0)
        yield FamilyKernel(
            kernel, partial(kernel, no_points, no_rows, new_lanes(width, 0), nothing, 0)
        )
    yield from search_kernels(kinds, options.physics)


def largest_step(points: np.ndarray, options: Options) -> np.ndarray:
    """Return the largest stable fixed step [s] of each point (n, parameters), which is infinite."""
    return np.full(len(points), np.inf)


def rounding(options: Options) -> float:
    """Return the tolerance at which the method rounds a cusp of the law, as in `rounding_speed`."""
    return options.rtol


def orbits(
    points: np.ndarray,
    options: Options,
    starts: np.ndarray,
    results: np.ndarray,
    finals: np.ndarray,
    patience: int = 0,
) -> None:
    """Compute stationary orbits.

    This takes three passes: one to the orbit, at `rtol` and finally a tenth of it, and one over the
    orbit at each of these tolerances. The finer measurement is reported, and the difference gives
    its error. Small displacements, which are integrated too, show how strongly the orbit attracts
    and how an offset from it affects the measurement. If it does so too much, the measurement is
    repeated from nearer to the orbit. Motions that approach no orbit are watched over a window.

    Parameters
    ----------
    points
        (n, parameters) in SI units, in the order of `Parameters._fields`.
    options
        Tolerances, budgets, the physics.
    starts
        (n, columns) initial states, in the layout of `finals`; a row of NaN stands for the start
        of the point.
    results
        (n, columns), output in the order of `variables.RESULT_COLUMNS`.
    finals
        (n, columns), output in the order of `parameter_rows.final_columns`.
    patience
        Drive periods after which a point is left pending; 0 means no limit.
    """
    physics = options.physics
    motions = motions_of(points, physics, starts)
    aperiodic = _settle(points, motions, options, patience)
    orbits = _measure(points, motions, options)
    for _ in range(_MOST_CORRECTIONS):
        rows = _off_the_orbit(points, motions, orbits, options)
        if not len(rows):
            break
        part = part_of(motions, rows)
        part.states[:] = _corrected(part, orbits, rows, options)
        # The state is at the end of the measured cycle, which counts as integrated.
        part.counts[:, HALVES] += part.counts[:, CYCLE]
        put_back(orbits, rows, _measure(points[rows], part, options, again=True))
        put_back(motions, rows, part)
    # If a motion still moves after all corrections, its offset, and so its error, is unknown.
    orbits.offsets[_moved(orbits)] = np.nan
    finals[:], ends = orbits.begins, motions.states.copy()
    for states in (finals, ends):
        conversion_of(physics).restore_states(points, states)
    rtol = options.settings().rtol
    measured = measured_of(points, motions, orbits, finals, ends, rtol, physics)
    write_results(points, measured, results)
    for rows, watched in aperiodic:
        periods = (motions.counts[rows, HALVES] + 1) // 2
        results[rows] = aperiodic_rows(points[rows], watched, periods)
        finals[rows] = watched.ends


def stochastic_walk(
    points: np.ndarray, starts: np.ndarray, streams: np.ndarray, options: Options
) -> StochasticWalk:
    """Return motions with stochastic noise, which advance one drive period at a time.

    `points` (n, parameters) are in SI units, `starts` (n, columns) in the layout of `finals`.
    `streams` (n, STREAM) identify their random numbers.
    """
    physics = options.physics
    motions = motions_of(points, physics.typical, starts)
    motions = motions._replace(points=np.hstack([motions.points, streams]))
    return StochasticWalk(points, motions, _finer(options), options.settings().max_steps, physics)


def _finer(options: Options) -> float:
    """Return the tolerance of the reported measurement."""
    return max(REFINEMENT * options.settings().rtol, TIGHTEST)


def _measure(
    points: np.ndarray, motions: Motions, options: Options, *, again: bool = False
) -> Orbits:
    """Measure settled orbits; the motions keep the finer measurement, the rest is returned.

    The motions begin in states on the orbits. The coarser measurement begins where the finer one
    ends, so that the two differ if the first state had an offset from the orbit that decays
    quickly. They also differ if the state of the finer one is off the coarser orbit, whose cusp is
    rounded more widely; with `again` this offset first decays over a cycle.
    """
    settings, physics, finer = options.settings(), options.physics, _finer(options)
    components, most = model_of(physics).components, settings.max_steps
    begins = motions.states.copy()
    work_through(motions, VARY, finer, most, physics)
    coarse = part_of(motions, np.arange(len(points)))
    if again:
        work_through(coarse, TRAVEL, settings.rtol, most, physics)
    began = coarse.states.copy()
    work_through(coarse, MEASURE, settings.rtol, most, physics)
    motions.counts[:, [ATTEMPTED, OUTCOME]] = coarse.counts[:, [ATTEMPTED, OUTCOME]]
    near = tangents.neighbours_of(motions, begins, finer, physics)
    motions.counts[near.unstable, OUTCOME] = int(Status.UNSTABLE)
    begun, ended, others_begun, others_ended = (
        tangents.floored(states, components)
        for states in (begins, motions.states, began, coarse.states)
    )
    missed, others_missed = ended - begun, others_ended - others_begun
    offsets = rest_points(near.maps, missed) - missed
    if not again:  # the motion may have left the orbit, which a later cycle would not show
        offsets[np.abs(missed[:, :2]).max(axis=1) > _ELSEWHERE] = np.nan
    others_offsets = rest_points(near.maps, others_missed) - others_missed
    return Orbits(
        begins,
        coarse.measured,
        symmetric(motions, begins, settings.stationary_rtol, finer, physics),
        _spreads(points, motions, begins, options),
        near.multipliers,
        near.slopes,
        missed=tangents.weighted(missed, components),
        offsets=offsets,
        shifts=others_ended + others_offsets - (ended + offsets),
    )


def _off_the_orbit(
    points: np.ndarray, motions: Motions, orbits: Orbits, options: Options
) -> np.ndarray:
    """Return the points (m,) whose measurement clearly began off their orbit.

    If a thin film locks a block, a minute error of the velocity may change the force by half. An
    order parameter that was far off recovers within the cycle, too late for the stress of that
    cycle, and small displacements do not reveal it.
    """
    off, rtol = np.zeros(len(points), dtype=bool), options.settings().rtol
    write = row_kernels(options.physics).write_off_the_orbit
    write(points, lengthened(points), motions, orbits, rtol, off)
    off |= _moved(orbits)
    return np.flatnonzero(off & ~np.isnan(orbits.offsets[:, 0]))


def _moved(orbits: Orbits) -> np.ndarray:
    """Return which measured cycles (n,) did not end where they began."""
    return np.asarray(np.abs(orbits.missed).max(axis=1) > _MOVED)


def _corrected(motions: Motions, orbits: Orbits, rows: np.ndarray, options: Options) -> np.ndarray:
    """Return states (m, width + 1) nearer to the orbits of these rows.

    These are the states a cycle later, corrected by a Newton step if that is small. A long step of
    ln(phi) is left out, because the film does not respond linearly to it and follows the motion,
    which is corrected.
    """
    states, offsets = motions.states.copy(), orbits.offsets[rows]
    small = np.abs(offsets[:, :2]).max(axis=1) <= _LONGEST_CORRECTION * options.rtol
    weighted = tangents.weighted(offsets, model_of(options.physics).components)
    steps = np.where(np.abs(weighted) <= _MOVED, offsets, 0.0)
    states[small, :-1] += steps[small]
    return states


def _settle(
    points: np.ndarray, motions: Motions, options: Options, patience: int
) -> list[tuple[np.ndarray, Watched]]:
    """Bring motions to their orbits; return rows and records of the aperiodic ones.

    A point that takes longer than the patience is left pending.
    """
    settings = options.settings()
    distance = min(settings.stationary_rtol, _LOOSEST)
    task = Search(settings.rtol, distance, 2 * settings.max_periods, settings.accelerate)
    watched = _watching_tolerance(settings)
    march = AdaptiveMarch(points, motions, options.physics, settings.max_steps, watched)
    if not 0 < patience < settings.max_periods:
        return find_orbits(march, task, settings.window)
    settle(march, np.arange(len(points)), task._replace(max_halves=2 * patience))
    unfinished = np.isin(motions.counts[:, OUTCOME], (NOT_STATIONARY, APERIODIC))
    motions.counts[unfinished, OUTCOME] = int(Status.PENDING)
    return []


def _watching_tolerance(settings: Settings) -> float:
    """Return the tolerance to which wandering motions are integrated while they are watched.

    Chaos amplifies the errors of the integrator until they affect the statistics, so this is finer
    than the user's tolerance. There is a limit, since the length of the window limits the
    statistics anyway.
    """
    finer = min(max(_WATCHED_PART * settings.rtol, _WATCHED), REFINEMENT * settings.rtol)
    return max(finer, TIGHTEST)


def _spreads(
    points: np.ndarray, motions: Motions, begins: np.ndarray, options: Options
) -> np.ndarray:
    """Return standard deviations (n, 2) of the amplitudes of single drive periods, in SI units."""
    spreads = np.zeros((len(points), 2))
    rows = np.flatnonzero((motions.counts[:, OUTCOME] == OK) & (motions.counts[:, CYCLE] > 2))
    if len(rows):
        part, cycles = part_of(motions, rows), motions.counts[rows, CYCLE]
        part.states[:] = begins[rows]
        # A cycle of an odd number of half periods is half an orbit.
        periods = np.where(cycles % 2 == 1, cycles, cycles // 2)
        most = options.settings().max_steps
        walk = AdaptiveWalk(points[rows], part, _finer(options), most, options.physics)
        spreads[rows] = spreads_of(walk, periods)
    return spreads
