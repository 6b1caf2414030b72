"""Euler-Cromer: marches in lanes, and periods measured by it."""

from __future__ import annotations

import numpy as np

from inside.defaults import PHYSICS, WIDTH, amplitudes_of
from inside.lanes import half_periods
from inside.scalar import scalar_end
from stickslip.kernels.adaptive import passes
from stickslip.kernels.adaptive.passes import work_through
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import motions_of
from stickslip.kernels.plain_iteration.comparison import write_errors
from stickslip.kernels.plain_iteration.starts import write_starts, write_steps
from stickslip.kernels.points import parameters_of, write_results
from stickslip.measure.accumulate import RECORD
from stickslip.measure.results import Measured, relative_difference
from stickslip.options import Options
from stickslip.variables import RESULT_COLUMNS


def scalar_steps(row: np.ndarray, options: Options, steps: int) -> None:
    """Take so many fixed steps by the scalar drive, from the start."""
    limited = Options(**(vars(options) | {"max_steps": steps}))
    scalar_end(row, limited, 1)


def fixed_lanes(points: np.ndarray, dt: float, phi: float | None = None) -> March:
    """Return points at their start, or with another order parameter, ready to march."""
    steps, states = np.empty(len(points), np.int64), np.empty((len(points), WIDTH))
    write_steps(points, dt, steps)
    write_starts(points, states)
    if phi is not None:
        states[:, 2] = phi
    return March(points, steps, states, PHYSICS)


def fixed_amplitudes(lanes: March) -> np.ndarray:
    """Return amplitudes of stress [Pa] and force [N] of what was marched, (n, 2)."""
    return amplitudes_of(lanes.records())


def reference_period(points: np.ndarray, finals: np.ndarray, rtol: float) -> np.ndarray:
    """Return SI records (n, RECORD) of an adaptive period from stroboscopic states.

    `finals` (n, columns) as `points.final_columns`.
    """
    motions, records = motions_of(points, PHYSICS), np.empty((len(points), RECORD))
    motions.states[:] = finals
    conversion_of(PHYSICS).scale_states(points, motions.states)
    half_periods(motions)[:] = 2
    work_through(motions, passes.MEASURE, rtol, 10**9, PHYSICS)
    conversion_of(PHYSICS).write_records(points, half_periods(motions), motions.measured, records)
    return records


def fixed_period(
    row: np.ndarray, final: np.ndarray, dt: float, exact: np.ndarray, near: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return the result row of a period by Euler-Cromer from a state, and its true error.

    The stated error is the difference from the record `near` (RECORD,), the true one that from
    `exact`. A step above the limit is not refused.
    """
    points, steps, start = row[None], np.empty(1, np.int64), final[None, :WIDTH].copy()
    start[:, 2] = np.exp(start[:, 2])
    write_steps(points, dt, steps)
    march = March(points, steps, start, PHYSICS)
    march.start(np.arange(1))
    march.march(measured=True)
    records, errors, nothing = march.records(), np.empty(1), np.zeros((1, 2))
    write_errors(points, records, near[None], errors)
    measured = Measured(
        records=records, uncertainties=np.zeros_like(records), cycles=np.full(1, 2), begins=start,
        ends=march.states(), symmetric=np.zeros(1, np.bool_), amplitudes=amplitudes_of(records),
        errors=errors,
        spreads=nothing, multipliers=nothing[0, :1], exponents=np.full(1, np.nan),
        periods=np.ones(1, np.int64), statuses=march.tasks.status,
    )  # fmt: skip
    results = np.empty((1, len(RESULT_COLUMNS)))
    write_results(points, measured, results)
    error = 0.5 * relative_difference(parameters_of(row), records[0], exact)
    return results[0], float(error)
