"""Both ends of the lanes: from parameters to the points' own units, and back to result rows."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, kernel, kernel_factory, named_kernel
from stickslip.compiled.fields import make_map
from stickslip.kernels.adaptive.passes import CYCLE, HALVES, OUTCOME, Queue
from stickslip.kernels.points import FIRST_STEP, parameters_of
from stickslip.measure.accumulate import MELTINGS, PHI_MAX, RECORD
from stickslip.measure.results import (
    Measured,
    RecordUnits,
    amplitudes_of,
    force_condition,
    relative_difference,
    stress_part,
    write_failure,
    write_result,
    write_stretch,
    write_whole_orbit,
)
from stickslip.model import solids
from stickslip.model.relaxing import starting_state_with_strain
from stickslip.model.rhs import relative_velocity
from stickslip.model.scaling import Units, reduction, relaxing_units_of, units_of
from stickslip.model.state import FILM, components_of
from stickslip.numerics.adaptive import OK
from stickslip.options import RELAXING, Physics
from stickslip.parameters import Parameters

# The error estimate: what is left of the difference between two tolerances after a cut to a tenth,
# where it falls a little less than in proportion; the distances from the orbit that an amplitude
# may be off by; and the least that is believed, in tolerances: on fewer the two measurements agree
# by accident on more than a point in a hundred.
_FINER_PART = 0.2
_DISTANCES = 2.0
_LEAST = 0.03
_LEAST_OF_LOCKED = 2.5  # as many times, by the condition of the force besides
_PHI_SQUARED = 2.0  # changes of ln(phi) count twice in the stress

# A film that is solid at phase 0 and moves by more tolerances than this from cycle to cycle has not
# settled: how far it has to go is told by the multiplier, this one where that is unknown.
_UNSETTLED = 100.0
_LARGEST_MULTIPLIER = 0.999
_UNKNOWN_MULTIPLIER = 0.99

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

    `begins` (n, width + 1) states on them, in units of their own; `coarse` (n, RECORD), and `ends`
    (n, width + 1) after it; `symmetric` (n,); `spreads` (n, 2) of stress and force in SI units;
    `multipliers` (n,).
    """

    begins: np.ndarray
    coarse: np.ndarray
    ends: np.ndarray
    symmetric: np.ndarray
    spreads: np.ndarray
    multipliers: np.ndarray


@inline
def _distance(begin: np.ndarray, end: np.ndarray, ratio: float) -> float:
    """Distance of (x, u) from the orbit, by how far it fails to close and its contraction."""
    moved = max(abs(end[0] - begin[0]), abs(end[1] - begin[1]))
    return moved * max(1.0, abs(ratio) / (1.0 - ratio))


@inline
def _film_distance(
    begin: np.ndarray, end: np.ndarray, cycle: int, multiplier: float, rtol: float
) -> float:
    """Distance of ln(phi) of a solid film from the orbit; the search judges it by the thousandth.

    Where the film is the slow part, x and u stand still long before it does.
    """
    moved = abs(end[FILM] - begin[FILM])
    if moved <= _UNSETTLED * rtol:
        return moved
    slow = min(multiplier, _LARGEST_MULTIPLIER) if multiplier >= 0.0 else _UNKNOWN_MULTIPLIER
    ratio = math.sqrt(slow) if cycle % 2 == 1 else slow
    return moved / (1.0 - ratio)


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
    for i in range(points.shape[0]):
        counts, cycle = queue.counts[i], queue.counts[i, CYCLE]
        if counts[OUTCOME] != OK:
            write_failure(results[i], (counts[HALVES] + 1) // 2, counts[OUTCOME])
            continue
        p, begin, end = parameters_of(points[i]), orbits.begins[i], queue.states[i]
        units, own = units_of(p), _record_units(p, relaxing)
        write_whole_orbit(queue.measured[i], own, cycle, record)
        write_whole_orbit(orbits.coarse[i], own, cycle, other)
        distance = _distance(begin, end, queue.ratios[i])
        least = _LEAST * rtol
        if math.exp(begin[FILM]) >= solids.solid_threshold(p):
            distance += _film_distance(begin, end, cycle, orbits.multipliers[i], rtol)
            if record[MELTINGS] == 0.0:  # solid throughout: the blocks are locked
                least *= _LEAST_OF_LOCKED * force_condition(p, record)
        elif record[PHI_MAX] < solids.solid_threshold(p):
            # Liquid throughout, so that its phi remembers the errors of the whole orbit.
            swings = max(abs(end[FILM] - begin[FILM]), abs(end[FILM] - orbits.ends[i, FILM]))
            distance += _PHI_SQUARED * swings * stress_part(p, record)
        difference = relative_difference(p, other, record)
        measured = Measured(
            record=record,
            cycle=cycle,
            # At phase 0 the drive stands still: v = -u.
            begin=(begin[0] * units.length, -begin[1] * units.speed),
            end=(end[0] * units.length, -end[1] * units.speed),
            symmetric=orbits.symmetric[i],
            amplitudes=amplitudes_of(record),
            error=_FINER_PART * difference + _DISTANCES * distance + least,
            spreads=(orbits.spreads[i, 0], orbits.spreads[i, 1]),
            multiplier=orbits.multipliers[i],
            exponent=np.nan,
            periods=(counts[HALVES] + cycle + 1) // 2,
            status=OK,
        )
        write_result(p, measured, results[i])
