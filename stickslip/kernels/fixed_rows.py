"""What fixed-step lanes hold: rows of numbers in units of each point's own, made and read here."""

from __future__ import annotations

import math

import numpy as np

from stickslip import measurement
from stickslip.compiled import door, inline, jit
from stickslip.kernels.fixed_units import (
    StepParameters,
    StepUnits,
    from_lane,
    step_parameters,
    step_units,
    to_lane,
)
from stickslip.kernels.methods import phi_state
from stickslip.kernels.rows import parameters_of, period_of
from stickslip.model.rhs import starting_state
from stickslip.numerics.fixed_lanes import CHANGE, DRIVE, FREE, TURN, V, W, X

_PARAMETERS = len(StepParameters._fields)

RECORD = FREE + _PARAMETERS
"""Behind the parameters lies a record with the slots of measurement.py. It has minima instead of
maxima of negatives, which takes fewer operations."""

STRESS_MIN, FORCE_MIN = measurement.STRESS_MINUS_MIN, measurement.FORCE_MINUS_MIN

SLOTS = RECORD + measurement.SLOTS
"""Numbers that a lane holds: the length of a row."""


@inline
def _clear_record(row: np.ndarray) -> None:
    for slot in range(measurement.SLOTS):
        row[RECORD + slot] = 0.0
    for slot in (measurement.STRESS_MAX, measurement.FORCE_MAX):
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
    measurement.start(record)
    high, low = _signed_extrema(row, measurement.STRESS_MAX, STRESS_MIN, units.stress)
    record[measurement.STRESS_MAX], record[measurement.STRESS_MINUS_MIN] = high, -low
    high, low = _signed_extrema(row, measurement.FORCE_MAX, FORCE_MIN, units.force)
    record[measurement.FORCE_MAX], record[measurement.FORCE_MINUS_MIN] = high, -low
    for slot in (measurement.DRIVE_WORK, measurement.ABSOLUTE_WORK, measurement.BLOCK_WORK):
        record[slot] = row[RECORD + slot] * (units.force * units.length)
    record[measurement.PHI_MAX] = row[RECORD + measurement.PHI_MAX] * units.phi
    for slot in (measurement.MELTINGS, measurement.FIRST_PHASE, measurement.LAST_PHASE):
        record[slot] = row[RECORD + slot]


@door
def read_records(
    points: np.ndarray, steps: np.ndarray, rows: np.ndarray, records: np.ndarray
) -> None:
    """Write the records of rows, in SI units, into `records` (n, measurement.LENGTH)."""
    for i in range(points.shape[0]):
        _write_record(rows[i], step_units(parameters_of(points[i]), steps[i]), records[i])
