"""From orbits that were settled and measured to their result rows, errors estimated."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel_factory, named_kernel
from stickslip.kernels.adaptive.conversion import make_record_units
from stickslip.kernels.adaptive.passes import CYCLE, HALVES, OUTCOME, Queue
from stickslip.kernels.points import parameters_of
from stickslip.measure.accumulate import (
    EXTREMA,
    MELTINGS,
    PHI_MAX,
    RECORD,
    STRESS_MAX,
    STRESS_MIN,
)
from stickslip.measure.results import (
    Measured,
    RecordUnits,
    amplitudes_of,
    relative_difference,
    write_failure,
    write_result,
    write_whole_orbit,
)
from stickslip.model import film, solids
from stickslip.model.models import model_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Physics
from stickslip.parameters import Parameters

# The error estimate: what is left, after a cut of the tolerance to a tenth, of the difference of
# the two measurements and of the shift of the orbit; more of the latter where a liquid film runs
# through a cusp of the law at full speed. And the least error that is believed, in tolerances,
# since two measurements may agree by accident: the most where a film melts, which a step more or
# less moves, or is near its strength, the least where the equations are smooth
# (docs/decisions/amplitude-error.md).
_DIFFERENCE_PART = 0.15
_SHIFT_PART, _SHIFT_PART_PAST_CUSPS = 0.15, 0.5
_LEAST, _LEAST_AT_CUSP, _LEAST_PAST_CUSPS, _LEAST_OF_FRONTS = 0.0025, 0.01, 0.015, 0.03

# Films whose amplitudes feel the position least do not feel it alone.
_WELL_CONDITIONED = 0.5

# From this part of a phi_plus^2 eps_c0 on a stress is near the strength, which is 0.4 of that.
_NEAR_STRENGTH = 0.25

# Measurements that differ by more tolerances than this do not begin on the same orbit.
_APART = 0.3

# The error where the copies were lost that would tell it.
_UNKNOWN = 1.0


class Orbits(NamedTuple):
    """What is known of n settled orbits besides their finer measurement.

    `begins` (n, width + 1) states on them, in units of their own; `coarse` (n, RECORD) at the
    coarser tolerance; `symmetric` (n,); `spreads` (n, 2) of stress and force in SI units;
    `multipliers` (n,); `slopes` (n, EXTREMA, width) of the extrema over the state at the begin;
    `missed` (n, width), by how much the finer cycle fails to close, as repetition is judged;
    `offsets` (n, width) of the state from the orbit, NaN where it left it, and `shifts` (n, width)
    of the orbit between the two tolerances, both a cycle later, when what is fast has been
    forgotten.
    """

    begins: np.ndarray
    coarse: np.ndarray
    symmetric: np.ndarray
    spreads: np.ndarray
    multipliers: np.ndarray
    slopes: np.ndarray
    missed: np.ndarray
    offsets: np.ndarray
    shifts: np.ndarray


@jit
def _error_of_displacement(
    p: Parameters,
    measured: np.ndarray,
    record: np.ndarray,
    slopes: np.ndarray,
    displacement: np.ndarray,
    units: RecordUnits,
    cycle: int,
) -> float:
    """The error of the amplitudes where the state at the begin is off by this (width,).

    Infinite where that or the slopes are not known: `max` would drop the NaN. `measured` (RECORD,)
    as it is in lanes, and its `record` (RECORD,) of the whole orbit.
    """
    away, moved, total = measured.copy(), np.empty(RECORD), 0.0
    for k in range(len(EXTREMA)):
        change = 0.0
        for component in range(len(displacement)):
            change += abs(slopes[k, component] * displacement[component])
        away[EXTREMA[k]] += change if k % 2 == 0 else -change
        total += change
    if not math.isfinite(total):
        return math.inf
    write_whole_orbit(away, units, cycle, moved)
    return relative_difference(p, moved, record)


@inline
def _near_strength(p: Parameters, record: np.ndarray) -> bool:
    """Whether the stress comes near the strength of the film."""
    stress = max(record[STRESS_MAX], -record[STRESS_MIN])
    stiffest = film.shear_modulus(p, solids.largest_order_parameter(p)) * solids.melting_strain(p)
    return stress > _NEAR_STRENGTH * stiffest


@jit
def _parts_of_error(p: Parameters, record: np.ndarray, cusped: bool) -> tuple[float, float]:
    """The part of the shift between the tolerances that counts, and the least error."""
    liquid = record[PHI_MAX] < solids.solid_threshold(p)
    if record[MELTINGS] > 0.0 or (not liquid and _near_strength(p, record)):
        return _SHIFT_PART, _LEAST_OF_FRONTS
    if not cusped:
        return _SHIFT_PART, _LEAST
    return (_SHIFT_PART_PAST_CUSPS, _LEAST_PAST_CUSPS) if liquid else (_SHIFT_PART, _LEAST_AT_CUSP)


class RowKernels(NamedTuple):
    """The kernels of a model; `points` (n, parameters) in SI units.

    The `queue` is that after the finer measurement of the `orbits`, `rtol` the coarser tolerance.
    """

    write_off_the_orbit: Any
    """(points, queue, orbits, rtol, off): write which measurements (n,) began off the orbit by more
    than the tolerance, by what an offset makes of the extrema or, where no front blurs the two
    measurements, by their difference."""

    write_results: Any
    """(points, queue, orbits, rtol, results): write the result rows (n, columns) of points that
    were settled and measured twice."""


def row_kernels(physics: Physics) -> RowKernels:
    """The kernels of these physics: the same whether the noise is a typical path or random."""
    return _row_kernels(physics.typical)


@kernel_factory
def _row_kernels(physics: Physics) -> RowKernels:
    model = model_of(physics)
    units_of, width, own_units = model.scaling.units_of, model.width, make_record_units(model)
    has_cusp = model.equations.law.has_cusp

    def write_off_the_orbit(
        points: np.ndarray, queue: Queue, orbits: Orbits, rtol: float, off: np.ndarray
    ) -> None:
        record, other = np.empty(RECORD), np.empty(RECORD)
        for i in range(points.shape[0]):
            if queue.counts[i, OUTCOME] == OK:
                p, cycle, fine = parameters_of(points[i]), queue.counts[i, CYCLE], queue.measured[i]
                own = own_units(p)
                write_whole_orbit(fine, own, cycle, record)
                write_whole_orbit(orbits.coarse[i], own, cycle, other)
                slopes, offset = orbits.slopes[i], orbits.offsets[i]
                error = _error_of_displacement(p, fine, record, slopes, offset, own, cycle)
                solid = record[MELTINGS] == 0.0
                differ = solid and relative_difference(p, other, record) > _APART * rtol
                off[i] = differ or error > rtol

    def write_results(
        points: np.ndarray, queue: Queue, orbits: Orbits, rtol: float, results: np.ndarray
    ) -> None:
        record, other = np.empty(RECORD), np.empty(RECORD)
        astray = np.zeros(width)
        for i in range(points.shape[0]):
            counts, cycle = queue.counts[i], queue.counts[i, CYCLE]
            if counts[OUTCOME] != OK:
                write_failure(results[i], (counts[HALVES] + 1) // 2, counts[OUTCOME])
                continue
            p, begin, end = parameters_of(points[i]), orbits.begins[i], queue.states[i]
            units, own = units_of(p), own_units(p)
            write_whole_orbit(queue.measured[i], own, cycle, record)
            write_whole_orbit(orbits.coarse[i], own, cycle, other)
            shift_part, least = _parts_of_error(p, record, has_cusp(p))
            fine, slopes = queue.measured[i], orbits.slopes[i]
            error = _DIFFERENCE_PART * relative_difference(p, other, record)
            # As much of the position: the force of a block near resonance is hundreds of times as
            # much off.
            astray[:] = 0.0
            astray[0] = least * rtol
            lost = _error_of_displacement(p, fine, record, slopes, astray, own, cycle)
            error += max(lost, _WELL_CONDITIONED * least * rtol)
            error += shift_part * _error_of_displacement(
                p, fine, record, slopes, orbits.shifts[i], own, cycle
            )
            error += _error_of_displacement(p, fine, record, slopes, orbits.offsets[i], own, cycle)
            measured = Measured(
                record=record,
                cycle=cycle,
                # At phase 0 the drive stands still: v = -u.
                begin=(begin[0] * units.length, -begin[1] * units.speed),
                end=(end[0] * units.length, -end[1] * units.speed),
                symmetric=orbits.symmetric[i],
                amplitudes=amplitudes_of(record),
                error=error if math.isfinite(error) else _UNKNOWN,
                spreads=(orbits.spreads[i, 0], orbits.spreads[i, 1]),
                multiplier=orbits.multipliers[i],
                exponent=np.nan,
                periods=(counts[HALVES] + cycle + 1) // 2,
                status=OK,
            )
            write_result(p, measured, results[i])

    kernels = (write_off_the_orbit, write_results)
    return RowKernels(*(named_kernel(f"{k.__name__}[{physics}]", k) for k in kernels))
