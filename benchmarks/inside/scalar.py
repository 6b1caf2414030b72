"""One trajectory by the scalar drives, and the adaptive one for other equations."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from inside import PHYSICS, WIDTH, amplitudes_of
from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.fields import make_map
from stickslip.kernels.parameter_rows import FIRST_STEP, parameters_of
from stickslip.kernels.problem import problem_functions, problem_of
from stickslip.kernels.trajectories import start_kernel, write_trajectory
from stickslip.measure.accumulate import (
    FORCE_MAX,
    RECORD,
    STRESS_MAX,
    accumulator,
)
from stickslip.model import drive
from stickslip.model.models import model_of
from stickslip.model.rhs import relative_state
from stickslip.numerics.adaptive import make_adaptive
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import DEFAULTS, Options

State = tuple[float, float, float]

_LOOKS = 32  # at a step: enough that between two of them nothing is 1e-8 higher
_record = accumulator(1, 0)
_interpolate = algebra(WIDTH).interpolate
_observables = model_of(PHYSICS).equations.observables


def starting_state(row: np.ndarray) -> State:
    """Return the state (x, v, ln phi) at the start of a row of parameters (20,)."""
    state = np.empty(WIDTH)
    start_kernel(DEFAULTS.physics)(row, state)
    return float(state[0]), float(state[1]), float(state[2])


def scalar_end(row: np.ndarray, options: Options, periods: int) -> tuple[float, int]:
    """Return the displacement x [m] after some periods by a scalar integrator, and the status."""
    samples, start = np.empty((periods + 1, WIDTH)), np.array(starting_state(row))
    status = write_trajectory(row, options, start, 1, samples)
    return float(samples[-1, 0]), int(status)


def scalar_states(row: np.ndarray, state: np.ndarray, periods: int, rtol: float) -> np.ndarray:
    """Return the states (x, v, ln phi) after each period by the scalar integrator, (periods, 3)."""
    samples = np.empty((periods + 1, WIDTH))
    assert write_trajectory(row, Options(rtol=rtol, max_steps=10**9), state, 1, samples) == 0
    samples[:, 2] = np.log(samples[:, 2])
    return samples[1:]


@inline
def _ignore(p: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any) -> None:
    pass


@inline
def _look(
    problem: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any
) -> None:
    for i in range(1, _LOOKS + 1):
        y = _interpolate(i / _LOOKS, y0, y1, d1, d2)
        sigma, force = _observables(problem.p, y, math.exp(y[2]), problem.u_s)
        _record.see_extremum(record, 0, STRESS_MAX, sigma, True)
        _record.see_extremum(record, 0, FORCE_MAX, force, True)


@cache
def _observed_period() -> Any:
    """Return a function of (row, rtol, state, record): a period of this integrator, with looks."""
    functions = problem_functions(PHYSICS)
    drive_on = make_adaptive(
        functions.rhs, functions.jacobian, functions.error_weight, _look, RODAS4P2, algebra(WIDTH),
        limits=functions.step_limits,
    )  # fmt: skip

    @jit
    def period(row: Any, rtol: float, state: Any, record: Any) -> int:
        p = parameters_of(row)
        problem, h, end = problem_of(p, rtol), FIRST_STEP * drive.period(p), drive.period(p)
        y = relative_state(p, 0.0, (state[0], state[1], state[2]))
        return drive_on(problem, rtol, 0.0, end, y, h, 10**8, record)[3]

    return period


def scalar_amplitudes(row: np.ndarray, state: np.ndarray, rtol: float) -> tuple[float, float]:
    """Return amplitudes of stress [Pa] and force [N] over a period."""
    record = np.empty(RECORD)
    _record.clear(record, 0)
    assert _observed_period()(row, rtol, state, record) == 0
    stress, force = amplitudes_of(record[None])[0]
    return float(stress), float(force)


def generic_drive(rhs: Any, jacobian: Any, sizes: tuple[float, ...]) -> Any:
    """Return the adaptive integrator of y' = rhs(p, t, y), with errors against |y| or these sizes.

    As of `numerics.adaptive.make_adaptive`, compiled.
    """
    width = len(sizes)
    least = make_map(
        "least", "y", (f"1.0 / (abs(y[{i}]) + {sizes[i]!r})" for i in range(width)), {}
    )

    @inline
    def weight(p: Any, y: Any, y1: Any, J: Any) -> Any:
        return least(y)

    return make_adaptive(rhs, jacobian, weight, _ignore, RODAS4P2, algebra(width))
