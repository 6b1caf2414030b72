"""The layout of fixed-step lanes, whose rows of numbers are in each point's own units."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import kernel, kernel_factory, named_kernel
from stickslip.kernels.euler_cromer.step_units import (
    StepParameters,
    from_lane,
    step_reduction,
    step_units,
    to_lane,
)
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.kernels.streams import STREAM
from stickslip.measure.accumulate import RECORD, accumulator
from stickslip.measure.results import record_units, write_stretch, write_whole_orbit
from stickslip.model import drive
from stickslip.numerics.euler_cromer_lanes import CHANGE, DRIVE, SINE, TURN, V, W, X, first_free
from stickslip.options import Physics

PARAMETERS_BEGIN = first_free(len(drive.TONES))
"""The first slot of the parameters, after the drive."""

RECORD_BEGIN = PARAMETERS_BEGIN + len(StepParameters._fields)
"""The first slot of the record, after the parameters."""

SLOTS = RECORD_BEGIN + RECORD
"""The number of slots of a lane without stochastic noise."""

# With stochastic noise there follow the stream of random numbers, the number of the next group of
# steps, and the remaining signs of the present group.
_CHANCE_SLOTS = STREAM + 2

_HARMONICS = tuple(tone.harmonic for tone in drive.TONES)


def row_length(physics: Physics) -> int:
    """Return the number of slots of a lane."""
    return SLOTS + (_CHANCE_SLOTS if physics.chance else 0)


# A row is an array of one lane.
_clear_record = accumulator(1, RECORD_BEGIN).clear


class RowKernels(NamedTuple):
    """Kernels that write and read rows (n, SLOTS) of points (n, parameters).

    `steps` (n,) are per period; states (n, 3) are (x, v, phi) in SI units.
    """

    fill: Any
    """(points, steps, states, rows): write the rows at phase 0."""

    read_states: Any
    """(points, steps, rows, states): write the states."""

    read_records: Any
    """(points, steps, rows, closed, records): write the records (n, RECORD) in SI units, of orbits
    if `closed`, else of stretches of motion."""


@kernel
def clear_records(rows: np.ndarray, which: np.ndarray) -> None:
    """Clear the records of the rows with the indices `which` (m,) for a new orbit."""
    for i in which:
        _clear_record(rows[i], 0)


@kernel_factory
def row_kernels(physics: Physics) -> RowKernels:
    """Return the kernels for rows of points with these physics."""
    write_parameters = step_reduction(physics.friction)

    def fill(points: np.ndarray, steps: np.ndarray, states: np.ndarray, rows: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p, row = parameters_of(points[i]), rows[i]
            y = (states[i, 0], states[i, 1], states[i, 2])
            row[X], row[V], row[W] = to_lane(step_units(p, steps[i]), y)
            for tone in range(len(_HARMONICS)):
                first = SINE * tone
                row[DRIVE + first], row[CHANGE + first] = 0.0, 0.0  # written at step 0
                # The factor of the second difference is 4 sin^2(angle/2), with the angle of a step.
                half = 2.0 * math.sin(math.pi * _HARMONICS[tone] / steps[i])
                row[TURN + first] = half * half
            write_parameters(p, steps[i], row[PARAMETERS_BEGIN:])
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
            p = parameters_of(points[i])
            units = record_units(p, step_units(p, steps[i]))
            if closed:
                write_whole_orbit(record, units, 2, records[i])  # whole periods
            else:
                write_stretch(record, units, 1, records[i])

    return RowKernels(
        named_kernel(f"fill_rows[{physics}]", fill),
        named_kernel(f"read_states[{physics}]", read_states),
        named_kernel(f"read_records[{physics}]", read_records),
    )
