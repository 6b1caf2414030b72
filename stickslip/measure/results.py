"""The result row of a stationary orbit, from its record, for all methods.

Everything here is in SI units and for the whole orbit. `cycle` counts half periods. If a motion
repeats after an odd number of them, it does so with opposite signs, so that a method need not
compute the second half of the orbit; `write_whole_orbit` adds it.
"""

from __future__ import annotations

import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FIRST_PHASE,
    FIRST_SOLID,
    FORCE_MAX,
    FORCE_MIN,
    FORCE_SIZE,
    HIGHEST,
    IN_PHASE,
    LAST_PHASE,
    LAST_SOLID,
    LOSS,
    MELTED,
    MELTINGS,
    MOTION_IN_PHASE,
    MOTION_OUT_OF_PHASE,
    OUT_OF_PHASE,
    PHI_MAX,
    RECORD,
    RECORD_TABLE,
    SOFT,
    SOLID,
    SOLID_CHANGES,
    SOLID_TIME,
    SQUARED_FORCE,
    STRESS_MAX,
    STRESS_MIN,
    SUM,
    UNSEEN_TIME,
    slots_of,
)
from stickslip.model import block, drive, film, noise, solids
from stickslip.model.rhs import starting_state
from stickslip.model.scaling import Units
from stickslip.parameters import Parameters
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS

OK, DIVERGED, APERIODIC = int(Status.OK), int(Status.DIVERGED), int(Status.APERIODIC)
INVARIANT_VIOLATED = int(Status.INVARIANT_VIOLATED)

STATUS = RESULT_COLUMNS.index("status")
_PERIODS = RESULT_COLUMNS.index("periods_integrated")
_MISSING = tuple(float(RESULTS[name].missing) for name in RESULT_COLUMNS)

_LIQUID, _LOCKED = int(Regime.LIQUID), int(Regime.LOCKED)
_SYMMETRIC, _ASYMMETRIC = int(Regime.STICK_SLIP_SYMMETRIC), int(Regime.STICK_SLIP_ASYMMETRIC)
_SUBHARMONIC, _APERIODIC = int(Regime.SUBHARMONIC), int(Regime.APERIODIC)

# An orbit with a larger power balance error is rejected.
_POWER_BALANCE_LIMIT = 1e-2

# The scale of errors of amplitudes and of the power balance is at least this fraction of the scale
# of the full force. The work of a vanishing force is rounding error, and near melting the stress is
# a meaningless scale.
_SMALL_PART = 0.01

# The order parameter may exceed its bound by this factor, through rounding and integration errors.
_BOUND_MARGIN = 1.001

full_force = drive.full_force
"""(p): the scale for small forces [N]."""

_UNIT = tuple(slot.unit for slot in RECORD_TABLE)
_IS_SUM = tuple(slot.reducer == SUM for slot in RECORD_TABLE)
_HIGHEST = slots_of(HIGHEST)

if TYPE_CHECKING:
    ResultRow = Any
else:
    # Keywords without defaults: code that leaves out a column does not compile.
    ResultRow = namedtuple("ResultRow", RESULT_COLUMNS, module=__name__)


class RecordUnits(NamedTuple):
    """The units of a record in SI; the units of stress, force and length change sign with X_m.

    The unit of time is in half periods of the drive.
    """

    length: float
    stress: float
    force: float
    time: float


@inline
def record_units(p: Parameters, units: Units) -> RecordUnits:
    """Return the units of a record in the units of a point."""
    halves = units.time * p.angular_frequency / math.pi
    return RecordUnits(units.length, units.stress, units.force, halves)


@inline
def slot_units(units: RecordUnits) -> tuple[float, ...]:
    """Return the SI units of the kinds of slots, in the order of `accumulate.STRESS`, ..."""
    work, impulse = units.force * units.length, units.force * units.time
    square = units.force * impulse
    return (
        units.stress, units.force, work, units.time, 1.0, impulse, abs(impulse), square
    )  # fmt: skip


