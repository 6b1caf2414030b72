"""What benchmarks use of the inside of the package: all of it stands here.

A benchmark that counts, times or replaces something below `stickslip.orbit` does so by this file
alone, so that a change of the kernels touches no other benchmark.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from stickslip import kernels
from stickslip.compiled.decorators import inline, jit
from stickslip.ensemble import end_states
from stickslip.kernels import problem
from stickslip.kernels.adaptive import driver, passes
from stickslip.kernels.adaptive.results import restore_states
from stickslip.kernels.euler_cromer.layout import write_starts, write_steps
from stickslip.kernels.euler_cromer.march import SPECIAL_MARCHES, FixedLanes, general_march
from stickslip.kernels.observers import no_record
from stickslip.kernels.problem import fixed_period
from stickslip.kernels.rows import FIRST_STEP, parameters_of
from stickslip.measure import accumulate
from stickslip.model.scaling import with_gamma
from stickslip.numerics import step_control
from stickslip.options import Options
from stickslip.parameters import Parameters, ParameterValues

__all__ = ["FixedLanes", "end_states"]  # passed on, beside what is made here

State = tuple[float, float, float]

# --- one trajectory, scalar -----------------------------------------------------------------------


def starting_state(row: np.ndarray) -> State:
    """The state (x, v, ln phi) at the start of a row of parameters (20,)."""
    state = np.empty(3)
    kernels.starting_log_state(row, state)
    return float(state[0]), float(state[1]), float(state[2])


def scalar_end(row: np.ndarray, options: Options, periods: int) -> tuple[float, int]:
    """The displacement x [m] after some periods by the scalar drive of a method, and the status."""
    samples, start = np.empty((periods + 1, 3)), np.array(starting_state(row))
    fixed = options.method == "euler-cromer"
    trajectory = kernels.fixed_trajectory if fixed else kernels.adaptive_trajectory
    status = trajectory(row, options.settings(), start, 1, samples)
    return float(samples[-1, 0]), int(status)


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
    queue = driver._queue(points)
    driver._work_through(queue, _search(options))
    return queue


def attempts_of(points: np.ndarray, options: Options) -> Attempts:
    """What the three passes of `compute_orbits` take."""
    queue, task = driver._queue(points), _search(options)
    measure = task._replace(mode=passes.MEASURE)
    finer = measure._replace(rtol=passes.REFINEMENT * options.rtol)
    counted = []
    for each in (task, measure, finer):
        before, begins = attempted(queue), queue.states.copy()
        driver._work_through(queue, each)
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
    driver._work_through(fresh, _search(options)._replace(mode=passes.MEASURE))
    high, low = fresh.measured[:, 0:4:2], fresh.measured[:, 1:4:2]
    symmetric = half_periods(fresh) % 2 == 1
    amplitudes = np.where(symmetric[:, None], np.maximum(high, low), 0.5 * (high + low))
    return amplitudes * _units(points), fresh.states


def first_period(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
    """States (x, v, phi) in SI units after a period from the start, (n, 3), and its amplitudes."""
    queue = driver._queue(points)
    half_periods(queue)[:] = 2
    amplitudes, states = measured(queue, points, options)
    restore_states(points, states)
    ends = states[:, :3].copy()
    ends[:, 2] = np.exp(ends[:, 2])
    return ends, amplitudes


def _units(points: np.ndarray) -> np.ndarray:
    """Stress and force that are 1 in nondimensional form, (n, 2)."""
    p = {name: points[:, i] for i, name in enumerate(Parameters._fields)}
    force = p["block_mass"] * np.abs(p["drive_amplitude"]) * p["angular_frequency"] ** 2
    return np.column_stack([p["angular_frequency"] / p["kinetic_coefficient"], force])


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
def special_kernels(table: Mapping[float, Any]) -> Iterator[None]:
    """Let these kernels do the points of their rheological indices, the general one all others."""
    with patch.object(passes, "SPECIAL_PASSES", table):
        yield


def kernel_without_noise(gamma: float) -> Any:
    """A compiled kernel for a rheological index, without the closure of the noise."""
    with patch.object(passes, "with_gamma", _without_noise):
        kernel = passes._make_pass(gamma)
        nobody = driver._queue(np.empty((0, len(Parameters._fields))))
        kernel(nobody, passes.new_lanes(), _search(Options()), 0)
    return kernel


@inline
def _without_noise(q: passes.Reduced, gamma: float) -> ParameterValues:
    """As `with_gamma`, with a literal D = 0."""
    p = with_gamma(q, gamma)
    return ParameterValues(
        p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9],
        p[10], p[11], p[12], p[13], p[14], p[15], p[16], p[17], p[18], 0.0,
    )  # fmt: skip


# --- variants of the adaptive method --------------------------------------------------------------

ROUNDING = problem._ROUNDING
"""The speed below which a cusp is rounded, in tolerances of X_m omega."""

FIRST_STEP_OF_PERIOD = FIRST_STEP
"""The first step, in drive periods."""


@inline
def plain_after_success(error: float, remembered: float) -> tuple[float, float]:
    """The plain controller, error^(-1/4), in place of the PI controller."""
    inverse = step_control.inverse_fourth_root(step_control.larger(error, step_control._SMALLEST))
    return step_control._limited(step_control._SAFETY * inverse), remembered


# --- Euler-Cromer ---------------------------------------------------------------------------------


@jit
def _scalar_steps(point, settings, y, steps):
    p = parameters_of(point)
    return fixed_period(p, settings, y, 0.0, steps, no_record())


def scalar_steps(row: np.ndarray, options: Options, start: State, steps: int) -> None:
    """So many fixed steps by the scalar kernel."""
    _scalar_steps(row, options.settings(), start, steps)


def fixed_lanes(points: np.ndarray, dt: float, phi: float | None = None) -> FixedLanes:
    """Points at their start, or at another order parameter, ready for `start` and `march`."""
    steps, states = np.empty(len(points), np.int64), np.empty((len(points), 3))
    write_steps(points, dt, steps)
    write_starts(points, states)
    if phi is not None:
        states[:, 2] = phi
    return FixedLanes(points, steps, states)


def march_assembly(gamma: float, lanes: FixedLanes) -> str:
    """The machine code of the kernel for a rheological index, compiled anew."""
    fresh = jit(SPECIAL_MARCHES.get(gamma, general_march).py_func)
    fresh(lanes.tasks, np.arange(1), True, True, 1)
    return str(fresh.inspect_asm(fresh.signatures[0]))


def fixed_amplitudes(lanes: FixedLanes) -> np.ndarray:
    """Amplitudes of stress [Pa] and force [N] over what was marched with a record, (n, 2)."""
    records = lanes.records()
    high = records[:, [accumulate.STRESS_MAX, accumulate.FORCE_MAX]]
    return 0.5 * (high + records[:, [accumulate.STRESS_MINUS_MIN, accumulate.FORCE_MINUS_MIN]])
