"""Result rows of settled and measured orbits, with error estimates."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import (
    inline,
    jit,
    jit_making_arrays,
    kernel_factory,
    named_kernel,
)
from stickslip.kernels.orbits.conversion import make_record_units
from stickslip.kernels.orbits.motions import CYCLE, HALVES, OUTCOME, Motions
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.kernels.problem import rounding_speed
from stickslip.measure.accumulate import (
    EXTREMA,
    FORCE_MAX,
    FORCE_MIN,
    FORCE_SIZE,
    INTEGRALS,
    LOSS,
    MELTINGS,
    PHI_MAX,
    RECORD,
    SENSITIVE,
    STRESS_MAX,
    STRESS_MIN,
)
from stickslip.measure.results import (
    Measured,
    RecordUnits,
    halves_of,
    relative_difference,
    write_whole_orbit,
)
from stickslip.measure.window import amplitudes_of
from stickslip.model import film, solids
from stickslip.model.drive import lengthened
from stickslip.model.models import model_of
from stickslip.numerics.adaptive import OK
from stickslip.options import Physics
from stickslip.parameters import Parameters

# For a tolerance cut to a tenth, the error estimate contains these fractions of the difference of
# the two measurements and of the shift of the orbit. The second fraction is larger if a liquid film
# crosses a cusp of the law at full speed. Two measurements may agree by accident, so there is also
# a smallest credible error, in tolerances. It is largest if a film is near its strength or melts,
# as one step more or less changes the time of melting; it is smallest if the equations are smooth
# (docs/decisions/amplitude-error.md).
_DIFFERENCE_PART = 0.15
_SHIFT_PART, _SHIFT_PART_PAST_CUSPS = 0.15, 0.5
_LEAST, _LEAST_AT_CUSP, _LEAST_PAST_CUSPS, _LEAST_OF_FRONTS = 0.0025, 0.01, 0.015, 0.03

# The same numbers for integrals, with the smallest error relative to the integral. The loss needs
# larger ones than amplitudes, because the steps are fitted to the motion and not to the slip by
# which a locked block loses energy: least if a film melts, more if it is liquid and its law has a
# cusp, and most otherwise. Integrals of the motion need less (docs/decisions/work.md).
_DIFFERENCE_PART_OF_INTEGRALS = 1.0
_LEAST_OF_MELTING, _LEAST_OF_SLIDING, _LEAST_OF_OTHERS = 0.05, 0.1, 0.2
_LEAST_OF_MOTION = 0.02

# If the rounding of a cusp determines a slip, the slip may be too large by this many differences,
# since it is a power of the width, with an exponent that may be small. It cannot be too large by
# more than itself.
_ROUNDED_PART = 4.0

# At least this fraction of the smallest error counts even if the amplitudes hardly depend on the
# position, since they depend on other variables too.
_WELL_CONDITIONED = 0.5

# Above this fraction of a phi_plus^2 eps_c0 a stress is near the strength, which is 0.4 times it.
_NEAR_STRENGTH = 0.25

# Measurements that differ by more than this many tolerances did not begin on the same orbit.
_APART = 0.3

# The error if the slopes for its estimate are unknown.
_UNKNOWN = 1.0


class Orbits(NamedTuple):
    """Properties of n settled orbits other than their finer measurement.

    `begins` (n, width + 1) are states on the orbits, in their own units; `coarse` (n, RECORD) is
    the measurement at the coarser tolerance; `symmetric` (n,); `spreads` (n, 2) of stress and force
    in SI units; `multipliers` (n,); `slopes` (n, SENSITIVE, width) are derivatives of extrema and
    integrals with respect to the first state. `missed` (n, width) is the failure of the finer cycle
    to close, weighted as in the test of repetition. `offsets` (n, width) of the state from the
    orbit are NaN if it left the orbit. `shifts` (n, width) are the changes of the orbit between the
    two tolerances. Both are a cycle later, when fast transients have decayed.
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


@jit_making_arrays
def _error_of_displacement(
    p: Parameters,
    measured: np.ndarray,
    record: np.ndarray,
    slopes: np.ndarray,
    displacement: np.ndarray,
    units: RecordUnits,
    cycle: int,
    changes: np.ndarray,
) -> float:
    """Error of the amplitudes due to this displacement (width,) of the first state.

    It is infinite if the displacement or the slopes are unknown, since `max` would drop a NaN.
    `measured` (RECORD,) is as in the lanes, `record` (RECORD,) of the whole orbit. The `changes`
    (INTEGRALS,) of its integrals are output.
    """
    away, moved, total = measured.copy(), np.empty(RECORD), 0.0
    for k in range(len(SENSITIVE)):
        change = 0.0
        for component in range(len(displacement)):
            change += abs(slopes[k, component] * displacement[component])
        # Maxima and minima alternate. Both move outwards, so that no errors cancel.
        away[SENSITIVE[k]] += -change if k < len(EXTREMA) and k % 2 == 1 else change
        total += change
    changes[:] = math.inf
    if not math.isfinite(total):
        return math.inf
    write_whole_orbit(away, units, cycle, moved)
    for k in range(len(INTEGRALS)):
        changes[k] = abs(moved[INTEGRALS[k]] - record[INTEGRALS[k]])
    return relative_difference(p, moved, record)


