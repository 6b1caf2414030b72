"""From the record of a stationary orbit to its result row: one copy for all methods.

Everything is in SI units here, and of the whole orbit. `cycle` counts half periods: an orbit that
closes after an odd number of them repeats those with the signs turned, and a method need not go
twice; `write_whole_orbit` makes up for that.
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
    HIGHEST,
    LAST_PHASE,
    LAST_SOLID,
    MELTED,
    MELTINGS,
    PHI_MAX,
    RECORD,
    RECORD_TABLE,
    SOFT,
    SOLID,
    SOLID_CHANGES,
    SOLID_TIME,
    STRESS_MAX,
    STRESS_MIN,
    SUM,
    UNSEEN_TIME,
    slots_of,
)
from stickslip.model import block, noise, solids
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

# Power balance error beyond which an orbit is not believed.
_POWER_BALANCE_LIMIT = 1e-2

# Errors, of amplitudes and of the power balance, count against at least this part of what the full
# force would make: where the force vanishes, its work is rounding, and near melting the
# stress itself is a meaningless yardstick.
_SMALL_PART = 0.01

# The bound of the order parameter is left by rounding and by the error of the integration.
_BOUND_MARGIN = 1.001

_UNIT = tuple(slot.unit for slot in RECORD_TABLE)
_IS_SUM = tuple(slot.reducer == SUM for slot in RECORD_TABLE)
_HIGHEST = slots_of(HIGHEST)

if TYPE_CHECKING:
    ResultRow = Any
else:
    # By keyword and without defaults: a column that is not computed does not compile.
    ResultRow = namedtuple("ResultRow", RESULT_COLUMNS, module=__name__)


class RecordUnits(NamedTuple):
    """What one unit of a record is in SI units; stress, force and length change sign with X_m.

    Times are written in half periods of the drive: one unit of `time` is so many of them.
    """

    length: float
    stress: float
    force: float
    time: float


@inline
def record_units(p: Parameters, units: Units) -> RecordUnits:
    """The units of a record that is kept in units of a point's own."""
    halves = units.time * p.angular_frequency / math.pi
    return RecordUnits(units.length, units.stress, units.force, halves)


@inline
def slot_units(units: RecordUnits) -> tuple[float, ...]:
    """What one unit of each kind of slot is in SI units, in the order of `accumulate.STRESS`..."""
    work = units.force * units.length
    return units.stress, units.force, work, units.time, 1.0


class Measured(NamedTuple):
    """An orbit that was measured: what a result row is made of.

    `record` (RECORD,) of the whole orbit in SI units; `cycle` half periods after which it closes,
    `begin` and `end` the states (x, v) before and after these; `symmetric` where the motion is its
    own mirror image half a period later; `amplitudes` of stress and force, their `error`, their
    `spreads` among single drive periods; Floquet `multiplier`, Lyapunov `exponent`, NaN where it
    closes; drive `periods` integrated for the point; the `status` if all is well.
    """

    record: np.ndarray
    cycle: int
    begin: tuple[float, float]
    end: tuple[float, float]
    symmetric: bool
    amplitudes: tuple[float, float]
    error: float
    spreads: tuple[float, float]
    multiplier: float
    exponent: float
    periods: int
    status: int


@inline
def _passes(cycle: int) -> int:
    """How often the half periods of a cycle are run through until the orbit closes."""
    return 2 if cycle % 2 == 1 else 1


@jit
def write_whole_orbit(
    record: np.ndarray, units: RecordUnits, cycle: int, target: np.ndarray
) -> None:
    """Write what a record (RECORD,) of `cycle` half periods says of the orbit, in SI units.

    `target` (RECORD,) is written; times in half periods.
    """
    write_stretch(record, units, _passes(cycle), target)
    target[MELTINGS] = _passes(cycle) * _melting_count(record)
    target[SOLID_CHANGES] = _passes(cycle) * _solid_changes(record)
    if record[LAST_PHASE] == SOLID:  # as the orbit ends, so it begins
        target[SOLID_TIME] += target[UNSEEN_TIME]
        target[UNSEEN_TIME] = 0.0


