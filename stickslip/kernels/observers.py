"""What is taken from each step of a drive: nothing, a measurement, or samples."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.measure import accumulate
from stickslip.model.rhs import State, relative_velocity, stress_and_force
from stickslip.numerics import extrema
from stickslip.numerics.rosenbrock import interpolate
from stickslip.parameters import Parameters

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
def no_record() -> Record:
    """A record for a drive that only travels."""
    return Record(TRAVEL, np.empty(0), np.empty((0, 3)), np.empty(0, np.int64), 0.0)


@inline
def measuring(values: np.ndarray) -> Record:
    """A record that measures into `values`, shape (accumulate.LENGTH,)."""
    return Record(MEASURE, values, np.empty((0, 3)), np.empty(0, np.int64), 0.0)


@inline
def sampling(samples: np.ndarray, sample_dt: float) -> Record:
    """A record that writes the states at the phase times j sample_dt into `samples` (n, 3)."""
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
    stress, force = accumulate.stress_nodes(record), accumulate.force_nodes(record)
    for node in range(extrema.COUNT):
        at, (_, v, psi) = _at(step, extrema.NODES[node])
        phi = math.exp(psi)
        sigma_el, F = stress_and_force(p, relative_velocity(p, at, v), phi)
        stress[node], force[node] = sigma_el, F
        accumulate.see_phase(p, phi, record)
        accumulate.see_work(p, at, v, F, h * extrema.BOOLE_WEIGHTS[node], record)
    for slot, sign in ((accumulate.STRESS_MAX, 1.0), (accumulate.STRESS_MINUS_MIN, -1.0)):
        record[slot] = _stress_extremum(p, step, sign, stress, record[slot])
    for slot, sign in ((accumulate.FORCE_MAX, 1.0), (accumulate.FORCE_MINUS_MIN, -1.0)):
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
def see_step(
    p: Parameters, t: float, h: float, y0: State, y1: State, d1: State, d2: State, record: Record
) -> None:
    """What is taken from a step of the adaptive method."""
    if record.purpose == MEASURE:
        _measure_step(p, t, h, y0, y1, d1, d2, record.values)
    elif record.purpose == SAMPLE:
        _sample_step(p, t, h, y0, y1, d1, d2, record)


@inline
def see_fixed_step(p: Parameters, t: float, h: float, y0: State, y1: State, record: Record) -> None:
    """What is taken from a fixed step, which stands for its start and is joined by a line."""
    if record.purpose == MEASURE:
        accumulate.see_point(p, t, h, y0[1], y0[2], record.values)
    elif record.purpose == SAMPLE:
        zero = (0.0, 0.0, 0.0)
        _sample_step(p, t, h, y0, y1, zero, zero, record)