@inline
def _near_strength(p: Parameters, record: np.ndarray) -> bool:
    """Return whether the stress comes near the strength of the film."""
    stress = max(record[STRESS_MAX], -record[STRESS_MIN])
    stiffest = film.shear_modulus(p, solids.largest_order_parameter(p)) * solids.melting_strain(p)
    return stress > _NEAR_STRENGTH * stiffest


@jit
def _parts_of_error(p: Parameters, record: np.ndarray, cusped: bool) -> tuple[float, float]:
    """Fraction of the shift between the tolerances that counts, and the smallest error."""
    liquid = record[PHI_MAX] < solids.solid_threshold(p)
    if record[MELTINGS] > 0.0 or (not liquid and _near_strength(p, record)):
        return _SHIFT_PART, _LEAST_OF_FRONTS
    if not cusped:
        return _SHIFT_PART, _LEAST
    return (_SHIFT_PART_PAST_CUSPS, _LEAST_PAST_CUSPS) if liquid else (_SHIFT_PART, _LEAST_AT_CUSP)


@inline
def _least_of_loss(p: Parameters, record: np.ndarray, cusped: bool) -> float:
    """Smallest error of the loss, in tolerances."""
    if record[MELTINGS] > 0.0:
        return _LEAST_OF_MELTING
    liquid = record[PHI_MAX] < solids.solid_threshold(p)
    return _LEAST_OF_SLIDING if liquid and cusped else _LEAST_OF_OTHERS


@inline
def _is_rounded(p: Parameters, record: np.ndarray, cycle: int, rtol: float) -> bool:
    """Return whether the mean slip is below the speed at which a cusp of the law is rounded."""
    duration = halves_of(cycle) * (math.pi / p.angular_frequency)
    force = 0.5 * (record[FORCE_MAX] - record[FORCE_MIN])
    return record[LOSS] < force * duration * rounding_speed(p, rtol)


@jit
def _write_uncertainties(
    record: np.ndarray,
    other: np.ndarray,
    changes: np.ndarray,
    rtol: float,
    least_of_loss: float,
    rounded: bool,
    target: np.ndarray,
) -> None:
    """Write the errors of the integrals of a `record` (RECORD,) into their slots of `target`.

    `other` (RECORD,) is the coarser record. `changes` (3, INTEGRALS) are due to a tolerance in the
    position, to the part of the orbit's shift that counts, and to the offset from the orbit.
    """
    for k in range(len(INTEGRALS)):
        slot = INTEGRALS[k]
        scale = record[LOSS] if slot == LOSS else record[FORCE_SIZE]
        difference = abs(other[slot] - record[slot])
        error = _DIFFERENCE_PART_OF_INTEGRALS * difference
        if rounded and slot == LOSS:
            error = max(error, min(_ROUNDED_PART * difference, scale))
        least = least_of_loss if slot == LOSS else _LEAST_OF_MOTION
        error += least * max(changes[0, k], rtol * scale)
        target[slot] = error + changes[1, k] + changes[2, k]


class RowKernels(NamedTuple):
    """The kernels of a model; `points` (n, parameters) in SI units.

    `longer` are the `lengthened` points, `motions` the state after the finer measurement of the
    `orbits`, and `rtol` is the coarser tolerance.
    """

    write_off_the_orbit: Any
    """(points, longer, motions, orbits, rtol, off): write which measurements (n,) began too far off
    the orbit. The criteria are the change of the extrema with the offset and, if no melting blurs
    it, the difference of the two measurements."""

    write_errors: Any
    """(points, longer, motions, orbits, rtol, records, errors, uncertainties): write the records
    (n, RECORD) of whole orbits in SI units, the errors (n,) of their amplitudes, and the errors
    (n, RECORD) of their integrals."""


def row_kernels(physics: Physics) -> RowKernels:
    """Return the kernels of these physics, which typical and stochastic noise share."""
    return _row_kernels(physics.typical)


