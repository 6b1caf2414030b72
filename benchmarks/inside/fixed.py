"""Euler-Cromer: marches in lanes, and periods measured by it."""

from __future__ import annotations

import numpy as np
from shared.points import Orbits

from inside import PHYSICS, WIDTH, amplitudes_of
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.parameter_rows import parameters_of, write_results
from stickslip.kernels.plain_iteration.march import write_starts, write_steps
from stickslip.kernels.plain_iteration.orbits import write_errors
from stickslip.measure.results import Measured, relative_difference
from stickslip.variables import RESULT_COLUMNS


def fixed_lanes(points: np.ndarray, dt: float, phi: float) -> March:
    """Return points at their start, but for the order parameter, ready to march."""
    steps, states = np.empty(len(points), np.int64), np.empty((len(points), WIDTH))
    write_steps(points, dt, steps)
    write_starts(points, states)
    states[:, 2] = phi
    return March(points, steps, states, PHYSICS)


def fixed_period(
    row: np.ndarray, final: np.ndarray, dt: float, exact: np.ndarray, near: np.ndarray
) -> tuple[Orbits, float]:
    """Return the results of a period by Euler-Cromer from a state, and its true error.

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
    return Orbits(points, results, start), float(error)
