"""Both ends of the lanes: from parameters to the points' own units, and back to result rows."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel, kernel_factory, named_kernel
from stickslip.compiled.fields import make_map
from stickslip.kernels.adaptive.passes import CYCLE, HALVES, OUTCOME, Queue
from stickslip.kernels.points import FIRST_STEP, parameters_of
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
    write_stretch,
    write_whole_orbit,
)
from stickslip.model import film, solids
from stickslip.model.laws import friction_law
from stickslip.model.relaxing import starting_state_with_strain
from stickslip.model.rhs import relative_velocity
from stickslip.model.scaling import Units, reduction, relaxing_units_of, units_of
from stickslip.model.state import components_of
from stickslip.numerics.adaptive import OK
from stickslip.options import RELAXING, Physics
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

state_units = make_map(
    "state_units",
    "units",
    (f"units.{c.unit}" if c.unit else "1.0" for c in components_of(RELAXING)),
    {},
)
"""Inline: the units of the components of a state; a relaxing strain is the last one."""


@inline
def _units_of(p: Parameters, relaxing: bool) -> Units:
    return relaxing_units_of(p) if relaxing else units_of(p)


@kernel_factory
def reduction_kernel(physics: Physics) -> Any:
    """The kernel that turns points into their own units.

    It takes `points` (n, parameters) and writes `reduced` (n, reduced parameters) and `states`
    (n, width + 1): the start in these units, and a first step.
    """
    reduced, relaxing = reduction(physics), physics.strain == RELAXING

    def reduce_points(points: np.ndarray, reduced_points: np.ndarray, states: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p = parameters_of(points[i])
            q, units = reduced(p), state_units(_units_of(p, relaxing))
            y, width = starting_state_with_strain(p), states.shape[1] - 1
            for slot in range(reduced_points.shape[1]):
                reduced_points[i, slot] = q[slot]
            for component in range(width):
                own = relative_velocity(p, 0.0, y[1]) if component == 1 else y[component]
                states[i, component] = own / units[component]
            states[i, width] = FIRST_STEP * (2.0 * math.pi)

    return named_kernel(f"reduce_points[{physics}]", reduce_points)


@kernel
def restore_states(points: np.ndarray, states: np.ndarray, relaxing: bool) -> None:
    """Turn states of the lanes into (x, v, psi, ...) in SI units, in place.

    `points` (n, parameters); `states` (n, width + 1), at phase 0 in units of each point's own;
    `relaxing` where the strain is among them.
    """
    width = states.shape[1] - 1
    for i in range(points.shape[0]):
        p = parameters_of(points[i])
        units = state_units(_units_of(p, relaxing))
        for component in range(width):
            states[i, component] *= units[component]
        states[i, 1] = relative_velocity(p, 0.0, states[i, 1])
        states[i, width] /= p.angular_frequency


@kernel
def scale_states(points: np.ndarray, states: np.ndarray, relaxing: bool) -> None:
    """Turn (x, v, psi, ...) in SI units into states of the lanes: the way back."""
    width = states.shape[1] - 1
    for i in range(points.shape[0]):
        p = parameters_of(points[i])
        units = state_units(_units_of(p, relaxing))
        states[i, 1] = relative_velocity(p, 0.0, states[i, 1])
        for component in range(width):
            states[i, component] /= units[component]
        states[i, width] *= p.angular_frequency


@inline
def _record_units(p: Parameters, relaxing: bool) -> RecordUnits:
    units = _units_of(p, relaxing)
    return RecordUnits(units.length, units.stress, units.force, 1.0, 1.0 / math.pi)


@kernel
def write_records(
    points: np.ndarray,
    cycles: np.ndarray,
    measured: np.ndarray,
    records: np.ndarray,
    relaxing: bool,
) -> None:
    """Write what `measured` (n, RECORD) says of whole orbits, in SI units, into `records`.

    `points` (n, parameters); `cycles` (n,) half periods that were measured.
    """
    for i in range(points.shape[0]):
        own = _record_units(parameters_of(points[i]), relaxing)
        write_whole_orbit(measured[i], own, cycles[i], records[i])


@kernel
def write_stretches(
    points: np.ndarray, measured: np.ndarray, records: np.ndarray, relaxing: bool
) -> None:
    """Write what `measured` (n, RECORD) says of stretches of motion, as `write_records`."""
    for i in range(points.shape[0]):
        write_stretch(measured[i], _record_units(parameters_of(points[i]), relaxing), 1, records[i])


class Orbits(NamedTuple):
    """What is known of n settled orbits besides their finer measurement.

    `begins` (n, width + 1) states on them, in units of their own; `coarse` (n, RECORD) at the
    coarser tolerance; `symmetric` (n,); `spreads` (n, 2) of stress and force in SI units;
    `multipliers` (n,); `slopes` (n, EXTREMA, width) of the extrema over the state at the begin;
    `missed` (n, width), by how much the finer cycle fails to close, as repetition is judged;
    `offsets` (n, width) of the state from the orbit, NaN where it left it, and `shifts` (n, width)
    of the orbit between the two tolerances, both a cycle later, when what is fast has been
    forgotten; `cusped` (n,), whether the law of friction has a cusp.
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
    cusped: np.ndarray