class Measured(NamedTuple):
    """Everything that determines the result rows of n motions.

    `records` (n, RECORD) describe whole orbits in SI units. `uncertainties` (n, RECORD) are the
    errors of their INTEGRALS, NaN if unknown, and 0 in other slots. `cycles` (n,) are the half
    periods after which the motions repeat; `begins` and `ends` (n, 2 or more) are the states (x, v,
    ...) before and after these. `symmetric` (n,) says whether a motion is its own mirror image half
    a period later. `amplitudes` (n, 2) belong to stress and force, with `errors` (n,) and
    `spreads` (n, 2) among single drive periods. `multipliers` (n,) are Floquet multipliers,
    `exponents` (n,) Lyapunov exponents, NaN for closed orbits; `periods` (n,) counts the integrated
    drive periods. If a status in `statuses` (n,) is neither OK nor APERIODIC, only the status and
    the periods matter.
    """

    records: np.ndarray
    uncertainties: np.ndarray
    cycles: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    symmetric: np.ndarray
    amplitudes: np.ndarray
    errors: np.ndarray
    spreads: np.ndarray
    multipliers: np.ndarray
    exponents: np.ndarray
    periods: np.ndarray
    statuses: np.ndarray


@inline
def _passes(cycle: int) -> int:
    """Number of repetitions of a cycle of half periods until the orbit closes."""
    return 2 if cycle % 2 == 1 else 1


@inline
def halves_of(cycle: int) -> int:
    """Number of half periods after which an orbit with this cycle closes."""
    return cycle * _passes(cycle)


@jit
def write_whole_orbit(
    record: np.ndarray, units: RecordUnits, cycle: int, target: np.ndarray
) -> None:
    """Write the record (RECORD,) of a whole orbit, in SI units, from `cycle` half periods of it.

    It is written into `target` (RECORD,), with times in half periods.
    """
    write_stretch(record, units, _passes(cycle), target)
    target[MELTINGS] = _passes(cycle) * _melting_count(record)
    target[SOLID_CHANGES] = _passes(cycle) * _solid_changes(record)
    if record[LAST_PHASE] == SOLID:  # the orbit begins in the phase in which it ends
        target[SOLID_TIME] += target[UNSEEN_TIME]
        target[UNSEEN_TIME] = 0.0


@jit
def write_stretch(record: np.ndarray, units: RecordUnits, passes: int, target: np.ndarray) -> None:
    """Convert the record (RECORD,) of a stretch of motion to SI units.

    `passes` is 2 if the mirror image of the stretch follows, else 1. The result is written into
    `target` (RECORD,), with times in half periods.
    """
    unit = slot_units(units)
    for slot in range(RECORD):
        times = passes if _IS_SUM[slot] else 1
        target[slot] = times * (record[slot] * unit[_UNIT[slot]])
    for slot in _HIGHEST:
        one, other = target[slot], target[slot + 1]
        high, low = max(one, other), min(one, other)
        if passes == 2:
            high = max(high, -low)
            low = -high
        target[slot], target[slot + 1] = high, low


@jit
def _melting_count(record: np.ndarray) -> float:
    """Number of meltings, counted cyclically."""
    wrapped = record[LAST_PHASE] == SOLID and record[FIRST_PHASE] == MELTED
    return record[MELTINGS] + (1.0 if wrapped else 0.0)


@jit
def _solid_changes(record: np.ndarray) -> float:
    """Number of changes between a soft and a hard solid, counted cyclically."""
    first, last = record[FIRST_SOLID], record[LAST_SOLID]
    wrapped = first != last and first >= SOFT and last >= SOFT
    return record[SOLID_CHANGES] + (1.0 if wrapped else 0.0)


@jit
def relative_difference(p: Parameters, record: np.ndarray, better: np.ndarray) -> float:
    """Relative difference of the extrema of two orbits, of stress or force, whichever is larger.

    It is the sum of the differences of maximum and minimum over max(amplitude, 1 % of the full
    force, divided by A for the stress). It is at least twice the difference of the amplitudes.
    """
    floor, worst = _SMALL_PART * full_force(p), 0.0
    for slot, least in ((STRESS_MAX, floor / p.contact_area), (FORCE_MAX, floor)):
        high, low = record[slot], record[slot + 1]
        better_high, better_low = better[slot], better[slot + 1]
        scale = max(0.5 * (better_high - better_low), least)
        difference = abs(high - better_high) + abs(low - better_low)
        worst = max(worst, difference / scale if scale > 0.0 else 0.0)
    return worst


@inline
def _halves(m: Measured, i: int) -> int:
    """Number of half periods of the whole orbit, or of the window of an aperiodic one."""
    return halves_of(m.cycles[i])


