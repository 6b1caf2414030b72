"""Stationary orbits one by one, by plain iteration: the scalar twins of the doors in lanes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import door, inline, jit
from stickslip.kernels.observers import measuring, no_record
from stickslip.kernels.problem import (
    adaptive_period,
    fixed_period,
    log_state,
    phi_state,
    same_state,
)
from stickslip.kernels.rows import FIRST_STEP, Settings, fail, parameters_of, period_of
from stickslip.measure import accumulate
from stickslip.model.rhs import State, starting_state
from stickslip.numerics.adaptive import DIVERGED, OK
from stickslip.numerics.periodic.stationarity import make_settle
from stickslip.parameters import Parameters
from stickslip.status import Status

INVARIANT_VIOLATED = int(Status.INVARIANT_VIOLATED)

# Power balance beyond which an orbit is not believed.
_POWER_BALANCE_LIMIT = 1e-2

# The error estimate integrates the final orbit again with a tolerance this much tighter.
_TIGHTER = 1e-2
_TIGHTEST = 1e-13

# What Euler-Cromer is compared with has its tolerance made tighter from here: its own error at
# the paper's step is 1e-9.
_FIXED_REFERENCE = 1e-7

# Budget of the adaptive orbit that a fixed-step one is compared with.
_PLENTY = 20_000_000

# ln(phi) repeats to this many tolerances: it is slaved to the motion, and swings by hundreds.
_FILM_WEIGHT = 1e-3


@inline
def _scaled(p: Parameters, y: State) -> State:
    """The state as its repetition is judged: (x/X_m, v/(X_m omega)) and, loosely, the film."""
    x, v, film_state = y
    return (
        x / p.drive_amplitude,
        v / (p.drive_amplitude * p.angular_frequency),
        _FILM_WEIGHT * film_state,
    )


@jit
def _fill(
    p: Parameters, record: np.ndarray, begin: State, end: State, cycle: int, result: np.ndarray
) -> None:
    """Write what a record says of a closed orbit into the result row."""
    result[0], result[1] = accumulate.amplitudes(record)
    result[2], result[3] = record[accumulate.STRESS_MAX], -record[accumulate.STRESS_MINUS_MIN]
    result[4], result[5] = record[accumulate.FORCE_MAX], -record[accumulate.FORCE_MINUS_MIN]
    result[7] = accumulate.power_balance_error(p, record, begin, end)
    result[8] = cycle
    result[9] = accumulate.meltings(record)
    result[10] = accumulate.asymmetry(record)


@inline
def _with_rtol(settings: Settings, rtol: float) -> Settings:
    return Settings(
        max(rtol, _TIGHTEST),
        settings.dt,
        settings.max_steps,
        settings.stationary_rtol,
        settings.max_periods,
        settings.accelerate,
    )


def _make_cycle(period_map: Any) -> Any:
    """The integration of a whole cycle of periods with measurement on."""

    @jit
    def cycle_measured(
        p: Parameters,
        settings: Settings,
        y: State,
        h: float,
        cycle: int,
        budget: int,
        values: np.ndarray,
    ) -> Any:
        accumulate.start(values)
        record = measuring(values)
        steps, status = 0, OK
        for _ in range(cycle):
            y, h, used, status = period_map(p, settings, y, h, budget - steps, record)
            steps += used
            if status != OK:
                break
        return y, steps, status

    return cycle_measured


_better_cycle = _make_cycle(adaptive_period)


def _make_point(
    period_map: Any, state: Any, log_state: Any, reference: Any, extrapolate: bool
) -> Any:
    """The computation of one point with one method.

    `state` turns (x, v, ln phi) into the method's own state and `log_state` back; `reference`
    gives the tolerance that the second, better integration of the orbit has to beat. The two
    differ by the error estimate; with `extrapolate` the better one is reported.
    """
    settle = make_settle(period_map, _scaled)
    cycle_measured = _make_cycle(period_map)

    @jit
    def point(
        p: Parameters,
        settings: Settings,
        result: np.ndarray,
        final: np.ndarray,
        records: np.ndarray,
    ) -> None:
        start = starting_state(p)
        first_step = FIRST_STEP * period_of(p)
        y, h, cycle, periods, steps, status = settle(
            p, settings, state(start), first_step, settings.max_steps, no_record()
        )
        settled = log_state(y)
        final[0], final[1], final[2], final[3] = settled[0], settled[1], settled[2], h
        if status != OK:
            fail(result, periods, status)
            return
        record, better = records[0], records[1]
        end, used, status = cycle_measured(
            p, settings, y, h, cycle, settings.max_steps - steps, record
        )
        periods += cycle
        if status == OK:
            budget = max(settings.max_steps - steps - used, 0) if extrapolate else _PLENTY
            tight = _with_rtol(settings, _TIGHTER * reference(settings))
            better_end, _, status = _better_cycle(p, tight, settled, 0.1 * h, cycle, budget, better)
        if status != OK:
            fail(result, periods, status)
            return
        result[6] = accumulate.amplitude_error(p, record, better)
        if extrapolate:
            record = better
            _fill(p, better, settled, better_end, cycle, result)
        else:
            _fill(p, record, y, end, cycle, result)
        result[11], result[12] = periods, OK
        if not math.isfinite(result[0] + result[1] + result[6]):
            fail(result, periods, DIVERGED)
            return
        believed = accumulate.balance_kept(p, record, result[7], cycle, _POWER_BALANCE_LIMIT)
        if not (believed and accumulate.bounds_kept(p, record, math.exp(start[2]))):
            fail(result, periods, INVARIANT_VIOLATED)

    return point


@inline
def _own_tolerance(settings: Settings) -> float:
    return settings.rtol


@inline
def _paper_tolerance(settings: Settings) -> float:
    return _FIXED_REFERENCE


_adaptive_point = _make_point(adaptive_period, same_state, same_state, _own_tolerance, True)
_fixed_point = _make_point(fixed_period, phi_state, log_state, _paper_tolerance, False)


@door
def adaptive_orbits(
    points: np.ndarray, settings: Settings, results: np.ndarray, finals: np.ndarray
) -> None:
    """Stationary orbits by the adaptive method, one for each row of parameters.

    `points` (n, 20) in the order of `Parameters._fields`; `results` (n, 13) and `finals` (n, 4)
    are written, in the order of RESULT_COLUMNS and FINAL_COLUMNS.
    """
    records = np.empty((2, accumulate.LENGTH))
    for i in range(points.shape[0]):
        _adaptive_point(parameters_of(points[i]), settings, results[i], finals[i], records)


@door
def fixed_orbits(
    points: np.ndarray, settings: Settings, results: np.ndarray, finals: np.ndarray
) -> None:
    """Stationary orbits by Euler-Cromer; arrays as for `adaptive_orbits`.

    The error estimate compares with the adaptive method from the same stroboscopic state.
    """
    records = np.empty((2, accumulate.LENGTH))
    for i in range(points.shape[0]):
        _fixed_point(parameters_of(points[i]), settings, results[i], finals[i], records)