@kernel_factory
def cusp_kernel(friction: str) -> Any:
    """The kernel that writes into `cusped` (n,) whether the law has a cusp for these points."""
    has_cusp = friction_law(friction).has_cusp

    def write_cusps(points: np.ndarray, cusped: np.ndarray) -> None:
        for i in range(points.shape[0]):
            cusped[i] = has_cusp(parameters_of(points[i]))

    return named_kernel(f"write_cusps[{friction}]", write_cusps)


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


@kernel
def write_off_the_orbit(
    points: np.ndarray,
    queue: Queue,
    orbits: Orbits,
    rtol: float,
    relaxing: bool,
    off: np.ndarray,
) -> None:
    """Write which measurements (n,) began off the orbit by more than the tolerance `rtol`.

    By what an offset makes of the extrema or, where no front blurs the two measurements, by their
    difference. `points` (n, parameters); the `queue` after the finer measurement of the `orbits`.
    """
    record, other = np.empty(RECORD), np.empty(RECORD)
    for i in range(points.shape[0]):
        if queue.counts[i, OUTCOME] == OK:
            p, cycle, fine = parameters_of(points[i]), queue.counts[i, CYCLE], queue.measured[i]
            own = _record_units(p, relaxing)
            write_whole_orbit(fine, own, cycle, record)
            write_whole_orbit(orbits.coarse[i], own, cycle, other)
            slopes, offset = orbits.slopes[i], orbits.offsets[i]
            error = _error_of_displacement(p, fine, record, slopes, offset, own, cycle)
            solid = record[MELTINGS] == 0.0
            differ = solid and relative_difference(p, other, record) > _APART * rtol
            off[i] = differ or error > rtol


@kernel
def write_results(
    points: np.ndarray,
    queue: Queue,
    orbits: Orbits,
    rtol: float,
    relaxing: bool,
    results: np.ndarray,
) -> None:
    """Write the result rows (n, columns) of points that were settled and measured twice.

    `points` (n, parameters); the `queue` after the finer measurement; what is known of the `orbits`
    besides; the tolerance `rtol`; `relaxing` where the strain is among the states.
    """
    record, other = np.empty(RECORD), np.empty(RECORD)
    astray = np.zeros(orbits.begins.shape[1] - 1)
    for i in range(points.shape[0]):
        counts, cycle = queue.counts[i], queue.counts[i, CYCLE]
        if counts[OUTCOME] != OK:
            write_failure(results[i], (counts[HALVES] + 1) // 2, counts[OUTCOME])
            continue
        p, begin, end = parameters_of(points[i]), orbits.begins[i], queue.states[i]
        units, own = units_of(p), _record_units(p, relaxing)
        write_whole_orbit(queue.measured[i], own, cycle, record)
        write_whole_orbit(orbits.coarse[i], own, cycle, other)
        shift_part, least = _parts_of_error(p, record, orbits.cusped[i])
        fine, slopes = queue.measured[i], orbits.slopes[i]
        error = _DIFFERENCE_PART * relative_difference(p, other, record)
        # As much of the position: the force of a block near resonance is hundreds of times as off.
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
