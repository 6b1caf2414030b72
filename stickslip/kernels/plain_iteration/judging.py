"""Kernels that feed the search with periods of fixed steps, and that write result rows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, kernel
from stickslip.kernels.adaptive.states import state_functions
from stickslip.kernels.plain_iteration.comparison import Known
from stickslip.kernels.points import parameters_of
from stickslip.measure.results import (
    Measured,
    amplitudes_of,
    relative_difference,
    write_failure,
    write_result,
)
from stickslip.model.scaling import units_of
from stickslip.model.state import STATE, State
from stickslip.numerics.adaptive import OK
from stickslip.numerics.periodic import search

_UNLIMITED = 2**62

# The difference of two records counts both extrema; an amplitude is half of their difference.
_AMPLITUDE_PART = 0.5

judged = state_functions(STATE).judged


@inline
def _judged(point: np.ndarray, state: np.ndarray) -> State:
    """The state (x, v, phi) in the weighted form in which its repetition is tested."""
    units = units_of(parameters_of(point))
    return judged((state[0] / units.length, state[1] / units.speed, math.log(state[2])))


@kernel
def start_searches(
    points: np.ndarray, states: np.ndarray, memories: np.ndarray, late: bool
) -> None:
    """Begin the searches `memories` (n,) of points at the states (n, 3), (x, v, phi).

    `late` as in `search.start`.
    """
    for i in range(points.shape[0]):
        search.start(memories[i], _judged(points[i], states[i]), 1, False, False, late)


@kernel
def judge(
    points: np.ndarray,
    states: np.ndarray,
    which: np.ndarray,
    tolerance: float,
    memories: np.ndarray,
    verdicts: np.ndarray,
) -> None:
    """Pass the stroboscopic states of some points to their searches, and write the verdicts.

    `points` (n, parameters); `states` (n, 3); `which` (m,) indices; `tolerance` the required
    distance from the limit; `memories` (n,) and `verdicts` (n,) of `numerics.periodic.search`.
    """
    for i in which:
        z = _judged(points[i], states[i])
        verdicts[i], _, _ = search.judge(memories[i], z, tolerance, 0.0, _UNLIMITED)


class Orbits(NamedTuple):
    """Orbits measured over whole cycles; all in SI units.

    `cycles`, `periods` and `statuses` (n,); `begins` and `ends` (n, 3) the states (x, v, phi)
    before and after; `records` (n, RECORD); `spreads` (n, 2) of stress and force.
    """

    cycles: np.ndarray
    periods: np.ndarray
    statuses: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    records: np.ndarray
    spreads: np.ndarray


@kernel
def write_results(points: np.ndarray, orbits: Orbits, known: Known, results: np.ndarray) -> None:
    """Write the result rows (n, columns) of points (n, parameters)."""
    for i in range(results.shape[0]):
        if orbits.statuses[i] != OK:
            write_failure(results[i], orbits.periods[i], orbits.statuses[i])
            continue
        p, begin, end = parameters_of(points[i]), orbits.begins[i], orbits.ends[i]
        record = orbits.records[i]
        measured = Measured(
            record=record,
            cycle=2 * orbits.cycles[i],
            begin=(begin[0], begin[1]),
            end=(end[0], end[1]),
            symmetric=known.symmetric[i],
            amplitudes=amplitudes_of(record),
            error=_AMPLITUDE_PART * relative_difference(p, record, known.records[i]),
            spreads=(orbits.spreads[i, 0], orbits.spreads[i, 1]),
            multiplier=known.multipliers[i],
            exponent=np.nan,
            periods=orbits.periods[i],
            status=OK,
        )
        write_result(p, measured, results[i])
