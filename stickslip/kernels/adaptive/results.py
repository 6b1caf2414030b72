"""The doors at both ends of the lanes: from parameters to their own units, and back to results."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import door, inline, jit
from stickslip.kernels.adaptive.passes import CYCLE, HALVES, OUTCOME
from stickslip.kernels.adaptive.recording import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FIRST_PHASE,
    FORCE_MAX,
    LAST_PHASE,
    MELTED,
    MELTINGS,
    PHI_MAX,
    SOLID,
    STRESS_MAX,
)
from stickslip.kernels.rows import FIRST_STEP, fail, parameters_of
from stickslip.model import film
from stickslip.model.rhs import starting_state
from stickslip.model.scaling import reduced, units_of
from stickslip.numerics.adaptive import DIVERGED, OK
from stickslip.parameters import Parameters
from stickslip.status import Status

INVARIANT_VIOLATED = int(Status.INVARIANT_VIOLATED)

# Power balance beyond which an orbit is not believed.
_POWER_BALANCE_LIMIT = 1e-2

# The error estimate: what is left of the difference between two tolerances after a cut to a tenth,
# where it falls a little less than in proportion; and the least that is believed, in tolerances.
# The force of a shear-thickening fluid is steep in a velocity that is only known so well.
_FINER_PART = 0.2
_LEAST, _LEAST_SHEAR_THICKENING = 0.01, 0.05


@door
def reduce_points(points: np.ndarray, reduced_points: np.ndarray, states: np.ndarray) -> None:
    """Points in their own units.

    `points` (n, 20) in the order of `Parameters._fields`; written are `reduced_points` (n, 10) in
    the order of `Reduced._fields` and `states` (n, 4): the start (x, v, ln phi) in these units,
    and a first step.
    """
    for i in range(points.shape[0]):
        p = parameters_of(points[i])
        q, units = reduced(p), units_of(p)
        for slot in range(reduced_points.shape[1]):
            reduced_points[i, slot] = q[slot]
        x, v, psi = starting_state(p)
        states[i, 0], states[i, 1], states[i, 2] = x / units.length, v / units.speed, psi
        states[i, 3] = FIRST_STEP * (2.0 * math.pi)


@door
def restore_states(points: np.ndarray, states: np.ndarray) -> None:
    """Turn `states` (n, 4), in units of each point's own, into SI units, in place."""
    for i in range(points.shape[0]):
        units = units_of(parameters_of(points[i]))
        states[i, 0] *= units.length
        states[i, 1] *= units.speed
        states[i, 3] /= points[i, 4]


@inline
def _slot(slot: int) -> int:
    """Column of a record for a slot of a lane."""
    return slot - STRESS_MAX


@inline
def _extrema(record: np.ndarray, slot: int, cycle: int) -> tuple[float, float]:
    """Maximum of an observable and of its negative over the whole orbit.

    An orbit that closes after an odd number of half periods repeats them with the signs turned.
    """
    high, low = record[_slot(slot)], record[_slot(slot) + 1]
    if cycle % 2 == 1:
        high = max(high, low)
        low = high
    return high, low


@inline
def _energy(p: Parameters, state: np.ndarray) -> float:
    """Energy of the lower block and its springs, in the unit of energy."""
    K = p.spring_stiffness / (p.block_mass * p.angular_frequency**2)
    return 0.5 * state[1] ** 2 + K * state[0] ** 2


@jit
def _balance(
    p: Parameters, record: np.ndarray, begin: np.ndarray, end: np.ndarray, cycle: int
) -> tuple[float, bool]:
    """The power balance error, and whether it is small enough to believe the orbit.

    The yardstick of belief is at least a hundredth of the full spring force times the way of the
    drive, as for the errors of the amplitudes: where the force vanishes, its work is rounding.
    """
    gained = _energy(p, end) - _energy(p, begin)
    miss, absolute = abs(record[_slot(BLOCK_WORK)] - gained), record[_slot(ABSOLUTE_WORK)]
    stiffness = p.spring_stiffness / (p.block_mass * p.angular_frequency**2)
    floor = 0.01 * (2.0 * stiffness) * (2.0 * cycle)
    kept = miss <= _POWER_BALANCE_LIMIT * max(absolute, floor)
    return miss / absolute if absolute > 0.0 else 0.0, kept


@jit
def _bounds_kept(p: Parameters, record: np.ndarray, phi_start: float) -> bool:
    """Whether the order parameter stayed below the value that it cannot exceed."""
    bound = film.largest_order_parameter(
        p.temperature,
        p.thermal_coefficient,
        p.critical_temperature,
        p.cubic_coefficient,
        p.quartic_coefficient,
    )
    return record[_slot(PHI_MAX)] <= max(bound, phi_start) * 1.001