@kernel_factory
def _row_kernels(physics: Physics) -> RowKernels:
    model = model_of(physics)
    width, own_units = model.width, make_record_units(model)
    has_cusp = model.equations.law.has_cusp

    def write_off_the_orbit(
        points: np.ndarray,
        longer: np.ndarray,
        motions: Motions,
        orbits: Orbits,
        rtol: float,
        off: np.ndarray,
    ) -> None:
        record, other, changes = np.empty(RECORD), np.empty(RECORD), np.empty(len(INTEGRALS))
        for i in range(points.shape[0]):
            if motions.counts[i, OUTCOME] == OK:
                p, cycle = parameters_of(points[i]), motions.counts[i, CYCLE]
                fine = motions.measured[i]
                own = own_units(parameters_of(longer[i]))
                write_whole_orbit(fine, own, cycle, record)
                write_whole_orbit(orbits.coarse[i], own, cycle, other)
                slopes, offset = orbits.slopes[i], orbits.offsets[i]
                error = _error_of_displacement(p, fine, record, slopes, offset, own, cycle, changes)
                # The time of a melting depends on the steps, which blurs the difference.
                solid = record[MELTINGS] == 0.0
                differ = solid and relative_difference(p, other, record) > _APART * rtol
                off[i] = differ or error > rtol

    def write_errors(
        points: np.ndarray,
        longer: np.ndarray,
        motions: Motions,
        orbits: Orbits,
        rtol: float,
        records: np.ndarray,
        errors: np.ndarray,
        uncertainties: np.ndarray,
    ) -> None:
        other, astray, changes = np.empty(RECORD), np.zeros(width), np.empty((3, len(INTEGRALS)))
        for i in range(points.shape[0]):
            if motions.counts[i, OUTCOME] != OK:
                continue
            p, cycle, record = parameters_of(points[i]), motions.counts[i, CYCLE], records[i]
            own = own_units(parameters_of(longer[i]))
            write_whole_orbit(motions.measured[i], own, cycle, record)
            write_whole_orbit(orbits.coarse[i], own, cycle, other)
            cusped = has_cusp(p)
            shift_part, least = _parts_of_error(p, record, cusped)
            fine, slopes = motions.measured[i], orbits.slopes[i]
            error = _DIFFERENCE_PART * relative_difference(p, other, record)
            # The smallest error is an error of the position, which near resonance changes the force
            # by hundreds of times as much.
            astray[:] = 0.0
            astray[0] = least * rtol
            lost = _error_of_displacement(p, fine, record, slopes, astray, own, cycle, changes[0])
            error += max(lost, _WELL_CONDITIONED * least * rtol)
            error += shift_part * _error_of_displacement(
                p, fine, record, slopes, orbits.shifts[i], own, cycle, changes[1]
            )
            error += _error_of_displacement(
                p, fine, record, slopes, orbits.offsets[i], own, cycle, changes[2]
            )
            errors[i] = error if math.isfinite(error) else _UNKNOWN
            changes[0] /= least
            changes[1] *= shift_part
            least_of_loss = _least_of_loss(p, record, cusped)
            rounded = cusped and _is_rounded(p, record, cycle, rtol)
            _write_uncertainties(
                record, other, changes, rtol, least_of_loss, rounded, uncertainties[i]
            )

    kernels = (write_off_the_orbit, write_errors)
    return RowKernels(
        *(named_kernel(f"{k.__name__}[{physics}]", k, makes_arrays=True) for k in kernels)
    )


def measured_of(
    points: np.ndarray,
    motions: Motions,
    orbits: Orbits,
    begins: np.ndarray,
    ends: np.ndarray,
    rtol: float,
    physics: Physics,
) -> Measured:
    """Return the contents of the result rows of points, whether they settled or not.

    `begins` and `ends` (n, width + 1) are the states (x, v, psi, ...) before and after the finer
    measurement, in SI units; the other arguments are as in `RowKernels`.
    """
    n, halves, cycles = len(points), motions.counts[:, HALVES], motions.counts[:, CYCLE]
    statuses, errors = motions.counts[:, OUTCOME], np.zeros(n)
    records, uncertainties = np.zeros((n, RECORD)), np.zeros((n, RECORD))
    row_kernels(physics).write_errors(
        points, lengthened(points), motions, orbits, rtol, records, errors, uncertainties
    )
    return Measured(
        records=records,
        uncertainties=uncertainties,
        cycles=cycles,
        begins=begins,
        ends=ends,
        symmetric=orbits.symmetric,
        amplitudes=amplitudes_of(records),
        errors=errors,
        spreads=orbits.spreads,
        multipliers=orbits.multipliers,
        exponents=np.full(n, np.nan),
        periods=(halves + np.where(statuses == OK, cycles, 0) + 1) // 2,
        statuses=statuses,
    )
