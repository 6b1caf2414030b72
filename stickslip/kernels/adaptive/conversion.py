"""Both ends of the lanes: from parameters to the points' own units, and back to result rows."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, kernel, kernel_factory, named_kernel
from stickslip.compiled.fields import make_map
from stickslip.kernels.adaptive.passes import CYCLE, HALVES, OUTCOME, Queue
from stickslip.kernels.points import FIRST_STEP, parameters_of
from stickslip.measure.accumulate import RECORD
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
from stickslip.model.laws import friction_law
from stickslip.model.rhs import relative_state, starting_state
from stickslip.model.scaling import reduction, units_of
from stickslip.model.state import STATE, WIDTH
from stickslip.numerics.adaptive import OK
from stickslip.parameters import Parameters

# The error estimate: what is left of the difference between two tolerances after a cut to a tenth,
# where it falls a little less than in proportion; and the least that is believed, in tolerances.
# The force of a shear-thickening fluid is steep in a velocity that is only known so well.
_FINER_PART = 0.2
_LEAST, _LEAST_SHEAR_THICKENING = 0.01, 0.05

state_units = make_map(
    "state_units", "units", (f"units.{c.unit}" if c.unit else "1.0" for c in STATE), {}
)
"""Inline: the units of the components of the state."""

_row_state = make_map("row_state", "row", (f"row[{i}]" for i in range(WIDTH)), {})


@kernel_factory
def reduction_kernel(law: str) -> Any:
    """The kernel that turns points into their own units.

    It takes `points` (n, parameters) and writes `reduced` (n, reduced parameters) and `states`
    (n, WIDTH + 1): the start in these units, and a first step.
    """
    reduced = reduction(law)

    def reduce_points(points: np.ndarray, reduced_points: np.ndarray, states: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p = parameters_of(points[i])
            q, units = reduced(p), state_units(units_of(p))
            y = relative_state(p, 0.0, starting_state(p))
            for slot in range(reduced_points.shape[1]):
                reduced_points[i, slot] = q[slot]
            for component in range(WIDTH):
                states[i, component] = y[component] / units[component]
            states[i, WIDTH] = FIRST_STEP * (2.0 * math.pi)

    return named_kernel(f"reduce_points[{law}]", reduce_points)


@kernel
def restore_states(points: np.ndarray, states: np.ndarray) -> None:
    """Turn states of the lanes into (x, v, psi) in SI units, in place.

    `points` (n, parameters); `states` (n, WIDTH + 1), at phase 0 in units of each point's own.
    """
    for i in range(points.shape[0]):
        p = parameters_of(points[i])
        units = state_units(units_of(p))
        for component in range(WIDTH):
            states[i, component] *= units[component]
        y = relative_state(p, 0.0, _row_state(states[i]))
        for component in range(WIDTH):
            states[i, component] = y[component]
        states[i, WIDTH] /= p.angular_frequency


@kernel
def scale_states(points: np.ndarray, states: np.ndarray) -> None:
    """Turn (x, v, psi) in SI units into states of the lanes: `restore_states` the other way."""
    for i in range(points.shape[0]):
        p = parameters_of(points[i])
        y, units = relative_state(p, 0.0, _row_state(states[i])), state_units(units_of(p))
        for component in range(WIDTH):
            states[i, component] = y[component] / units[component]
        states[i, WIDTH] *= p.angular_frequency


@inline
def _record_units(p: Parameters) -> RecordUnits:
    units = units_of(p)
    return RecordUnits(units.length, units.stress, units.force, 1.0, 1.0 / math.pi)


@kernel
def write_records(
    points: np.ndarray, cycles: np.ndarray, measured: np.ndarray, records: np.ndarray
) -> None:
    """Write what `measured` (n, RECORD) says of whole orbits, in SI units, into `records`.

    `points` (n, parameters); `cycles` (n,) half periods that were measured.
    """
    for i in range(points.shape[0]):
        own = _record_units(parameters_of(points[i]))
        write_whole_orbit(measured[i], own, cycles[i], records[i])


@kernel
def write_stretches(points: np.ndarray, measured: np.ndarray, records: np.ndarray) -> None:
    """Write what `measured` (n, RECORD) says of stretches of motion, as `write_records`."""
    for i in range(points.shape[0]):
        write_stretch(measured[i], _record_units(parameters_of(points[i])), 1, records[i])


class Orbits(NamedTuple):
    """What is known of n settled orbits besides their finer measurement.

    `begins` (n, WIDTH + 1) states on them, in units of their own; `coarse` (n, RECORD); `symmetric`
    (n,); `spreads` (n, 2) of stress and force in SI units; `multipliers` (n,).
    """

    begins: np.ndarray
    coarse: np.ndarray
    symmetric: np.ndarray
    spreads: np.ndarray
    multipliers: np.ndarray


@kernel_factory
def result_kernel(law: str) -> Any:
    """The kernel that writes the result rows of points that were settled and measured twice.

    It takes `points` (n, parameters); the `queue` after the finer measurement; what is known of
    the `orbits` besides; `rtol`; and writes `results` (n, columns).
    """
    thickens = friction_law(law).thickens

    def write_results(
        points: np.ndarray,
        queue: Queue,
        orbits: Orbits,
        rtol: float,
        results: np.ndarray,
    ) -> None:
        record, other = np.empty(RECORD), np.empty(RECORD)
        for i in range(points.shape[0]):
            counts, cycle = queue.counts[i], queue.counts[i, CYCLE]
            if counts[OUTCOME] != OK:
                write_failure(results[i], (counts[HALVES] + 1) // 2, counts[OUTCOME])
                continue
            p, begin, end = parameters_of(points[i]), orbits.begins[i], queue.states[i]
            units, own = units_of(p), _record_units(p)
            write_whole_orbit(queue.measured[i], own, cycle, record)
            write_whole_orbit(orbits.coarse[i], own, cycle, other)
            miss = max(abs(end[0] - begin[0]), abs(end[1] - begin[1]))
            farther = max(1.0, abs(queue.ratios[i]) / (1.0 - queue.ratios[i]))
            least = _LEAST_SHEAR_THICKENING if thickens(p) else _LEAST
            difference = relative_difference(p, other, record)
            measured = Measured(
                record=record,
                cycle=cycle,
                # At phase 0 the drive stands still: v = -u.
                begin=(begin[0] * units.length, -begin[1] * units.speed),
                end=(end[0] * units.length, -end[1] * units.speed),
                symmetric=orbits.symmetric[i],
                amplitudes=amplitudes_of(record),
                error=_FINER_PART * difference + farther * miss + least * rtol,
                spreads=(orbits.spreads[i, 0], orbits.spreads[i, 1]),
                multiplier=orbits.multipliers[i],
                exponent=np.nan,
                periods=(counts[HALVES] + cycle + 1) // 2,
                status=OK,
            )
            write_result(p, measured, results[i])

    return named_kernel(f"write_results[{law}]", write_results)
