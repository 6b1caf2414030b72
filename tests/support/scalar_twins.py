"""Twins of the lanes: one trajectory at a time by the scalar drives.

They share the equations and the record with the lanes, but not the layout, the units, the half
periods, the order of operations, or the places in a step at which the motion is recorded.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from stickslip import Parameters, Status
from stickslip.compiled.decorators import inline, jit
from stickslip.kernels.parameter_rows import FIRST_STEP, parameters_of
from stickslip.kernels.plain_iteration.march import write_starts, write_steps
from stickslip.kernels.problem import make_travel, problem_functions, problem_of
from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    ELAPSED,
    FIRST_PHASE,
    FORCE_MAX,
    FORCE_SIZE,
    IN_PHASE,
    LAST_PHASE,
    LOSS,
    MELTED,
    MELTINGS,
    MOTION_IN_PHASE,
    MOTION_OUT_OF_PHASE,
    OUT_OF_PHASE,
    RECORD,
    SOLID,
    SQUARED_FORCE,
    STRESS_MAX,
    accumulator,
)
from stickslip.model import block, drive, film, noise, solids
from stickslip.model.models import model_of
from stickslip.model.rhs import film_melting_function, relative_state, relative_velocity
from stickslip.numerics.euler_cromer import make_euler_cromer
from stickslip.numerics.linear import algebra
from stickslip.options import DEFAULTS, HARMONICS

_record = accumulator(1, 0)
_clear = _record.clear
_see_extremum, _see_phase, _add = _record.see_extremum, _record.see_phase, _record.add
_observables = model_of(DEFAULTS.physics).equations.observables
_interpolate = algebra(3).interpolate

# Places in a step at which it is recorded, so many that a maximum is right to 1e-8.
_LOOKS = 32


@inline
def _see(p, t, dt, u, phi, u_s, record):
    """Record a state that represents the interval `dt`."""
    sigma, F = _observables(p, (0.0, u, 0.0), phi, u_s)
    solid = solids.solid_threshold(p)
    melted = solids.MELTED_PART * solid if solid > 0.0 else -1.0
    _see_extremum(record, 0, STRESS_MAX, sigma, True)
    _see_extremum(record, 0, FORCE_MAX, F, True)
    _see_phase(record, 0, phi, solid, melted, dt / (0.5 * drive.period(p)), True)
    V = drive.upper_velocity(p, t)
    _add(record, 0, BLOCK_WORK, dt * (F * (V - u)), True)
    _add(record, 0, LOSS, dt * (F * u), True)
    _add(record, 0, ABSOLUTE_WORK, dt * abs(F * V), True)


def cyclic_meltings(record: np.ndarray) -> int:
    """Return the meltings of a closed orbit of whole periods."""
    wrapped = record[FIRST_PHASE] == MELTED and record[LAST_PHASE] == SOLID
    return int(record[MELTINGS]) + int(wrapped)


# --- Euler-Cromer ---------------------------------------------------------------------------------


@inline
def _increments(p, t, dt, y, xi):
    x, v, phi = y
    u = relative_velocity(p, t, v)
    _, F = _observables(p, (0.0, u, 0.0), phi, 0.0)
    rate = film.order_parameter_rate(p, phi, film_melting_function(p, u))
    return dt * block.acceleration(p, x, v, F), dt * rate + noise.typical_kick(p, phi, dt)


@inline
def _see_begin(p, t, dt, y0, y1, record):
    u = relative_velocity(p, t, y0[1])
    _see(p, t, dt, u, y0[2], 0.0, record)
    F, phase = _observables(p, (0.0, u, 0.0), y0[2], 0.0)[1], p.angular_frequency * t
    part = dt / (0.5 * drive.period(p))
    _add(record, 0, ELAPSED, part, True)
    for slot in (IN_PHASE, MOTION_IN_PHASE):
        _add(record, 0, slot, part * F * math.cos(phase), True)
    for slot in (OUT_OF_PHASE, MOTION_OUT_OF_PHASE):
        _add(record, 0, slot, -part * F * math.sin(phase), True)
    _add(record, 0, SQUARED_FORCE, part * F * F, True)
    _add(record, 0, FORCE_SIZE, part * abs(F), True)


_march = make_euler_cromer(_increments, _see_begin)


@jit
def _marched(point, steps, y, before, cycle, record):
    p, status = parameters_of(point), 0
    for n in range(before + cycle):
        if n <= before:
            _clear(record, 0)
        y, _, status = _march(p, 0.0, drive.period(p), steps, y, steps, record)
        if status != 0:
            break
    return y, status


def euler_cromer_period(
    p: Parameters, dt: float, before: int = 0, cycle: int = 1
) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the state (x, v, phi) and the record after periods from the start, and the Status.

    The record, in SI units, is of the last `cycle` periods, which follow `before` others.
    """
    points, steps = np.array(p)[None], np.empty(1, np.int64)
    start, record = np.empty((1, 3)), np.empty(RECORD)
    write_steps(points, dt, steps)
    write_starts(points, start)
    y, status = _marched(points[0], steps[0], tuple(start[0].tolist()), before, cycle, record)
    return np.array(y), record, status


# --- adaptive -------------------------------------------------------------------------------------


@inline
def _see_inside(problem, t, h, y0, y1, d1, d2, record):
    for i in range(_LOOKS):
        theta = (i + 0.5) / _LOOKS
        _, u, psi = _interpolate(theta, y0, y1, d1, d2)
        _see(problem.p, t + theta * h, h / _LOOKS, u, math.exp(psi), problem.u_s, record)
    _see(problem.p, t + h, 0.0, y1[1], math.exp(y1[2]), problem.u_s, record)


@cache
def _adaptive() -> Any:
    functions = problem_functions(DEFAULTS.physics._replace(drive=HARMONICS))
    travel = make_travel(functions, _see_inside)

    @jit
    def periods(point, rtol, y, number, states, record):
        p = parameters_of(point)
        problem, h = problem_of(p, rtol), FIRST_STEP * drive.period(p)
        _clear(record, 0)
        y = relative_state(p, 0.0, y)
        for n in range(number):
            y, h, _, status = travel(problem, rtol, 0.0, drive.period(p), y, h, 10**7, record)
            if status != 0:
                return status
            motion = relative_state(p, 0.0, y)
            for i in range(3):
                states[n, i] = motion[i]
        return 0

    return periods


def adaptive_periods(
    p: Parameters, start: np.ndarray, number: int, rtol: float = 1e-10
) -> tuple[np.ndarray, np.ndarray]:
    """Return the states (x, v, ln phi) after each period from `start`, and the record."""
    states, record = np.empty((number, 3)), np.empty(RECORD)
    y = tuple(start.tolist())
    assert _adaptive()(np.array(p), rtol, y, number, states, record) == Status.OK
    return states, record
