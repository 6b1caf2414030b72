"""Trajectories of the adaptive method, one at a time, by the scalar integrator."""

from __future__ import annotations

import math
from typing import Any

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.compiled.fields import make_map
from stickslip.kernels.problem import (
    Problem,
    ProblemFunctions,
    make_travel,
    problem_functions,
    problem_of,
)
from stickslip.kernels.streams import KEY_HIGH, KEY_LOW, PATH, PERIOD, normal_number
from stickslip.kernels.trajectories import DRAWN, Samples, make_sample_step, make_trajectory
from stickslip.model import drive
from stickslip.model.state import FILM, State
from stickslip.numerics.adaptive import OK
from stickslip.numerics.linear import algebra
from stickslip.options import Physics, Settings
from stickslip.parameters import Parameters


@kernel_factory
def adaptive_trajectory(physics: Physics) -> Any:
    """Return the kernel of a trajectory by the adaptive method.

    It maps (point, settings, start, per_period, stream, samples) to the Status as an integer.
    `point` is (parameters,), and `start` (width,) the state (x, v, ln phi, ...) at phase 0. The
    kernel advances `stream`, from `new_stream`, and writes (x, v, phi, ...) at equal intervals into
    `samples` (periods*per_period + 1, width).
    """
    functions = problem_functions(physics)
    width, relative_state = functions.width, functions.equations.relative_state
    numbered = (f"exp(y[{i}])" if i == FILM else f"y[{i}]" for i in range(width))
    with_phi = make_map(f"with_phi[{width}]", "y", numbered, {"exp": math.exp})
    make_period = _make_stochastic_period if physics.chance else _make_period

    @inline
    def relative(p: Parameters, y: State) -> State:
        return relative_state(p, 0.0, y)

    @inline
    def motion(p: Parameters, t: float, y: State) -> State:
        return with_phi(relative_state(p, t, y))

    trajectory = make_trajectory(width, make_period(functions), relative, motion)
    return named_kernel(f"adaptive_trajectory[{physics}]", trajectory, makes_arrays=True)


def _make_period(functions: ProblemFunctions) -> Any:
    """Return the map of a drive period, with samples, for `make_trajectory`."""
    sample_step = make_sample_step(functions.width)

    @inline
    def observe(
        problem: Problem, t: float, h: float, y0: State, y1: State, d1: State, d2: State, s: Samples
    ) -> None:
        sample_step(t, h, y0, y1, d1, d2, s)

    travel = make_travel(functions, observe)

    @jit
    def period(
        p: Parameters, settings: Settings, y: State, h: float, budget: int, s: Samples
    ) -> Any:
        problem = problem_of(p, settings.rtol)
        return travel(problem, settings.rtol, 0.0, drive.period(p), y, h, budget, s)

    return period


def _make_stochastic_period(functions: ProblemFunctions) -> Any:
    """Return this map with stochastic noise, whose steps end at the samples."""

    @inline
    def ignore(
        problem: Problem, t: float, h: float, y0: State, y1: State, d1: State, d2: State, s: Samples
    ) -> None:
        pass

    travel = make_travel(functions, ignore, disturb=_make_disturb(functions))

    @jit
    def period(
        p: Parameters, settings: Settings, y: State, h: float, budget: int, s: Samples
    ) -> Any:
        problem, steps, status = problem_of(p, settings.rtol), 0, OK
        for i in range(s.rows.shape[0]):
            # The noise is known only at the ends of steps, so a step must end at every sample.
            for component in range(s.rows.shape[1]):
                s.rows[i, component] = y[component]
            end = (i + 1) * s.dt if i + 1 < s.rows.shape[0] else drive.period(p)
            left = budget - steps
            y, h, used, status = travel(problem, settings.rtol, i * s.dt, end, y, h, left, s)
            steps += used
            if status != OK:
                break
        return y, h, steps, status

    return period


def _make_disturb(functions: ProblemFunctions) -> Any:
    """Return the function that adds random noise at the end of a step of the integrator."""
    from stickslip.kernels.adaptive.kicks import after_kick  # only stochastic films need it
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
        # Only accepted steps draw a number. The count is a float, as a stream is a row of floats.
        low, high, path, period = stream[KEY_LOW], stream[KEY_HIGH], stream[PATH], stream[PERIOD]
        xi = normal_number(low, high, path, period, stream[DRAWN])
        stream[DRAWN] += 1.0
        deviation = deviation_of(p, h, y0, y1, d1, d2)
        psi, longest = after_kick(p, y1[FILM], deviation, h, xi)
        y = with_psi(y1, psi)
        return y, rhs(problem, t + h, y), longest

    return disturb
