"""What benchmarks use of the inside of the package: all of it stands here.

A benchmark that counts, times or replaces something below `stickslip.orbit` does so by this file
alone, so that a change of the kernels touches no other benchmark.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.fields import make_lane_reader, make_map, make_tuple_maker
from stickslip.kernels.adaptive import conversion, passes, queues
from stickslip.kernels.adaptive.driver import end_states
from stickslip.kernels.adaptive.queues import reduced_queue, work_through
from stickslip.kernels.adaptive.recording import SLOTS, get
from stickslip.kernels.euler_cromer import judging
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.euler_cromer.layout import write_starts, write_steps
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.euler_cromer.reference import Known
from stickslip.kernels.families import Family, families
from stickslip.kernels.points import FIRST_STEP, parameters_of
from stickslip.kernels.problem import ProblemFunctions, problem_functions, problem_of
from stickslip.kernels.trajectories import write_start
from stickslip.measure.accumulate import (
    FIRST_PHASE,
    FORCE_MAX,
    FORCE_MIN,
    LAST_PHASE,
    MELTED,
    MELTINGS,
    RECORD,
    SOLID,
    STRESS_MAX,
    STRESS_MIN,
    accumulator,
)
from stickslip.measure.results import relative_difference
from stickslip.model import drive, solids
from stickslip.model.rhs import equations, relative_state
from stickslip.model.scaling import KEPT, LITERALS, Reduced
from stickslip.model.state import STATE
from stickslip.numerics import step_control
from stickslip.numerics.adaptive import make_adaptive
from stickslip.numerics.linear import algebra, larger
from stickslip.numerics.tableaus import RODAS4P2, RosenbrockTableau
from stickslip.options import DEFAULTS, METHODS, Options, Physics
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import RESULT_COLUMNS

__all__ = ["FIRST_STEP", "March", "end_states", "problem_of"]  # passed on, beside what is made here

State = tuple[float, float, float]
PHYSICS, WIDTH = DEFAULTS.physics, len(STATE)

_LOOKS = 32  # at a step: enough that between two of them nothing is 1e-8 higher
_record = accumulator(1, 0)
_interpolate = algebra(WIDTH).interpolate
_observables = equations(PHYSICS).observables

# --- the scalar adaptive drive --------------------------------------------------------------------

FUNCTIONS: ProblemFunctions = problem_functions(PHYSICS)
"""The right-hand side, the Jacobian and the error weights of the model."""


def adaptive_drive(weight: Any, observe: Any, tableau: RosenbrockTableau) -> Any:
    """The scalar adaptive drive with these error weights and this tableau."""
    return make_adaptive(
        FUNCTIONS.rhs, FUNCTIONS.jacobian, weight, observe, tableau, algebra(WIDTH)
    )


# --- one trajectory, scalar -----------------------------------------------------------------------


def starting_state(row: np.ndarray) -> State:
    """The state (x, v, ln phi) at the start of a row of parameters (20,)."""
    state = np.empty(WIDTH)
    write_start(row, state)
    return float(state[0]), float(state[1]), float(state[2])


def scalar_end(row: np.ndarray, options: Options, periods: int) -> tuple[float, int]:
    """The displacement x [m] after some periods by the scalar drive of a method, and the status."""
    samples, start = np.empty((periods + 1, WIDTH)), np.array(starting_state(row))
    status = METHODS[options.method].kernels.trajectory(row, options, start, 1, samples)
    return float(samples[-1, 0]), int(status)


@cache
def _scalar_periods(observed: bool) -> Any:
    """Periods by the scalar drive: (row, rtol, state, states, record) to a status.

    With so many looks at stress and force in each step, or without.
    """

    @inline
    def ignore(
        problem: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any
    ) -> None:
        pass

    @inline
    def look(
        problem: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any
    ) -> None:
        solid = solids.solid_threshold(problem.p)
        for i in range(1, _LOOKS + 1):
            y = _interpolate(i / _LOOKS, y0, y1, d1, d2)
            phi = math.exp(y[2])
            sigma, force = _observables(problem.p, y, phi, problem.u_s)
            _record.see_extremum(record, 0, STRESS_MAX, sigma, True)
            _record.see_extremum(record, 0, FORCE_MAX, force, True)
            _record.see_phase(record, 0, phi, solid, solids.MELTED_PART * solid, 0.0, True)

    drive_on = adaptive_drive(FUNCTIONS.error_weight, look if observed else ignore, RODAS4P2)

    @jit
    def periods(row: Any, rtol: float, state: Any, states: Any, record: Any) -> int:
        p = parameters_of(row)
        problem, h = problem_of(p, rtol), FIRST_STEP * drive.period(p)
        y = relative_state(p, 0.0, (state[0], state[1], state[2]))
        for n in range(states.shape[0]):
            y, h, _, status = drive_on(problem, rtol, 0.0, drive.period(p), y, h, 10**8, record)
            if status != 0:
                return status
            motion = relative_state(p, 0.0, y)
            for i in range(3):
                states[n, i] = motion[i]
        return 0

    return periods


def scalar_states(row: np.ndarray, state: np.ndarray, periods: int, rtol: float) -> np.ndarray:
    """States (periods, 3), (x, v, ln phi), after each of some periods by the scalar drive."""
    states, record = np.empty((periods, 3)), np.empty(RECORD)
    assert _scalar_periods(False)(row, rtol, state, states, record) == 0
    return states


def scalar_amplitudes(
    row: np.ndarray, state: np.ndarray, periods: int, rtol: float
) -> tuple[float, float, int]:
    """Amplitudes of stress [Pa] and force [N] over some periods from a state, and meltings."""
    states, record = np.empty((periods, 3)), np.empty(RECORD)
    _record.clear(record, 0)
    assert _scalar_periods(True)(row, rtol, state, states, record) == 0
    wrapped = record[LAST_PHASE] == SOLID and record[FIRST_PHASE] == MELTED
    stress, force = _amplitudes(record[None])[0]
    return float(stress), float(force), int(record[MELTINGS]) + int(wrapped)


# --- passes of many points through the lanes of the adaptive method -------------------------------


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
    work_through(queue, _search(options), PHYSICS)
    return queue


def attempts_of(points: np.ndarray, options: Options) -> Attempts:
    """What the three passes of `compute_orbits` take."""
    queue, task = reduced_queue(points, PHYSICS), _search(options)
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
    work_through(fresh, _search(options)._replace(mode=passes.MEASURE), PHYSICS)
    records = np.empty((len(points), RECORD))
    conversion.write_records(points, half_periods(fresh), fresh.measured, records, False)
    return _amplitudes(records), fresh.states


def first_period(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
    """States (x, v, phi) in SI units after a period from the start, (n, 3), and its amplitudes."""
    queue = reduced_queue(points, PHYSICS)
    half_periods(queue)[:] = 2
    amplitudes, states = measured(queue, points, options)
    conversion.restore_states(points, states, False)
    ends = states[:, :WIDTH].copy()
    ends[:, 2] = np.exp(ends[:, 2])
    return ends, amplitudes


def _amplitudes(records: np.ndarray) -> np.ndarray:
    """Amplitudes of stress and force (n, 2) of records of whole orbits (n, RECORD)."""
    return 0.5 * (records[:, [STRESS_MAX, FORCE_MAX]] - records[:, [STRESS_MIN, FORCE_MIN]])


def _search(options: Options) -> passes.Pass:
    settings = options.settings()
    return passes.Pass(
        passes.SETTLE,
        settings.rtol,
        settings.stationary_rtol,
        2 * settings.max_periods,
        settings.max_steps,
        settings.accelerate,
    )


# --- other kernels --------------------------------------------------------------------------------


@contextmanager
def general_kernels() -> Iterator[None]:
    """Let the kernel for any rheological index do all points."""

    def one_family(physics: Physics, indices: np.ndarray) -> Iterator[tuple[Family, np.ndarray]]:
        yield Family(physics, None), np.arange(len(indices))

    with patch.object(queues, "families", one_family):
        yield


@contextmanager
def replaced_kernel(kernel: Any) -> Iterator[None]:
    """Let this kernel do all points."""
    with patch.object(queues, "pass_kernel", lambda _family: kernel):
        yield


def kernel_without_noise(gamma: float) -> Any:
    """A compiled kernel for a rheological index, without the closure of the noise."""
    fixed = dict(LITERALS) | {"rheological_index": gamma, "noise_intensity": 0.0}
    fixed["film_thickness"] = 1.0
    values = make_tuple_maker(ParameterValues, "q", {n: f"q.{n}" for n in KEPT} | fixed, {})
    reduced = make_lane_reader(Reduced, SLOTS.parameters, get)

    @inline
    def problem(lanes: np.ndarray, lane: int) -> Any:
        return problem_of(values(reduced(lanes, lane)), get(lanes, SLOTS.rtol, lane))

    kernel = jit(passes.make_pass(problem, PHYSICS))
    nobody = reduced_queue(np.empty((0, len(Parameters._fields))), PHYSICS)
    kernel(nobody, passes.new_lanes(WIDTH), _search(Options()), 0)
    return kernel


def generic_drive(rhs: Any, jacobian: Any, sizes: tuple[float, ...]) -> Any:
    """The adaptive drive of y' = rhs(p, t, y); errors count against |y|, or these sizes if more.

    As of `numerics.adaptive.make_adaptive`, compiled.
    """
    width = len(sizes)
    least = make_map(
        "least", "y", (f"1.0 / (abs(y[{i}]) + {sizes[i]!r})" for i in range(width)), {}
    )

    @inline
    def weight(p: Any, y: Any, J: Any) -> Any:
        return least(y)

    @inline
    def ignore(p: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any) -> None:
        pass

    return make_adaptive(rhs, jacobian, weight, ignore, RODAS4P2, algebra(width))


@inline
def plain_after_success(error: float, remembered: float) -> tuple[float, float]:
    """The plain controller, error^(-1/4), in place of the PI controller."""
    return step_control.after_rejection(larger(error, 1e-10)), remembered


# --- Euler-Cromer ---------------------------------------------------------------------------------


def scalar_steps(row: np.ndarray, options: Options, steps: int) -> None:
    """So many fixed steps by the scalar drive, from the start."""
    limited = Options(**(vars(options) | {"max_steps": steps}))
    scalar_end(row, limited, 1)


def fixed_lanes(points: np.ndarray, dt: float, phi: float | None = None) -> March:
    """Points at their start, or at another order parameter, ready for `start` and `march`."""
    steps, states = np.empty(len(points), np.int64), np.empty((len(points), WIDTH))
    write_steps(points, dt, steps)
    write_starts(points, states)
    if phi is not None:
        states[:, 2] = phi
    return March(points, steps, states, PHYSICS)


def march_assembly(gamma: float, noisy: bool, measured: bool, lanes: March) -> str:
    """The machine code of the kernel for a rheological index, compiled anew."""
    ((family, _),) = families(PHYSICS, np.array([[gamma, 0.0]]))
    fresh = jit(march_kernel(family, noisy, measured).py_func).alone
    fresh(lanes.tasks, np.arange(1), 1)
    return str(fresh.inspect_asm(fresh.signatures[0]))


def fixed_amplitudes(lanes: March) -> np.ndarray:
    """Amplitudes of stress [Pa] and force [N] over what was marched with a record, (n, 2)."""
    return _amplitudes(lanes.records())


def reference_period(points: np.ndarray, finals: np.ndarray, rtol: float) -> np.ndarray:
    """Records (n, RECORD) in SI units of a period by the adaptive method from stroboscopic states.

    `finals` (n, columns) as `points.final_columns`.
    """
    queue, records = reduced_queue(points, PHYSICS), np.empty((len(points), RECORD))
    queue.states[:] = finals
    conversion.scale_states(points, queue.states, False)
    half_periods(queue)[:] = 2
    work_through(queue, passes.Pass(passes.MEASURE, rtol, rtol, 0, 10**9, False), PHYSICS)
    conversion.write_records(points, half_periods(queue), queue.measured, records, False)
    return records


def fixed_period(
    row: np.ndarray, final: np.ndarray, dt: float, exact: np.ndarray, near: np.ndarray
) -> tuple[np.ndarray, float]:
    """The result row of a period by Euler-Cromer from a stroboscopic state, and its true error.

    The stated error is the difference from the record `near` (RECORD,), the true one that from
    `exact`. A step above the limit is not refused.
    """
    points, steps, start = row[None], np.empty(1, np.int64), final[None, :WIDTH].copy()
    start[:, 2] = np.exp(start[:, 2])
    write_steps(points, dt, steps)
    march = March(points, steps, start, PHYSICS)
    march.start(np.arange(1))
    march.march(measured=True)
    records, ends = march.records(), march.states()
    orbits = judging.Orbits(
        cycles=np.ones(1, np.int64), periods=np.ones(1, np.int64),
        statuses=march.tasks.status, begins=start, ends=ends, records=records,
        spreads=np.zeros((1, 2)),
    )  # fmt: skip
    known = Known(near[None], np.zeros(1, np.bool_), np.zeros(1))
    results = np.empty((1, len(RESULT_COLUMNS)))
    judging.write_results(points, orbits, known, results)
    error = 0.5 * relative_difference(parameters_of(row), records[0], exact)
    return results[0], float(error)
