"""Kernels that feed the search with periods of fixed steps, and that compare records."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import inline, kernel
from stickslip.kernels.adaptive.states import state_functions
from stickslip.kernels.points import parameters_of
from stickslip.measure.results import relative_difference
from stickslip.model.drive import relative_speed_bound
from stickslip.model.scaling import units_of
from stickslip.model.state import STATE, State
from stickslip.numerics.periodic import search

_UNLIMITED = 2**62

# The difference of two records counts both extrema; an amplitude is half of their difference.
_AMPLITUDE_PART = 0.5

judged = state_functions(STATE).judged


@inline
def _judged(point: np.ndarray, state: np.ndarray) -> State:
    """The state (x, v, phi) in the weighted form in which its repetition is tested."""
    p = parameters_of(point)
    units, bound = units_of(p), relative_speed_bound(p)
    x, v = state[0] / units.length / bound, state[1] / units.speed / bound
    return judged((x, v, math.log(state[2])))


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


@kernel
def write_errors(
    points: np.ndarray, records: np.ndarray, references: np.ndarray, errors: np.ndarray
) -> None:
    """Write the errors (n,) of amplitudes from `records` (n, RECORD) and those of `references`."""
    for i in range(points.shape[0]):
        difference = relative_difference(parameters_of(points[i]), records[i], references[i])
        errors[i] = _AMPLITUDE_PART * difference