@inline
def _gained_energy(p: Parameters, m: Measured, i: int) -> float:
    """Energy that the block gains from the beginning to the end [J]."""
    begin = block.energy(p, m.begins[i, 0], m.begins[i, 1])
    end = block.energy(p, m.ends[i, 0], m.ends[i, 1])
    return _passes(m.cycles[i]) * (end - begin)


@jit
def _work_of_drive(p: Parameters, m: Measured, i: int) -> tuple[float, float]:
    """Work of the drive per drive period, and its error [J].

    The recorded work on the block is not used, because it nearly cancels: the gained energy takes
    its place. On a closed orbit that is 0, and its measured value is just the closure error, which
    can exceed the loss of a locked block.
    """
    periods = 0.5 * _halves(m, i)
    work, error = m.records[i, LOSS], m.uncertainties[i, LOSS]
    if m.statuses[i] == APERIODIC:
        gained = _gained_energy(p, m, i)
        work += gained
        error += abs(gained - m.records[i, BLOCK_WORK])  # without errors both are the same
    if not math.isfinite(error):
        error = abs(work) + m.records[i, ABSOLUTE_WORK]  # an upper bound
    return work / periods, error / periods


@jit
def _harmonic(
    p: Parameters, m: Measured, i: int, work: float, work_error: float
) -> tuple[float, float, float, float]:
    """First harmonic of the force, in phase and out of phase with the drive, each with its error.

    For a closed orbit it follows from the motion of the block. Under a single cosine the work per
    period is pi |X_m| times the part out of phase, which therefore follows from the work, where
    nothing cancels.
    """
    # The first Fourier coefficients are twice the means; the drive is a cosine, or its negative.
    twice, most = math.copysign(2.0, p.drive_amplitude), 2.0 * _mean(m, i, FORCE_SIZE)
    in_phase, out_of_phase = MOTION_IN_PHASE, MOTION_OUT_OF_PHASE
    if m.statuses[i] == APERIODIC:
        in_phase, out_of_phase = IN_PHASE, OUT_OF_PHASE
    along, along_error = twice * _mean(m, i, in_phase), 2.0 * _mean_error(m, i, in_phase)
    across, across_error = twice * _mean(m, i, out_of_phase), 2.0 * _mean_error(m, i, out_of_phase)
    if drive.highest_harmonic(p) == 1.0:
        way = math.pi * abs(p.drive_amplitude)
        across, across_error = work / way, work_error / way
    # No coefficient exceeds twice the mean of |F|.
    if not math.isfinite(along_error):
        along_error = abs(along) + most
    if not math.isfinite(across_error):
        across_error = abs(across) + most
    return along, along_error, across, across_error


@jit
def _power_balance(p: Parameters, m: Measured, i: int) -> tuple[float, bool]:
    """Power balance error, and whether it is small enough to accept the orbit.

    It is |work of the drive - dissipation - gained energy| over the integral of |F V|. The
    dissipation is the integral of F (V - v), so that the first two differ by the work on the block.
    """
    absolute = m.records[i, ABSOLUTE_WORK]
    miss = abs(m.records[i, BLOCK_WORK] - _gained_energy(p, m, i))
    way = 2.0 * drive.half_way(p) * _halves(m, i)
    least = _SMALL_PART * full_force(p) * way
    kept = miss <= _POWER_BALANCE_LIMIT * max(absolute, least)
    return miss / absolute if absolute > 0.0 else 0.0, kept


@jit
def _bounds_kept(p: Parameters, m: Measured, i: int) -> bool:
    """Return whether the order parameter stayed below the bound that only noise can exceed."""
    start, phi = math.exp(starting_state(p)[2]), m.records[i, PHI_MAX]
    bound = max(solids.largest_order_parameter(p), start) * _BOUND_MARGIN
    return phi <= bound or noise.may_reach(p, phi, bound)


@inline
def _asymmetry(high: float, low: float) -> float:
    """|max + min|/(max - min) of the elastic stress; 0 if max - min < 1 Pa."""
    return abs(high + low) / (high - low) if high - low >= 1.0 else 0.0


@jit
def _solid_fraction(p: Parameters, m: Measured, i: int) -> float:
    """Fraction of the time in the solid phase.

    Without a cubic term the threshold may be 0, which every film exceeds, even a liquid one above
    T_c, or one that temperature does not freeze.
    """
    if solids.solid_threshold(p) == 0.0 and film.heating(p) >= 0.0:
        return 0.0
    return min(m.records[i, SOLID_TIME] / _halves(m, i), 1.0)


