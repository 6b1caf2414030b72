"""Sampled trajectories, one at a time, and their observables, for all methods."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.compiled.fields import make_tuple_reader
from stickslip.kernels.families import physics_at
from stickslip.kernels.parameter_rows import FIRST_STEP, parameters_of
from stickslip.kernels.problem import rounding_speed
from stickslip.kernels.streams import PERIOD, STREAM
from stickslip.model import drive
from stickslip.model.models import model_of
from stickslip.model.state import FILM, State
from stickslip.numerics.adaptive import OK
from stickslip.numerics.linear import algebra
from stickslip.options import METHODS, Options, Physics, Settings
from stickslip.parameters import Parameters

OBSERVABLES = (
    "upper_displacement",
    "upper_velocity",
    "elastic_strain",
    "elastic_stress",
    "viscous_stress",
    "friction_force",
)
"""The observables of `observables_kernel`, named as in `variables.TRAJECTORY`."""


DRAWN, BITS = STREAM, STREAM + 1
"""Two slots after a stream, for the steps drawn in this drive period and for the unused signs."""


class Samples(NamedTuple):
    """Rows (n, width) for the states at the phase times j dt, and the number of the next one.

    The `stream` of a stochastic path has STREAM numbers, and slots for DRAWN and BITS.
    """

    rows: np.ndarray
    cursor: np.ndarray
    dt: float
    stream: np.ndarray


def make_sample_step(width: int) -> Any:
    """Return the function that writes the states at the sample times in a step."""
    interpolate = algebra(width).interpolate

    @jit
    def sample_step(t: float, h: float, y0: State, y1: State, d1: Any, d2: Any, s: Samples) -> None:
        rows, cursor = s.rows, s.cursor
        while cursor[0] < rows.shape[0] and cursor[0] * s.dt < t + h:
            y = interpolate((cursor[0] * s.dt - t) / h, y0, y1, d1, d2)
            for component in range(rows.shape[1]):
                rows[cursor[0], component] = y[component]
            cursor[0] += 1

    return sample_step


def make_trajectory(width: int, period_map: Any, own_state: Any, motion: Any) -> Any:
    """Return the function that samples a trajectory with one method, for states of this width.

    `period_map(p, settings, y, h, budget, samples)` returns (y, h, steps, status) after a drive
    period. `own_state(p, y)` turns (x, v, ln phi, ...) at phase 0 into the state of the method, and
    `motion(p, t, y)` turns this state at phase time t into (x, v, phi, ...).
    """
    row_state = make_tuple_reader(width)

    def trajectory(
        point: np.ndarray,
        settings: Settings,
        start: np.ndarray,
        per_period: int,
        stream: np.ndarray,
        samples: np.ndarray,
    ) -> int:
        p, last = parameters_of(point), samples.shape[0] - 1
        y, h, steps, status = own_state(p, row_state(start)), FIRST_STEP * drive.period(p), 0, OK
        dt = drive.period(p) / per_period
        for first in range(0, last, per_period):
            rows = samples[first : first + per_period]
            part = Samples(rows, np.zeros(1, np.int64), dt, stream)
            y, h, used, status = period_map(p, settings, y, h, settings.max_steps - steps, part)
            steps += used
            stream[PERIOD] += 1.0
            stream[DRAWN] = 0.0
            if status != OK:
                return status
        for component in range(samples.shape[1]):
            samples[last, component] = y[component]
        for i in range(samples.shape[0]):
            sample = motion(p, (i % per_period) * dt, row_state(samples[i]))
            for component in range(samples.shape[1]):
                samples[i, component] = sample[component]
        return status

    return trajectory


def write_trajectory(
    point: np.ndarray,
    options: Options,
    start: np.ndarray,
    per_period: int,
    samples: np.ndarray,
    stream: np.ndarray | None = None,
) -> int:
    """Compute a sampled trajectory and return the Status as an integer.

    The arguments are those of the kernels in `adaptive/adaptive_trajectory.py`; stochastic noise
    needs a `stream`.
    """
    physics = physics_at(point, options.physics)
    kernel = METHODS[options.method].kernels.trajectory_kernel(physics)
    numbers = new_stream() if stream is None else stream
    return int(kernel(point, options.settings(), start, per_period, numbers, samples))


def new_stream(numbers: np.ndarray | None = None) -> np.ndarray:
    """Return the stream of a trajectory, with `numbers` (STREAM,), at its first random number."""
    stream = np.zeros(BITS + 1)
    stream[:STREAM] = 0.0 if numbers is None else numbers
    return stream


def make_write_observables(physics: Physics) -> Any:
    """Return the inline function (p, t, y, phi, u_s, row) that writes the observables of a state.

    `row` receives them in the order of OBSERVABLES. `u_s` [m/s] is the speed below which the method
    rounds a cusp of the law; ln(phi) in y is not used.
    """
    bound = model_of(physics).equations
    observables, rounded, strain = bound.observables, bound.law.rounded, bound.strain
    upper_displacement, upper_velocity = bound.upper.displacement, bound.upper.velocity

    @inline
    def write_observables(
        p: Parameters, t: float, y: State, phi: float, u_s: float, row: np.ndarray
    ) -> None:
        row[0], row[1] = upper_displacement(p, t), upper_velocity(p, t)
        row[2] = strain(p, y)
        row[3], row[5] = observables(p, y, phi, u_s)
        row[4] = rounded(p, y[1], phi, u_s)[0]

    return write_observables


@kernel_factory
def observables_kernel(physics: Physics) -> Any:
    """Return the kernel of the observables of a trajectory of states (x, v, phi, ...).

    It takes `point` (parameters,), `times` (n,), `samples` (n, width) and the tolerance at which a
    cusp of the law is rounded, and writes `observables` (n, 6).
    """
    model = model_of(physics)
    relative_state, sample_state = model.equations.relative_state, make_tuple_reader(model.width)
    write_observables = make_write_observables(physics)

    def observables_of(
        point: np.ndarray,
        times: np.ndarray,
        samples: np.ndarray,
        rtol: float,
        observables: np.ndarray,
    ) -> None:
        p = parameters_of(point)
        u_s = rounding_speed(p, rtol)
        for i in range(times.shape[0]):
            # This state has phi in place of its logarithm.
            y = relative_state(p, times[i], sample_state(samples[i]))
            write_observables(p, times[i], y, samples[i, FILM], u_s, observables[i])

    return named_kernel(f"observables[{physics}]", observables_of)


@kernel_factory
def start_kernel(physics: Physics) -> Any:
    """Return the kernel that writes the start (x, v, ln phi, ...) of a point into a state.

    It takes `point` (parameters,) and `state` (width,).
    """
    start = model_of(physics).start

    def write_start(point: np.ndarray, state: np.ndarray) -> None:
        y = start(parameters_of(point))
        for component in range(state.shape[0]):
            state[component] = y[component]

    return named_kernel(f"write_start[{physics}]", write_start)
