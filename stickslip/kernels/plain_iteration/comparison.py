"""Reference orbits for fixed steps: those on which the adaptive method settles from the same state.

A step changes not only the measurement of a cycle but the cycle itself: if the orbit attracts
slowly, a small error of the map is a large offset of its fixed point. So the comparison is with the
adaptive method's own orbit, not with its path over the fixed-step one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.compiled.decorators import kernel
from stickslip.kernels.adaptive import tangents
from stickslip.kernels.adaptive.march import AdaptiveMarch
from stickslip.kernels.adaptive.passes import VARY, work_through
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import CYCLE, OUTCOME, motions_of
from stickslip.kernels.orbits.settling import APERIODIC, Search, settle
from stickslip.kernels.points import parameters_of
from stickslip.measure.accumulate import INTEGRALS, RECORD
from stickslip.measure.results import relative_difference
from stickslip.numerics.adaptive import OK
from stickslip.options import Options
from stickslip.status import Status

INACCURATE = int(Status.INACCURATE)

# The reference's own error at the paper's step is 1e-9.
_RTOL = 1e-9
_MAX_STEPS = 20_000_000


# The difference of two records counts both extrema; an amplitude is half of their difference.
_AMPLITUDE_PART = 0.5


class Known(NamedTuple):
    """Reference values of n orbits.

    `records` (n, RECORD) in SI units, and their `integrals` (n, INTEGRALS) per half period;
    `symmetric` (n,); Floquet `multipliers` (n,).
    """

    records: np.ndarray
    integrals: np.ndarray
    symmetric: np.ndarray
    multipliers: np.ndarray


def settle_from(
    points: np.ndarray, finals: np.ndarray, statuses: np.ndarray, options: Options
) -> Known:
    """Return the orbits on which the adaptive method settles from stroboscopic states.

    `points` (n, parameters); `finals` (n, columns). Where it finds none, the status in `statuses`
    (n,) is changed to the reason.
    """
    physics, halves = options.physics, 2 * options.max_periods
    conversion = conversion_of(physics)
    motions = motions_of(points, physics)
    motions.states[:] = finals
    conversion.scale_states(points, motions.states)
    motions.counts[:, OUTCOME] = statuses
    march = AdaptiveMarch(points, motions, physics, _MAX_STEPS)
    settle(march, np.flatnonzero(statuses == OK), Search(_RTOL, _RTOL, halves, accelerate=True))
    begins = motions.states.copy()
    work_through(motions, VARY, _RTOL, _MAX_STEPS, physics)
    wandered = (statuses == OK) & (motions.counts[:, OUTCOME] == APERIODIC)
    statuses[:] = np.where(wandered, INACCURATE, motions.counts[:, OUTCOME])
    records, cycles = np.empty((len(points), RECORD)), motions.counts[:, CYCLE]
    conversion.write_records(points, cycles, motions.measured, records)
    whole = np.where(cycles % 2 == 1, 2 * cycles, np.maximum(cycles, 1))  # 0 where none was found
    return Known(
        records,
        records[:, list(INTEGRALS)] / whole[:, None],
        tangents.symmetric(motions, begins, options.stationary_rtol, _RTOL, physics),
        tangents.neighbours_of(motions, begins, _RTOL, physics).multipliers,
    )


@kernel
def write_errors(
    points: np.ndarray, records: np.ndarray, references: np.ndarray, errors: np.ndarray
) -> None:
    """Write the errors (n,) of amplitudes from `records` (n, RECORD) and those of `references`."""
    for i in range(points.shape[0]):
        difference = relative_difference(parameters_of(points[i]), records[i], references[i])
        errors[i] = _AMPLITUDE_PART * difference