@inline
def _periods(m: Measured, i: int) -> int:
    """Number of drive periods after which the orbit closes; 0 if it never closes."""
    return 0 if m.statuses[i] == APERIODIC else _halves(m, i) // 2


@jit
def _regime(p: Parameters, m: Measured, i: int) -> int:
    """Kind of motion, a `Regime`."""
    if m.statuses[i] == APERIODIC:
        return _APERIODIC
    if _periods(m, i) > 1:
        return _SUBHARMONIC
    if m.records[i, MELTINGS] == 0.0:
        return _LOCKED if _solid_fraction(p, m, i) > 0.0 else _LIQUID
    return _SYMMETRIC if m.symmetric[i] else _ASYMMETRIC


@inline
def _mean(m: Measured, i: int, slot: int) -> float:
    """Mean over the orbit of the integrand of a slot; times are in half periods."""
    return m.records[i, slot] / _halves(m, i)


@inline
def _mean_error(m: Measured, i: int, slot: int) -> float:
    """Error of `_mean`."""
    return m.uncertainties[i, slot] / _halves(m, i)


@jit
def _result_row(p: Parameters, m: Measured, i: int) -> tuple[ResultRow, bool]:
    """Result row of an orbit, and whether its invariants hold."""
    high, low = m.records[i, STRESS_MAX], m.records[i, STRESS_MIN]
    force_high, force_low = m.records[i, FORCE_MAX], m.records[i, FORCE_MIN]
    balance, balance_kept = _power_balance(p, m, i)
    work, work_error = _work_of_drive(p, m, i)
    in_phase, in_phase_error, out_of_phase, out_of_phase_error = _harmonic(
        p, m, i, work, work_error
    )
    # Functions replace conditionals, which Numba forbids among more than fifteen keywords.
    row = ResultRow(
        elastic_stress_amplitude=m.amplitudes[i, 0],
        friction_force_amplitude=m.amplitudes[i, 1],
        elastic_stress_max=high,
        elastic_stress_min=low,
        friction_force_max=force_high,
        friction_force_min=force_low,
        dissipated_energy=work,
        dissipated_energy_error=work_error,
        amplitude_error=m.errors[i],
        power_balance_error=balance,
        orbit_periods=float(_periods(m, i)),
        melting_count=m.records[i, MELTINGS],
        solid_transition_count=m.records[i, SOLID_CHANGES],
        asymmetry=_asymmetry(high, low),
        periods_integrated=float(m.periods[i]),
        solid_fraction=_solid_fraction(p, m, i),
        regime=float(_regime(p, m, i)),
        floquet_multiplier=m.multipliers[i],
        lyapunov_exponent=m.exponents[i],
        elastic_stress_amplitude_spread=m.spreads[i, 0],
        friction_force_amplitude_spread=m.spreads[i, 1],
        friction_force_in_phase=in_phase,
        friction_force_in_phase_error=in_phase_error,
        friction_force_out_of_phase=out_of_phase,
        friction_force_out_of_phase_error=out_of_phase_error,
        friction_force_rms=math.sqrt(_mean(m, i, SQUARED_FORCE)),
        friction_force_mean_abs=_mean(m, i, FORCE_SIZE),
        status=float(m.statuses[i]),
    )
    return row, balance_kept and _bounds_kept(p, m, i)


@jit
def write_result(p: Parameters, m: Measured, i: int, result: np.ndarray) -> None:
    """Write the result row of motion `i`, or a failure row if the motion is not trusted.

    `result` (columns,) is in the order of `RESULT_COLUMNS`. Its status comes from `m`, or is
    DIVERGED or INVARIANT_VIOLATED.
    """
    if m.statuses[i] != OK and m.statuses[i] != APERIODIC:
        write_failure(result, m.periods[i], m.statuses[i])
        return
    row, believed = _result_row(p, m, i)
    if not math.isfinite(
        row.elastic_stress_amplitude + row.friction_force_amplitude + row.amplitude_error
    ):
        write_failure(result, m.periods[i], DIVERGED)
    elif not believed:
        write_failure(result, m.periods[i], INVARIANT_VIOLATED)
    else:
        for column in range(len(row)):
            result[column] = row[column]


@jit
def write_failure(result: np.ndarray, periods: int, status: int) -> None:
    """Write the result row (columns,) of a point without a result."""
    for column in range(len(_MISSING)):
        result[column] = _MISSING[column]
    result[_PERIODS], result[STATUS] = periods, status