@jit
def _meltings(record: np.ndarray, cycle: int) -> int:
    """Solid to liquid transitions over the orbit, counted cyclically."""
    wrapped = record[_slot(LAST_PHASE)] == SOLID and record[_slot(FIRST_PHASE)] == MELTED
    count = int(record[_slot(MELTINGS)]) + (1 if wrapped else 0)
    return 2 * count if cycle % 2 == 1 else count


@jit
def _relative_difference(
    coarse: np.ndarray, fine: np.ndarray, slot: int, cycle: int, floor: float
) -> float:
    """Sum of the differences of both extrema against max(amplitude, floor)."""
    high, low = _extrema(coarse, slot, cycle)
    better_high, better_low = _extrema(fine, slot, cycle)
    scale = max(0.5 * (better_high + better_low), floor)
    difference = abs(high - better_high) + abs(low - better_low)
    return difference / scale if scale > 0.0 else 0.0


@jit
def _amplitude_error(
    p: Parameters,
    coarse: np.ndarray,
    fine: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    cycle: int,
    ratio: float,
    rtol: float,
) -> float:
    """Estimated error of the worse amplitude (docs/decisions/amplitude-error.md)."""
    units = units_of(p)
    floor = 0.01 * (2.0 * p.spring_stiffness * abs(p.drive_amplitude))
    stress_floor = floor / p.contact_area / abs(units.stress)
    difference = max(
        _relative_difference(coarse, fine, STRESS_MAX, cycle, stress_floor),
        _relative_difference(coarse, fine, FORCE_MAX, cycle, floor / abs(units.force)),
    )
    miss = max(abs(end[0] - begin[0]), abs(end[1] - begin[1]))
    farther = max(1.0, abs(ratio) / (1.0 - ratio))
    least = _LEAST_SHEAR_THICKENING if p.rheological_index > 0.0 else _LEAST
    return _FINER_PART * difference + farther * miss + least * rtol


@jit
def _fill(
    p: Parameters,
    fine: np.ndarray,
    cycle: int,
    result: np.ndarray,
) -> None:
    """Write extrema, amplitudes, asymmetry and counts of an orbit into its result row."""
    units = units_of(p)
    high, low = _extrema(fine, STRESS_MAX, cycle)
    force_high, force_low = _extrema(fine, FORCE_MAX, cycle)
    if units.length < 0.0:
        high, low, force_high, force_low = low, high, force_low, force_high
    stress, force = abs(units.stress), abs(units.force)
    result[0], result[1] = 0.5 * (high + low) * stress, 0.5 * (force_high + force_low) * force
    result[2], result[3] = high * stress, -low * stress
    result[4], result[5] = force_high * force, -force_low * force
    result[8] = cycle if cycle % 2 == 1 else cycle // 2
    result[9] = _meltings(fine, cycle)
    swing = (high + low) * stress
    result[10] = abs(high - low) * stress / swing if swing >= 1.0 else 0.0


@door
def write_results(
    points: np.ndarray,
    counts: np.ndarray,
    ratios: np.ndarray,
    begins: np.ndarray,
    ends: np.ndarray,
    coarse: np.ndarray,
    fine: np.ndarray,
    rtol: float,
    results: np.ndarray,
) -> None:
    """Result rows of points that were settled and measured twice.

    `points` (n, 20); `counts` (n, 4) and `ratios` (n,) of the search; `begins` and `ends` (n, 4)
    of the finer measurement, in the points' own units; `coarse` and `fine` (n, RECORD);
    `results` (n, 13) is written, in the order of RESULT_COLUMNS.
    """
    for i in range(points.shape[0]):
        p, result, cycle = parameters_of(points[i]), results[i], counts[i, CYCLE]
        periods = (counts[i, HALVES] + cycle + 1) // 2
        if counts[i, OUTCOME] != OK:
            fail(result, (counts[i, HALVES] + 1) // 2, counts[i, OUTCOME])
            continue
        _fill(p, fine[i], cycle, result)
        result[6] = _amplitude_error(
            p, coarse[i], fine[i], begins[i], ends[i], cycle, ratios[i], rtol
        )
        result[7], believed = _balance(p, fine[i], begins[i], ends[i], cycle)
        result[11], result[12] = periods, OK
        if not math.isfinite(result[0] + result[1] + result[6]):
            fail(result, periods, DIVERGED)
        elif not (believed and _bounds_kept(p, fine[i], math.exp(starting_state(p)[2]))):
            fail(result, periods, INVARIANT_VIOLATED)
