"""Reference orbits for fixed steps: those on which the adaptive method settles from the same state.

A step changes not only the measurement of a cycle but the cycle itself: if the orbit attracts
slowly, a small error of the map is a large offset of its fixed point. So the comparison is with the
adaptive method's own orbit, not with its path over the fixed-step one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.kernels.adaptive import tangents
from stickslip.kernels.adaptive.conversion import conversion_of
from stickslip.kernels.adaptive.passes import CYCLE, OUTCOME, VARY
from stickslip.kernels.adaptive.queues import reduced_queue, work_through
from stickslip.kernels.adaptive.settling import APERIODIC, Search, settle
from stickslip.measure.accumulate import INTEGRALS, RECORD
from stickslip.numerics.adaptive import OK
from stickslip.options import Options
from stickslip.status import Status

INACCURATE = int(Status.INACCURATE)

# The reference's own error at the paper's step is 1e-9.
_RTOL = 1e-9
_MAX_STEPS = 20_000_000


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
    queue = reduced_queue(points, physics)
    queue.states[:] = finals
    conversion.scale_states(points, queue.states)
    queue.counts[:, OUTCOME] = statuses
    settle(queue, Search(_RTOL, _RTOL, halves, _MAX_STEPS, accelerate=True), physics)
    begins = queue.states.copy()
    work_through(queue, VARY, _RTOL, _MAX_STEPS, physics)
    wandered = (statuses == OK) & (queue.counts[:, OUTCOME] == APERIODIC)
    statuses[:] = np.where(wandered, INACCURATE, queue.counts[:, OUTCOME])
    records, cycles = np.empty((len(points), RECORD)), queue.counts[:, CYCLE]
    conversion.write_records(points, cycles, queue.measured, records)
    whole = np.where(cycles % 2 == 1, 2 * cycles, np.maximum(cycles, 1))  # 0 where none was found
    return Known(
        records,
        records[:, list(INTEGRALS)] / whole[:, None],
        tangents.symmetric(queue, begins, options.stationary_rtol, _RTOL, physics),
        tangents.neighbours_of(queue, begins, _RTOL, physics).multipliers,
    )
