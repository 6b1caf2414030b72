"""Sampled trajectories, one at a time, and what follows from their states."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.compiled.fields import make_map
from stickslip.kernels.points import FIRST_STEP, parameters_of
from stickslip.kernels.problem import Problem, ProblemFunctions, problem_functions, problem_of
from stickslip.kernels.streams import (
    KEY_HIGH,
    KEY_LOW,
    PATH,
    PERIOD,
    SIGNS,
    STREAM,
    first_sign,
    normal_number,
    signs,
)
from stickslip.model import block, drive, film, noise
from stickslip.model.models import model_of
from stickslip.model.rhs import (
    film_melting_function,
    relative_velocity,
)
from stickslip.model.state import FILM, STATE, State
from stickslip.numerics.adaptive import OK, make_adaptive
from stickslip.numerics.euler_cromer import make_euler_cromer
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import Physics, Settings
from stickslip.parameters import Parameters

OBSERVABLES = (
    "upper_displacement",
    "upper_velocity",
    "elastic_strain",
    "elastic_stress",
    "viscous_stress",
    "friction_force",
)
"""What `observables_kernel` computes; the names are those of `variables.TRAJECTORY`."""


# Behind a stream: the steps drawn in this drive period, and the signs that are left.
_DRAWN, _BITS = STREAM, STREAM + 1


class Samples(NamedTuple):
    """Rows (n, width) for the states at the phase times j dt, and the number of the next one.

    `stream` holds the random numbers of a path, where the noise is left to chance: STREAM numbers,
    the steps that were drawn in this drive period, and the signs that are left.
    """

    rows: np.ndarray
    cursor: np.ndarray
    dt: float
    stream: np.ndarray


def _make_sample_step(width: int) -> Any:
    """What writes the states at the sample times within a step."""
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


def _make_trajectory(width: int, period_map: Any, own_state: Any, motion: Any) -> Any:
    """The sampling of one trajectory of states of so many components with one method.

    `period_map(p, settings, y, h, budget, samples)` gives (y, h, steps, status) after a drive
    period; `own_state(p, y)` turns (x, v, ln phi, ...) at phase 0 into the method's own state,
    `motion(p, t, y)` that into (x, v, phi, ...) at phase time t.
    """
    row_state = make_map(f"row_state[{width}]", "row", (f"row[{i}]" for i in range(width)), {})

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
            taken = Samples(rows, np.zeros(1, np.int64), dt, stream)
            y, h, used, status = period_map(p, settings, y, h, settings.max_steps - steps, taken)
            steps += used
            stream[PERIOD] += 1.0
            stream[_DRAWN] = 0.0
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


@inline
def _with_phi(p: Parameters, y: State) -> State:
    return y[0], y[1], math.exp(y[2])


@inline
def _as_it_is(p: Parameters, t: float, y: State) -> State:
    return y


def new_stream(numbers: np.ndarray | None = None) -> np.ndarray:
    """What a trajectory draws its random numbers from: a stream (STREAM,) at its first number."""
    stream = np.zeros(_BITS + 1)
    stream[:STREAM] = 0.0 if numbers is None else numbers
    return stream


@inline
def _draw_sign(s: Samples) -> float:
    stream = s.stream
    drawn = int(stream[_DRAWN])
    if drawn % SIGNS == 0:
        low, high, path, period = stream[KEY_LOW], stream[KEY_HIGH], stream[PATH], stream[PERIOD]
        stream[_BITS] = signs(low, high, path, period, float(drawn // SIGNS))
    sign, stream[_BITS] = first_sign(stream[_BITS])
    stream[_DRAWN] += 1.0
    return sign


def _make_disturb(functions: ProblemFunctions) -> Any:
    """What adds the noise by chance to the end of a step of the adaptive drive."""
    from stickslip.kernels.adaptive.chance import kicked  # of no use to others
    from stickslip.model.chance import make_deviation

    rhs, width = functions.rhs, functions.width
    deviation_of = make_deviation(algebra(width).interpolate)
    values = (f"psi if {i} == {FILM} else y[{i}]" for i in range(width))
    with_psi = make_map(f"with_psi[{width}]", "y, psi", values, {})

    @inline
    def disturb(
        problem: Problem,
        t: float,
        h: float,
        y0: State,
        y1: State,
        f1: State,
        d1: State,
        d2: State,
        s: Samples,
    ) -> tuple[State, State, float]:
        stream, p = s.stream, problem.p
        low, high, path, period = stream[KEY_LOW], stream[KEY_HIGH], stream[PATH], stream[PERIOD]
        xi = normal_number(low, high, path, period, stream[_DRAWN])
        stream[_DRAWN] += 1.0
        deviation = deviation_of(p, h, y0, y1, d1, d2)
        psi, longest = kicked(p, y1[FILM], deviation, h, xi)
        y = with_psi(y1, psi)
        return y, rhs(problem, t + h, y), longest

    return disturb


@kernel_factory
def adaptive_trajectory(physics: Physics) -> Any:
    """The kernel of a trajectory by the adaptive method.

    It maps (point, settings, start, per_period, stream, samples) to the Status as an integer:
    `point` (parameters,); `start` (width,) the state (x, v, ln phi, ...) at phase 0; `stream` as of
    `new_stream`, which is moved on; `samples` (periods*per_period + 1, width) receives (x, v, phi,
    ...) at equal times.
    """
    functions = problem_functions(physics)
    width, relative_state = functions.width, functions.equations.relative_state
    sample_step, chance = _make_sample_step(width), physics.chance
    numbered = (f"exp(y[{i}])" if i == FILM else f"y[{i}]" for i in range(width))
    with_phi = make_map(f"with_phi[{width}]", "y", numbered, {"exp": math.exp})

    @inline
    def relative(p: Parameters, y: State) -> State:
        return relative_state(p, 0.0, y)

    @inline
    def motion(p: Parameters, t: float, y: State) -> State:
        return with_phi(relative_state(p, t, y))

    @inline
    def observe(
        problem: Problem, t: float, h: float, y0: State, y1: State, d1: State, d2: State, s: Samples
    ) -> None:
        if not chance:
            sample_step(t, h, y0, y1, d1, d2, s)

    rhs, jacobian, weight = functions.rhs, functions.jacobian, functions.error_weight
    more = (_make_disturb(functions),) if physics.chance else ()
    travel = make_adaptive(rhs, jacobian, weight, observe, RODAS4P2, algebra(width), *more)

    @jit
    def period(
        p: Parameters, settings: Settings, y: State, h: float, budget: int, s: Samples
    ) -> Any:
        problem = problem_of(p, settings.rtol)
        return travel(problem, settings.rtol, 0.0, drive.period(p), y, h, budget, s)

    @jit
    def period_by_chance(
        p: Parameters, settings: Settings, y: State, h: float, budget: int, s: Samples
    ) -> Any:
        problem, steps, status = problem_of(p, settings.rtol), 0, OK
        for i in range(s.rows.shape[0]):
            # Between the ends of steps nothing is known of the noise: one ends at every sample.
            for component in range(s.rows.shape[1]):
                s.rows[i, component] = y[component]
            end = (i + 1) * s.dt if i + 1 < s.rows.shape[0] else drive.period(p)
            left = budget - steps
            y, h, used, status = travel(problem, settings.rtol, i * s.dt, end, y, h, left, s)
            steps += used
            if status != OK:
                break
        return y, h, steps, status

    own_period = period_by_chance if physics.chance else period
    trajectory = _make_trajectory(width, own_period, relative, motion)
    return named_kernel(f"adaptive_trajectory[{physics}]", trajectory)


@kernel_factory
def euler_cromer_trajectory(physics: Physics) -> Any:
    """The kernel of a trajectory by Euler-Cromer; as `adaptive_trajectory`.

    The drive period is divided evenly, so a step may be a little below dt.
    """
    stress_and_force = model_of(physics).equations.exact
    sample_step = _make_sample_step(len(STATE))

    chance = physics.chance

    @inline
    def increments(p: Parameters, t: float, dt: float, y: State, xi: float) -> tuple[float, float]:
        x, v, phi = y
        u = relative_velocity(p, t, v)
        _, F = stress_and_force(p, u, phi)
        rate = film.order_parameter_rate(p, phi, film_melting_function(p, u))
        kick = noise.random_kick(p, dt, xi) if chance else noise.typical_kick(p, phi, dt)
        return dt * block.acceleration(p, x, v, F), dt * rate + kick

    @inline
    def observe(p: Parameters, t: float, h: float, y0: State, y1: State, s: Samples) -> None:
        zero = (0.0, 0.0, 0.0)
        sample_step(t, h, y0, y1, zero, zero, s)

    march = make_euler_cromer(increments, observe, *((_draw_sign,) if chance else ()))

    @jit
    def period(
        p: Parameters, settings: Settings, y: State, h: float, budget: int, s: Samples
    ) -> Any:
        steps = math.ceil(drive.period(p) / settings.dt)
        y, used, status = march(p, 0.0, drive.period(p), steps, y, budget, s)
        return y, h, used, status

    trajectory = _make_trajectory(len(STATE), period, _with_phi, _as_it_is)
    return named_kernel(f"euler_cromer_trajectory[{physics}]", trajectory)


@kernel_factory
def observables_kernel(physics: Physics) -> Any:
    """The kernel of what follows from the states (x, v, phi, ...) of a trajectory.

    It takes `point` (parameters,), `times` (n,), `samples` (n, width), the speed `u_s` [m/s] below
    which the method rounded a cusp of the law, and writes `observables` (n, 6), in the order of
    OBSERVABLES.
    """
    model = model_of(physics)
    bound, width = model.equations, model.width
    observables_at, rounded, strain = bound.observables, bound.law.rounded, bound.strain
    values = ["row[0]", "u", *(f"row[{i}]" for i in range(2, width))]
    own_state = make_map(f"own_state[{width}]", "row, u", values, {})

    def observables_of(
        point: np.ndarray,
        times: np.ndarray,
        samples: np.ndarray,
        u_s: float,
        observables: np.ndarray,
    ) -> None:
        p = parameters_of(point)
        for i in range(times.shape[0]):
            t, row = times[i], observables[i]
            u = relative_velocity(p, t, samples[i, 1])
            y = own_state(samples[i], u)  # with phi in place of its logarithm, which nobody needs
            row[0], row[1] = drive.upper_displacement(p, t), drive.upper_velocity(p, t)
            row[2] = strain(p, y)
            row[3], row[5] = observables_at(p, y, samples[i, 2], u_s)
            row[4] = rounded(p, u, samples[i, 2], u_s)[0]

    return named_kernel(f"observables[{physics}]", observables_of)


@kernel_factory
def start_kernel(physics: Physics) -> Any:
    """The kernel that writes the start (x, v, ln phi, ...) of a point into a state.

    It takes `point` (parameters,) and `state` (width,).
    """
    start = model_of(physics).start

    def write_start(point: np.ndarray, state: np.ndarray) -> None:
        y = start(parameters_of(point))
        for component in range(state.shape[0]):
            state[component] = y[component]

    return named_kernel(f"write_start[{physics}]", write_start)
