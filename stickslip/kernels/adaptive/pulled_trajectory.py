"""Trajectories of a pulled block by the adaptive method, and their slips.

A slip is a melting of the film, which ends a cycle. The extremes and the mean force of a cycle are
recorded, since equidistant samples miss the peak of a force that falls within microseconds.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import (
    inline,
    jit,
    jit_making_arrays,
    kernel_factory,
    named_kernel,
)
from stickslip.compiled.elementary import exponentials
from stickslip.compiled.fields import make_row_reader, make_tuple_reader
from stickslip.kernels.adaptive.recording import NODES, WEIGHTS, vertex
from stickslip.kernels.parameter_rows import FIRST_STEP
from stickslip.kernels.problem import (
    Problem,
    ProblemFunctions,
    make_travel,
    problem_functions,
    problem_of,
)
from stickslip.kernels.trajectories import make_write_observables
from stickslip.model import drive, solids
from stickslip.model.state import FILM, State
from stickslip.numerics.adaptive import OK
from stickslip.numerics.linear import algebra
from stickslip.options import Physics, Settings

_parameters_of = make_row_reader(drive.PulledParameters)

CYCLE = ("end", "least_x", "largest_x", "least_force", "largest_force", "force_time")
"""Columns of a cycle: when it ended [s], the extremes of x [m] and F [N], and the integral of F
[N s]."""
_END, _LEAST_X, _LARGEST_X, _LEAST_F, _LARGEST_F, _FORCE_TIME = range(len(CYCLE))

# Halvings that locate a melting within a step to the last bit.
_HALVINGS = 60


class Seen(NamedTuple):
    """The samples and cycles of a trajectory so far.

    `samples` (n, columns) are at the times j*spacing. `cycles` (m, columns) are in the order of
    `CYCLE`; the last one is unfinished. `counts` holds the next sample, the number of finished
    cycles, and whether the film has been solid in the present cycle.
    """

    samples: np.ndarray
    spacing: float
    cycles: np.ndarray
    counts: np.ndarray


@inline
def _see_extremum(row: np.ndarray, lowest: int, value: float) -> None:
    row[lowest] = min(row[lowest], value)
    row[lowest + 1] = max(row[lowest + 1], value)


@jit
def begin_cycle(row: np.ndarray) -> None:
    """Prepare the row (columns,) of a new cycle."""
    row[_END], row[_FORCE_TIME] = np.nan, 0.0
    row[_LEAST_X], row[_LEAST_F] = np.inf, np.inf
    row[_LARGEST_X], row[_LARGEST_F] = -np.inf, -np.inf


def _make_sample(physics: Physics, functions: ProblemFunctions) -> Any:
    """Return the function (problem, t, y, row) that writes a sample.

    Its columns are (x, v, phi) and `trajectories.OBSERVABLES`.
    """
    relative_state = functions.equations.relative_state
    write_observables = make_write_observables(physics)

    @jit
    def sample(problem: Problem, t: float, y: State, row: np.ndarray) -> None:
        p, (phi, _) = problem.p, exponentials(y[FILM])
        row[0], row[1], row[2] = y[0], relative_state(p, t, y)[1], phi
        write_observables(p, t, y, phi, problem.u_s, row[3:])

    return sample


def _make_melting(functions: ProblemFunctions) -> Any:
    """Return the function (solid, y0, y1, d1, d2) of the part of a step before the film melts."""
    interpolate = algebra(functions.width).interpolate

    @jit
    def melting(solid: float, y0: State, y1: State, d1: State, d2: State) -> float:
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            psi = interpolate(middle, y0, y1, d1, d2)[FILM]
            melted = exponentials(psi)[0] <= solids.MELTED_PART * solid
            low, high = (low, middle) if melted else (middle, high)
        return high

    return melting


def _make_see_extremes(functions: ProblemFunctions) -> Any:
    """Return the function (problem, h, y0, y1, d1, d2, row) that adds a step to a cycle."""
    observables, interpolate = functions.equations.observables, algebra(functions.width).interpolate

    @inline
    def force(problem: Problem, y: State) -> float:
        return observables(problem.p, y, exponentials(y[FILM])[0], problem.u_s)[1]

    @jit_making_arrays
    def see_extremes(
        problem: Problem, h: float, y0: State, y1: State, d1: State, d2: State, row: np.ndarray
    ) -> None:
        xs, forces, total = np.empty(4), np.empty(4), 0.0
        for i in range(4):
            y = interpolate(NODES[i], y0, y1, d1, d2)
            xs[i], forces[i] = y[0], force(problem, y)
            total += WEIGHTS[i] * forces[i]
            _see_extremum(row, _LEAST_X, xs[i])
            _see_extremum(row, _LEAST_F, forces[i])
        row[_FORCE_TIME] += h * total
        for i in range(2):  # two parabolas, each through three neighbouring nodes
            begin, end = NODES[i], NODES[i + 2]
            place = vertex(begin, NODES[i + 1], end, xs[i], xs[i + 1], xs[i + 2])
            if begin < place < end:
                _see_extremum(row, _LEAST_X, interpolate(place, y0, y1, d1, d2)[0])
            place = vertex(begin, NODES[i + 1], end, forces[i], forces[i + 1], forces[i + 2])
            if begin < place < end:
                y = interpolate(place, y0, y1, d1, d2)
                _see_extremum(row, _LEAST_F, force(problem, y))

    return see_extremes


def _make_see_cycle(functions: ProblemFunctions) -> Any:
    """Return the function (problem, t, h, y0, y1, d1, d2, seen) that adds a step to the cycles."""
    see_extremes, melting = _make_see_extremes(functions), _make_melting(functions)

    @jit
    def see_cycle(
        problem: Problem, t: float, h: float, y0: State, y1: State, d1: State, d2: State, seen: Seen
    ) -> None:
        counts, solid = seen.counts, problem.phases.solid
        row, phi = seen.cycles[counts[1]], exponentials(y1[FILM])[0]
        see_extremes(problem, h, y0, y1, d1, d2, row)
        if phi >= solid:
            counts[2] = 1
        elif phi <= solids.MELTED_PART * solid and counts[2] == 1:
            row[_END] = t + melting(solid, y0, y1, d1, d2) * h
            counts[2] = 0
            if counts[1] + 1 < seen.cycles.shape[0]:
                counts[1] += 1
                begin_cycle(seen.cycles[counts[1]])

    return see_cycle


@kernel_factory
def pulled_trajectory(physics: Physics) -> Any:
    """Return the kernel of the trajectory of a pulled block.

    It maps (sections, ends, jumps, settings, start, spacing, samples, cycles, counts) to the Status
    as an integer. `sections` (m, columns) are in the order of `drive.PulledParameters`. Each lasts
    until its time in `ends` (m,), and `jumps` (m,) says whether it begins with a jump of V. `start`
    (width,) is the state (x, v, ln phi, ...); the other arrays are those of `Seen`. The kernel ends
    early, with OK, when there is no room for another cycle.
    """
    functions = problem_functions(physics)
    width, relative_state = functions.width, functions.equations.relative_state
    interpolate = algebra(width).interpolate
    write_sample, see_cycle = _make_sample(physics, functions), _make_see_cycle(functions)
    row_state = make_tuple_reader(width)

    @inline
    def observe(
        problem: Problem, t: float, h: float, y0: State, y1: State, d1: State, d2: State, seen: Seen
    ) -> None:
        counts = seen.counts
        while counts[0] < seen.samples.shape[0] and counts[0] * seen.spacing < t + h:
            time = counts[0] * seen.spacing
            y = interpolate((time - t) / h, y0, y1, d1, d2)
            write_sample(problem, time, y, seen.samples[counts[0]])
            counts[0] += 1
        see_cycle(problem, t, h, y0, y1, d1, d2, seen)

    travel = make_travel(functions, observe)

    def trajectory(
        sections: np.ndarray,
        ends: np.ndarray,
        jumps: np.ndarray,
        settings: Settings,
        start: np.ndarray,
        spacing: float,
        samples: np.ndarray,
        cycles: np.ndarray,
        counts: np.ndarray,
    ) -> int:
        seen = Seen(samples, spacing, cycles, counts)
        begin_cycle(cycles[0])
        p = _parameters_of(sections[0])
        problem = problem_of(p, settings.rtol)
        period = drive.period(p)  # of the free block, the same in all sections
        y, h, begin = relative_state(p, 0.0, row_state(start)), FIRST_STEP * period, 0.0
        steps, status = 0, OK
        for i in range(sections.shape[0]):
            q = _parameters_of(sections[i])
            if jumps[i]:  # v is continuous, V - v is not; the last step is no guide to the next
                y, h = relative_state(q, begin, relative_state(p, begin, y)), FIRST_STEP * period
            p, problem = q, problem_of(q, settings.rtol)
            left = settings.max_steps - steps
            y, h, used, status = travel(problem, settings.rtol, begin, ends[i], y, h, left, seen)
            begin, steps = ends[i], steps + used
            if status != OK:
                return status
        write_sample(problem, begin, y, samples[samples.shape[0] - 1])
        return status

    return named_kernel(f"pulled_trajectory[{physics}]", trajectory)
