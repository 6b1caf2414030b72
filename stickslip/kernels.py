"""The compiled doors: the only place where the model and the numerical methods meet.

A door takes plain arrays and a Settings tuple, works through many points without the interpreter
and leaves a status for each; it raises nothing. `NUMERICS_VERSION` must be raised whenever a
change alters any number that a door returns; the golden tests notice when it was forgotten.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip import measurement
from stickslip.compiled import door, inline, jit
from stickslip.model import drive, film, friction, noise
from stickslip.model.rhs import (
    State,
    block_acceleration,
    film_melting_function,
    jacobian,
    relative_velocity,
    rhs,
    starting_state,
    stress_and_force,
)
from stickslip.numerics import extrema
from stickslip.numerics.adaptive import OK, make_adaptive
from stickslip.numerics.fixed import make_fixed
from stickslip.numerics.rosenbrock import interpolate
from stickslip.numerics.stationarity import make_settle
from stickslip.numerics.tableaus import RODAS4P
from stickslip.parameters import Parameters, ParameterValues
from stickslip.status import Status

NUMERICS_VERSION = 1

INVARIANT_VIOLATED = int(Status.INVARIANT_VIOLATED)

# The first step as a part of the drive period: short against every rate of the paper's scenes,
# and the controller lengthens it six-fold a step.
_FIRST_STEP = 1e-6

# Power balance beyond which an orbit is not believed.
_POWER_BALANCE_LIMIT = 1e-2

# The error estimate integrates the final orbit again with a tolerance this much tighter.
_TIGHTER = 1e-2
_TIGHTEST = 1e-13

# Where the noise of the step control keeps an orbit from settling, the tolerance is cut by this.
_REFINEMENT = 0.1

# What Euler-Cromer is compared with has its tolerance made tighter from here: its own error at
# the paper's step is 1e-9.
_FIXED_REFERENCE = 1e-7

# A budget for runs that must not end early: 10 hours of steps.
_PLENTY = 10**11

# ln(phi) repeats to this many tolerances: it is slaved to the motion, and swings by hundreds.
_FILM_WEIGHT = 1e-3


# For fluids whose viscous stress is smooth in u (gamma >= 0) an error of the velocity counts by the
# error of the force that it makes, against this many times the force that locks the block: a
# locked block moves with the drive to parts in 1e5, and its slip must be right, not just its speed.
_FORCE_WEIGHT = 20.0


class Settings(NamedTuple):
    """What a door needs beside the parameters; `integrator.rtol` and so on in a config."""

    rtol: float
    dt: float
    max_steps: int
    stationary_rtol: float
    max_periods: int
    accelerate: bool


RESULT_COLUMNS = (
    "elastic_stress_amplitude",
    "friction_force_amplitude",
    "elastic_stress_max",
    "elastic_stress_min",
    "friction_force_max",
    "friction_force_min",
    "amplitude_error",
    "power_balance_error",
    "orbit_periods",
    "melting_count",
    "asymmetry",
    "periods_integrated",
    "status",
)
"""Columns of a result row; the names are those of `variables.RESULTS`."""

FINAL_COLUMNS = ("displacement", "velocity", "log_order_parameter", "step")
"""Columns of a final row: the stroboscopic state (x, v, ln phi) on the orbit, the next step."""


@inline
def period_of(p: Parameters) -> float:
    """Drive period 2 pi/omega [s]."""
    return 2.0 * math.pi / p.angular_frequency


@inline
def parameters_of(row: np.ndarray) -> ParameterValues:
    """The parameters held by a row of 20 floats in the order of the fields."""
    return ParameterValues(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9],
        row[10], row[11], row[12], row[13], row[14], row[15], row[16], row[17], row[18], row[19],
    )  # fmt: skip


# --- observers: what is taken from each step -----------------------------------------------------

TRAVEL, MEASURE, SAMPLE = 0, 1, 2


class Record(NamedTuple):
    """What a drive writes on its way, and for which purpose.

    One type for all purposes, so that the costly part, the drive, is compiled once.
    """

    purpose: int
    values: np.ndarray
    samples: np.ndarray
    cursor: np.ndarray
    sample_dt: float


@inline
def _no_record() -> Record:
    return Record(TRAVEL, np.empty(0), np.empty((0, 3)), np.empty(0, np.int64), 0.0)


@inline
def _measuring(values: np.ndarray) -> Record:
    return Record(MEASURE, values, np.empty((0, 3)), np.empty(0, np.int64), 0.0)


@inline
def _sampling(samples: np.ndarray, sample_dt: float) -> Record:
    return Record(SAMPLE, np.empty(0), samples, np.zeros(1, np.int64), sample_dt)


@inline
def _at(step: Any, theta: float) -> tuple[float, State]:
    t, h, y0, y1, d1, d2 = step
    return t + theta * h, interpolate(theta, y0, y1, d1, d2)


@inline
def _along(p: Parameters, step: Any, theta: float) -> tuple[float, float]:
    t, (_, v, psi) = _at(step, theta)
    return stress_and_force(p, relative_velocity(p, t, v), math.exp(psi))


@inline
def _stress_along(p: Parameters, step: Any, theta: float) -> float:
    return _along(p, step, theta)[0]


@inline
def _force_along(p: Parameters, step: Any, theta: float) -> float:
    return _along(p, step, theta)[1]


_stress_extremum = extrema.make_extremum(_stress_along)
_force_extremum = extrema.make_extremum(_force_along)


@jit
def _measure_step(
    p: Parameters, t: float, h: float, y0: State, y1: State, d1: State, d2: State, record: Any
) -> None:
    """Take in a step of the adaptive method: extrema inside it, integrals, phases."""
    step = (t, h, y0, y1, d1, d2)
    stress, force = measurement.stress_nodes(record), measurement.force_nodes(record)
    for node in range(extrema.COUNT):
        at, (_, v, psi) = _at(step, extrema.NODES[node])
        phi = math.exp(psi)
        sigma_el, F = stress_and_force(p, relative_velocity(p, at, v), phi)
        stress[node], force[node] = sigma_el, F
        measurement.see_phase(p, phi, record)
        measurement.see_work(p, at, v, F, h * extrema.BOOLE_WEIGHTS[node], record)
    for slot, sign in ((measurement.STRESS_MAX, 1.0), (measurement.STRESS_MINUS_MIN, -1.0)):
        record[slot] = _stress_extremum(p, step, sign, stress, record[slot])
    for slot, sign in ((measurement.FORCE_MAX, 1.0), (measurement.FORCE_MINUS_MIN, -1.0)):
        record[slot] = _force_extremum(p, step, sign, force, record[slot])


@jit
def _sample_step(
    p: Parameters, t: float, h: float, y0: State, y1: State, d1: State, d2: State, record: Record
) -> None:
    """Write the states at the sample times within a step: sample j is due at phase time j dt."""
    rows, cursor = record.samples, record.cursor
    while cursor[0] < rows.shape[0] and cursor[0] * record.sample_dt < t + h:
        y = interpolate((cursor[0] * record.sample_dt - t) / h, y0, y1, d1, d2)
        rows[cursor[0], 0], rows[cursor[0], 1], rows[cursor[0], 2] = y[0], y[1], y[2]
        cursor[0] += 1


@inline
def _see_step(
    p: Parameters, t: float, h: float, y0: State, y1: State, d1: State, d2: State, record: Record
) -> None:
    """What is taken from a step of the adaptive method."""
    if record.purpose == MEASURE:
        _measure_step(p, t, h, y0, y1, d1, d2, record.values)
    elif record.purpose == SAMPLE:
        _sample_step(p, t, h, y0, y1, d1, d2, record)


@inline
def _see_fixed_step(
    p: Parameters, t: float, h: float, y0: State, y1: State, record: Record
) -> None:
    """What is taken from a fixed step, which stands for its start and is joined by a line."""
    if record.purpose == MEASURE:
        measurement.see_point(p, t, h, y0[1], y0[2], record.values)
    elif record.purpose == SAMPLE:
        zero = (0.0, 0.0, 0.0)
        _sample_step(p, t, h, y0, y1, zero, zero, record)


# --- the adaptive method: state (x, v, ln phi), memory = the step to go on with -------------------


@inline
def _error_scale(p: Parameters, y: State, J: tuple[State, State, State, State]) -> State:
    X_m = abs(p.drive_amplitude)
    V_m = X_m * p.angular_frequency
    if p.rheological_index >= 0.0:
        locking = 2.0 * p.spring_stiffness * X_m + p.block_mass * p.angular_frequency * V_m
        V_m /= 1.0 + V_m * (-J[1][1] * p.block_mass) / (_FORCE_WEIGHT * locking)
    return X_m, V_m, 1.0 + abs(y[2])


_travel = make_adaptive(rhs, jacobian, _error_scale, _see_step, RODAS4P)


@jit
def _adaptive_period(
    p: Parameters, settings: Settings, y: State, h: float, budget: int, record: Record
) -> Any:
    return _travel(p, settings.rtol, 0.0, period_of(p), y, h, budget, record)


@inline
def _log_state(y: State) -> State:
    return y


# --- Euler-Cromer: state (x, v, phi), no memory ---------------------------------------------------


@inline
def _increments(p: Parameters, t: float, dt: float, y: State) -> tuple[float, float]:
    """What v and phi gain in a fixed step from the old state (Eqs. 3 and 26)."""
    x, v, phi = y
    u = relative_velocity(p, t, v)
    _, F = stress_and_force(p, u, phi)
    rate = film.order_parameter_rate(
        phi,
        film_melting_function(p, u),
        p.cubic_coefficient,
        p.quartic_coefficient,
        p.kinetic_coefficient,
    )
    kick = noise.typical_kick(phi, noise.effective_intensity(p.noise_intensity), dt)
    return dt * block_acceleration(p, x, F), dt * rate + kick


_march = make_fixed(_increments, _see_fixed_step)


@inline
def _fixed_steps(p: Parameters, settings: Settings) -> int:
    """Steps a period: the drive period is divided evenly, so a step may be a little below dt."""
    return math.ceil(period_of(p) / settings.dt)


@jit
def _fixed_period(
    p: Parameters, settings: Settings, y: State, h: float, budget: int, record: Record
) -> Any:
    steps = _fixed_steps(p, settings)
    y, used, status = _march(p, 0.0, period_of(p), steps, y, budget, record)
    return y, h, used, status


@inline
def _fixed_log_state(y: State) -> State:
    return y[0], y[1], math.log(y[2])


@inline
def _fixed_state(y: State) -> State:
    """The state (x, v, phi) for a state (x, v, ln phi)."""
    return y[0], y[1], math.exp(y[2])


# --- a point: start, settle, measure, estimate the error ------------------------------------------


@inline
def _scaled(p: Parameters, y: State) -> State:
    """The state as its repetition is judged: (x/X_m, v/(X_m omega)) and, loosely, the film."""
    x, v, film_state = y
    return (
        x / p.drive_amplitude,
        v / (p.drive_amplitude * p.angular_frequency),
        _FILM_WEIGHT * film_state,
    )


@inline
def _shifted(p: Parameters, y: State, dx: float, dv: float) -> State:
    """The state moved by `dx` X_m and `dv` X_m omega; the film stays as it is."""
    X_m = p.drive_amplitude
    return y[0] + dx * X_m, y[1] + dv * (X_m * p.angular_frequency), y[2]


@jit
def _fail(result: np.ndarray, periods: int, status: int) -> None:
    for column in range(result.shape[0]):  # a slice would compile NumPy's shape errors
        result[column] = np.nan
    result[8], result[9] = -1, -1
    result[11] = periods
    result[12] = status


@jit
def _fill(
    p: Parameters, record: np.ndarray, begin: State, end: State, cycle: int, result: np.ndarray
) -> None:
    """Write what a record says of a closed orbit into the result row."""
    result[0], result[1] = measurement.amplitudes(record)
    result[2], result[3] = record[measurement.STRESS_MAX], -record[measurement.STRESS_MINUS_MIN]
    result[4], result[5] = record[measurement.FORCE_MAX], -record[measurement.FORCE_MINUS_MIN]
    result[7] = measurement.power_balance_error(p, record, begin, end)
    result[8] = cycle
    result[9] = measurement.meltings(record)
    result[10] = measurement.asymmetry(record)


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


@inline
def _refined(settings: Settings) -> Settings:
    return _with_rtol(settings, _REFINEMENT * settings.rtol)


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
        measurement.start(values)
        record = _measuring(values)
        steps, status = 0, OK
        for _ in range(cycle):
            y, h, used, status = period_map(p, settings, y, h, budget - steps, record)
            steps += used
            if status != OK:
                break
        return y, steps, status

    return cycle_measured


_better_cycle = _make_cycle(_adaptive_period)


def _make_point(
    period_map: Any, state: Any, log_state: Any, reference: Any, extrapolate: bool
) -> Any:
    """The computation of one point with one method.

    `state` turns (x, v, ln phi) into the method's own state and `log_state` back; `reference`
    gives the tolerance that the second, better integration of the orbit has to beat. The two
    differ by the error estimate; with `extrapolate` the better one is reported.
    """
    settle = make_settle(period_map, _scaled, _shifted, _refined)
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
        first_step = _FIRST_STEP * period_of(p)
        y, h, cycle, periods, steps, status = settle(
            p, settings, state(start), first_step, settings.max_steps, _no_record()
        )
        settled = log_state(y)
        final[0], final[1], final[2], final[3] = settled[0], settled[1], settled[2], h
        if status != OK:
            _fail(result, periods, status)
            return
        record, better = records[0], records[1]
        end, _, status = cycle_measured(
            p, settings, y, h, cycle, settings.max_steps - steps, record
        )
        periods += cycle
        if status == OK:
            tight = _with_rtol(settings, _TIGHTER * reference(settings))
            better_end, _, status = _better_cycle(
                p, tight, settled, 0.1 * h, cycle, _PLENTY, better
            )
        if status != OK:
            _fail(result, periods, status)
            return
        result[6] = measurement.amplitude_error(p, record, better)
        if extrapolate:
            record = better
            _fill(p, better, settled, better_end, cycle, result)
        else:
            _fill(p, record, y, end, cycle, result)
        result[11], result[12] = periods, OK
        believed = measurement.balance_kept(p, record, result[7], cycle, _POWER_BALANCE_LIMIT)
        if not (believed and measurement.bounds_kept(p, record, math.exp(start[2]))):
            _fail(result, periods, INVARIANT_VIOLATED)

    return point


@inline
def _own_tolerance(settings: Settings) -> float:
    return settings.rtol


@inline
def _paper_tolerance(settings: Settings) -> float:
    return _FIXED_REFERENCE


_adaptive_point = _make_point(_adaptive_period, _log_state, _log_state, _own_tolerance, True)
_fixed_point = _make_point(_fixed_period, _fixed_state, _fixed_log_state, _paper_tolerance, False)


@door
def adaptive_orbits(
    points: np.ndarray, settings: Settings, results: np.ndarray, finals: np.ndarray
) -> None:
    """Stationary orbits by the adaptive method, one for each row of parameters.

    `points` (n, 20) in the order of `Parameters._fields`; `results` (n, 13) and `finals` (n, 4)
    are written, in the order of RESULT_COLUMNS and FINAL_COLUMNS.
    """
    records = np.empty((2, measurement.LENGTH))
    for i in range(points.shape[0]):
        _adaptive_point(parameters_of(points[i]), settings, results[i], finals[i], records)


@door
def fixed_orbits(
    points: np.ndarray, settings: Settings, results: np.ndarray, finals: np.ndarray
) -> None:
    """Stationary orbits by Euler-Cromer; arrays as for `adaptive_orbits`.

    The error estimate compares with the adaptive method from the same stroboscopic state.
    """
    records = np.empty((2, measurement.LENGTH))
    for i in range(points.shape[0]):
        _fixed_point(parameters_of(points[i]), settings, results[i], finals[i], records)


def _make_trajectory(period_map: Any, state: Any, log_state: Any) -> Any:
    """The sampling of one trajectory with one method; `state`, `log_state` as in `_make_point`."""

    @jit
    def trajectory(
        p: Parameters, settings: Settings, start: State, per_period: int, samples: np.ndarray
    ) -> int:
        last = samples.shape[0] - 1
        y, h, steps, status = state(start), _FIRST_STEP * period_of(p), 0, OK
        for first in range(0, last, per_period):
            record = _sampling(samples[first : first + per_period], period_of(p) / per_period)
            y, h, used, status = period_map(p, settings, y, h, settings.max_steps - steps, record)
            steps += used
            if status != OK:
                return status
        samples[last, 0], samples[last, 1], samples[last, 2] = y[0], y[1], y[2]
        for row in samples:
            row[2] = math.exp(log_state((row[0], row[1], row[2]))[2])
        return status

    return trajectory


_adaptive_trajectory = _make_trajectory(_adaptive_period, _log_state, _log_state)
_fixed_trajectory = _make_trajectory(_fixed_period, _fixed_state, _fixed_log_state)


@door
def adaptive_trajectory(
    point: np.ndarray, settings: Settings, start: np.ndarray, per_period: int, samples: np.ndarray
) -> int:
    """A sampled trajectory by the adaptive method; returns the status as an integer.

    `point` (20,) parameters; `start` (3,) the state (x, v, ln phi) at phase 0; `samples`
    (periods*per_period + 1, 3) receives (x, v, phi) at equal times.
    """
    return _adaptive_trajectory(
        parameters_of(point), settings, (start[0], start[1], start[2]), per_period, samples
    )


@door
def fixed_trajectory(
    point: np.ndarray, settings: Settings, start: np.ndarray, per_period: int, samples: np.ndarray
) -> int:
    """A sampled trajectory by Euler-Cromer; as `adaptive_trajectory`."""
    return _fixed_trajectory(
        parameters_of(point), settings, (start[0], start[1], start[2]), per_period, samples
    )


@door
def trajectory_observables(
    point: np.ndarray, times: np.ndarray, samples: np.ndarray, observables: np.ndarray
) -> None:
    """What follows from the states (x, v, phi) of a trajectory.

    `times` (n,), `samples` (n, 3); `observables` (n, 6) receives X, V, elastic strain, elastic
    stress, viscous stress, friction force.
    """
    p = parameters_of(point)
    for i in range(times.shape[0]):
        t = times[i]
        u = relative_velocity(p, t, samples[i, 1])
        row = observables[i]
        row[0] = drive.upper_displacement(t, p.drive_amplitude, p.angular_frequency)
        row[1] = drive.upper_velocity(t, p.drive_amplitude, p.angular_frequency)
        row[2] = friction.elastic_strain(u, p.strain_relaxation_time, p.film_thickness)
        row[3], row[5] = stress_and_force(p, u, samples[i, 2])
        row[4] = friction.viscous_stress(
            u, p.film_thickness, p.viscosity_coefficient, p.rheological_index
        )


@door
def starting_log_state(point: np.ndarray, state: np.ndarray) -> None:
    """Write the start (x, v, ln phi) of the parameters `point` (20,) into `state` (3,)."""
    state[0], state[1], state[2] = starting_state(parameters_of(point))