@jit
def write_stretch(record: np.ndarray, units: RecordUnits, passes: int, target: np.ndarray) -> None:
    """Write what a record (RECORD,) says of a stretch of motion, in SI units.

    `passes` is 2 where the mirror image of the stretch follows it, else 1; `target` (RECORD,) is
    written, with times in half periods.
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
    """Solid to liquid transitions, counted cyclically."""
    wrapped = record[LAST_PHASE] == SOLID and record[FIRST_PHASE] == MELTED
    return record[MELTINGS] + (1.0 if wrapped else 0.0)


@jit
def _solid_changes(record: np.ndarray) -> float:
    """Changes between a soft and a hard solid, counted cyclically."""
    first, last = record[FIRST_SOLID], record[LAST_SOLID]
    wrapped = first != last and first >= SOFT and last >= SOFT
    return record[SOLID_CHANGES] + (1.0 if wrapped else 0.0)


@inline
def amplitudes_of(record: np.ndarray) -> tuple[float, float]:
    """Amplitudes of stress and force: half of maximum minus minimum."""
    stress = 0.5 * (record[STRESS_MAX] - record[STRESS_MIN])
    return stress, 0.5 * (record[FORCE_MAX] - record[FORCE_MIN])


@inline
def full_force(p: Parameters) -> float:
    """Force that moves springs or inertia with the drive [N]: the yardstick of small forces.

    max(2K, M omega^2) |X_m|; a locked block needs the difference of the two.
    """
    inertia = p.block_mass * (p.angular_frequency * p.angular_frequency)
    return max(2.0 * p.spring_stiffness, inertia) * abs(p.drive_amplitude)


@jit
def relative_difference(p: Parameters, record: np.ndarray, better: np.ndarray) -> float:
    """Difference of the extrema of two orbits, of stress or of force, whichever is worse.

    The sum of the differences of maximum and minimum, relative to max(amplitude, 1 % of the full
    force), over A for the stress; at least twice that of the amplitudes.
    """
    floor, worst = _SMALL_PART * full_force(p), 0.0
    for slot, least in ((STRESS_MAX, floor / p.contact_area), (FORCE_MAX, floor)):
        high, low = record[slot], record[slot + 1]
        better_high, better_low = better[slot], better[slot + 1]
        scale = max(0.5 * (better_high - better_low), least)
        difference = abs(high - better_high) + abs(low - better_low)
        worst = max(worst, difference / scale if scale > 0.0 else 0.0)
    return worst


@jit
def _power_balance(p: Parameters, m: Measured) -> tuple[float, bool]:
    """The power balance error, and whether it is small enough to believe the orbit.

    |work of the drive - dissipation - energy gained| over the integral of |F V|. The dissipation is
    the integral of F (V - v), so the difference of the first two is the work done on the block.
    """
    end, begin = block.energy(p, m.end[0], m.end[1]), block.energy(p, m.begin[0], m.begin[1])
    gained = _passes(m.cycle) * (end - begin)
    miss, absolute = abs(m.record[BLOCK_WORK] - gained), m.record[ABSOLUTE_WORK]
    way = 2.0 * abs(p.drive_amplitude) * (m.cycle * _passes(m.cycle))
    least = _SMALL_PART * full_force(p) * way
    kept = miss <= _POWER_BALANCE_LIMIT * max(absolute, least)
    return miss / absolute if absolute > 0.0 else 0.0, kept


@jit
def _bounds_kept(p: Parameters, m: Measured) -> bool:
    """Whether the order parameter stayed below the value that it cannot exceed but by chance."""
    start, phi = math.exp(starting_state(p)[2]), m.record[PHI_MAX]
    bound = max(solids.largest_order_parameter(p), start) * _BOUND_MARGIN
    return phi <= bound or noise.may_reach(p, phi, bound)


@inline
def _asymmetry(high: float, low: float) -> float:
    """|max + min|/(max - min) of the elastic stress; 0 where max - min < 1 Pa."""
    return abs(high + low) / (high - low) if high - low >= 1.0 else 0.0


@jit
def _solid_fraction(p: Parameters, m: Measured) -> float:
    """Share of the time in the solid phase.

    Without a cubic term the thresholds are 0, which every film exceeds; above T_c it is liquid.
    """
    if solids.solid_threshold(p) == 0.0 and p.temperature >= p.critical_temperature:
        return 0.0
    return min(m.record[SOLID_TIME] / (m.cycle * _passes(m.cycle)), 1.0)


@inline
def _periods(m: Measured) -> int:
    """Drive periods after which the orbit closes, 0 for never."""
    return 0 if m.status == APERIODIC else m.cycle * _passes(m.cycle) // 2


@jit
def _regime(p: Parameters, m: Measured) -> int:
    """The kind of motion, a `Regime`."""
    if m.status == APERIODIC:
        return _APERIODIC
    if _periods(m) > 1:
        return _SUBHARMONIC
    if m.record[MELTINGS] == 0.0:
        return _LOCKED if _solid_fraction(p, m) > 0.0 else _LIQUID
    return _SYMMETRIC if m.symmetric else _ASYMMETRIC


@jit
def _result_row(p: Parameters, m: Measured) -> tuple[ResultRow, bool]:
    """The result row of an orbit, and whether its invariants hold."""
    high, low = m.record[STRESS_MAX], m.record[STRESS_MIN]
    force_high, force_low = m.record[FORCE_MAX], m.record[FORCE_MIN]
    balance, balance_kept = _power_balance(p, m)
    # Numba takes no choice among more than fifteen keywords: functions choose.
    row = ResultRow(
        elastic_stress_amplitude=m.amplitudes[0],
        friction_force_amplitude=m.amplitudes[1],
        elastic_stress_max=high,
        elastic_stress_min=low,
        friction_force_max=force_high,
        friction_force_min=force_low,
        amplitude_error=m.error,
        power_balance_error=balance,
        orbit_periods=float(_periods(m)),
        melting_count=m.record[MELTINGS],
        solid_transition_count=m.record[SOLID_CHANGES],
        asymmetry=_asymmetry(high, low),
        periods_integrated=float(m.periods),
        solid_fraction=_solid_fraction(p, m),
        regime=float(_regime(p, m)),
        floquet_multiplier=m.multiplier,
        lyapunov_exponent=m.exponent,
        elastic_stress_amplitude_spread=m.spreads[0],
        friction_force_amplitude_spread=m.spreads[1],
        status=float(m.status),
    )
    return row, balance_kept and _bounds_kept(p, m)


@jit
def write_result(p: Parameters, m: Measured, result: np.ndarray) -> None:
    """Write the result row of an orbit, or that of a point that must not be believed.

    `result` (columns,) in the order of `RESULT_COLUMNS`; its status is that of `m`, DIVERGED or
    INVARIANT_VIOLATED.
    """
    row, believed = _result_row(p, m)
    if not math.isfinite(
        row.elastic_stress_amplitude + row.friction_force_amplitude + row.amplitude_error
    ):
        write_failure(result, m.periods, DIVERGED)
    elif not believed:
        write_failure(result, m.periods, INVARIANT_VIOLATED)
    else:
        for column in range(len(row)):
            result[column] = row[column]


@jit
def write_failure(result: np.ndarray, periods: int, status: int) -> None:
    """Make a result row (columns,) that of a point that did not end ok."""
    for column in range(len(_MISSING)):
        result[column] = _MISSING[column]
    result[_PERIODS], result[STATUS] = periods, status
