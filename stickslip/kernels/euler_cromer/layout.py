"""What fixed-step lanes hold: rows of numbers in units of each point's own, made and read here."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import door, inline, jit
from stickslip.kernels.euler_cromer.scaling import (
    StepParameters,
    StepUnits,
    from_lane,
    step_parameters,
    step_units,
    to_lane,
)
from stickslip.kernels.problem import phi_state
from stickslip.kernels.rows import parameters_of, period_of
from stickslip.measure import accumulate
from stickslip.model.rhs import starting_state
from stickslip.numerics.euler_cromer_lanes import CHANGE, DRIVE, FREE, TURN, V, W, X

_PARAMETERS = len(StepParameters._fields)

RECORD = FREE + _PARAMETERS
"""Behind the parameters lies a record with the slots of accumulate.py. It has minima instead of
maxima of negatives, which takes fewer operations."""

STRESS_MIN, FORCE_MIN = accumulate.STRESS_MINUS_MIN, accumulate.FORCE_MINUS_MIN

SLOTS = RECORD + accumulate.SLOTS
"""Numbers that a lane holds: the length of a row."""


@inline
def _clear_record(row: np.ndarray) -> None:
    for slot in range(accumulate.SLOTS):
        row[RECORD + slot] = 0.0
    for slot in (accumulate.STRESS_MAX, accumulate.FORCE_MAX):
        row[RECORD + slot] = -np.inf
    for slot in (STRESS_MIN, FORCE_MIN):
        row[RECORD + slot] = np.inf


@door
def write_steps(points: np.ndarray, dt: float, steps: np.ndarray) -> None:
    """Write the number of steps a period: it is divided evenly, by a step of at most `dt`."""
    for i in range(points.shape[0]):
        steps[i] = math.ceil(period_of(parameters_of(points[i])) / dt)


@door
def write_starts(points: np.ndarray, states: np.ndarray) -> None:
    """Write the starts (x, v, phi) of points (n, 20), in SI units, into `states` (n, 3)."""
    for i in range(points.shape[0]):
        y = phi_state(starting_state(parameters_of(points[i])))
        states[i, 0], states[i, 1], states[i, 2] = y


@door
def fill_rows(points: np.ndarray, steps: np.ndarray, states: np.ndarray, rows: np.ndarray) -> None:
    """Write what lanes hold at phase 0.

    `points` (n, 20); `steps` (n,) a period; `states` (n, 3) are (x, v, phi); `rows` (n, SLOTS).
    """
    for i in range(points.shape[0]):
        p, row = parameters_of(points[i]), rows[i]
        y = (states[i, 0], states[i, 1], states[i, 2])
        row[X], row[V], row[W] = to_lane(step_units(p, steps[i]), y)
        own = step_parameters(p, steps[i])
        row[DRIVE], row[CHANGE] = 0.0, 0.0  # written at step 0
        half = 2.0 * math.sin(0.5 * own.angle)
        row[TURN] = half * half
        for slot in range(_PARAMETERS):
            row[FREE + slot] = own[slot]
        _clear_record(row)


@door
def clear_records(rows: np.ndarray, which: np.ndarray) -> None:
    """Make the records of some rows ready for a new orbit."""
    for i in which:
        _clear_record(rows[i])


@door
def read_states(
    points: np.ndarray, steps: np.ndarray, rows: np.ndarray, states: np.ndarray
) -> None:
    """Write the states (x, v, phi) of rows, in SI units, into `states` (n, 3)."""
    for i in range(points.shape[0]):
        row, units = rows[i], step_units(parameters_of(points[i]), steps[i])
        y = from_lane(units, (row[X], row[V], row[W]))
        states[i, 0], states[i, 1], states[i, 2] = y


@inline
def _signed_extrema(
    row: np.ndarray, maximum: int, minimum: int, unit: float
) -> tuple[float, float]:
    """Maximum and minimum in SI units; they change places where the unit is negative."""
    high, low = row[RECORD + maximum] * unit, row[RECORD + minimum] * unit
    return (high, low) if unit > 0.0 else (low, high)


@jit
def _write_record(row: np.ndarray, units: StepUnits, record: np.ndarray) -> None:
    accumulate.start(record)
    high, low = _signed_extrema(row, accumulate.STRESS_MAX, STRESS_MIN, units.stress)
    record[accumulate.STRESS_MAX], record[accumulate.STRESS_MINUS_MIN] = high, -low
    high, low = _signed_extrema(row, accumulate.FORCE_MAX, FORCE_MIN, units.force)
    record[accumulate.FORCE_MAX], record[accumulate.FORCE_MINUS_MIN] = high, -low
    for slot in (accumulate.DRIVE_WORK, accumulate.ABSOLUTE_WORK, accumulate.BLOCK_WORK):
        record[slot] = row[RECORD + slot] * (units.force * units.length)
    record[accumulate.PHI_MAX] = row[RECORD + accumulate.PHI_MAX] * units.phi
    for slot in (accumulate.MELTINGS, accumulate.FIRST_PHASE, accumulate.LAST_PHASE):
        record[slot] = row[RECORD + slot]


@door
def read_records(
    points: np.ndarray, steps: np.ndarray, rows: np.ndarray, records: np.ndarray
) -> None:
    """Write the records of rows, in SI units, into `records` (n, accumulate.LENGTH)."""
    for i in range(points.shape[0]):
        _write_record(rows[i], step_units(parameters_of(points[i]), steps[i]), records[i])
