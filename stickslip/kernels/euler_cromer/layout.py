"""What fixed-step lanes hold: rows of numbers in units of each point's own, made and read here."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import kernel, kernel_factory, named_kernel
from stickslip.kernels.euler_cromer.scaling import (
    StepParameters,
    from_lane,
    record_units,
    step_reduction,
    step_units_of,
    to_lane,
)
from stickslip.kernels.points import parameters_of
from stickslip.kernels.streams import STREAM
from stickslip.measure.accumulate import RECORD, accumulator
from stickslip.measure.results import write_stretch, write_whole_orbit
from stickslip.numerics.euler_cromer_lanes import CHANGE, DRIVE, FREE, TURN, V, W, X
from stickslip.options import Physics

_PARAMETERS = len(StepParameters._fields)

RECORD_BEGIN = FREE + _PARAMETERS
"""Behind the parameters lies a record."""

SLOTS = RECORD_BEGIN + RECORD
"""Numbers that a lane holds: the length of a row."""

CHANCE_SLOTS = STREAM + 2
"""Behind them, where the noise is left to chance: the stream of random numbers, the number of the
next group of steps, and the signs that are left of this one."""

# A row is an array of one lane.
_clear_record = accumulator(1, RECORD_BEGIN).clear


class RowKernels(NamedTuple):
    """Kernels that make and read rows (n, SLOTS) of points (n, parameters), `steps` (n,) a period.

    States (n, 3) are (x, v, phi) in SI units.
    """

    fill: Any
    """(points, steps, states, rows): write what lanes hold at phase 0."""

    read_states: Any
    """(points, steps, rows, states): write the states."""

    read_records: Any
    """(points, steps, rows, closed, records): write the records, in SI units (n, RECORD), of orbits
    where `closed`, else of stretches of motion."""


@kernel
def clear_records(rows: np.ndarray, which: np.ndarray) -> None:
    """Make the records of the rows with the indices `which` (m,) ready for a new orbit."""
    for i in which:
        _clear_record(rows[i], 0)


@kernel_factory
def row_kernels(physics: Physics) -> RowKernels:
    """The kernels for rows of points with this law of friction."""
    step_parameters, step_units = step_reduction(physics), step_units_of(physics)

    def fill(points: np.ndarray, steps: np.ndarray, states: np.ndarray, rows: np.ndarray) -> None:
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
            _clear_record(row, 0)

    def read_states(
        points: np.ndarray, steps: np.ndarray, rows: np.ndarray, states: np.ndarray
    ) -> None:
        for i in range(points.shape[0]):
            row, units = rows[i], step_units(parameters_of(points[i]), steps[i])
            y = from_lane(units, (row[X], row[V], row[W]))
            states[i, 0], states[i, 1], states[i, 2] = y

    def read_records(
        points: np.ndarray,
        steps: np.ndarray,
        rows: np.ndarray,
        closed: bool,
        records: np.ndarray,
    ) -> None:
        for i in range(points.shape[0]):
            record = rows[i, RECORD_BEGIN:]
            units = record_units(step_units(parameters_of(points[i]), steps[i]), steps[i])
            if closed:
                write_whole_orbit(record, units, 2, records[i])  # whole periods
            else:
                write_stretch(record, units, 1, records[i])

    return RowKernels(
        named_kernel(f"fill_rows[{physics}]", fill),
        named_kernel(f"read_states[{physics}]", read_states),
        named_kernel(f"read_records[{physics}]", read_records),
    )
