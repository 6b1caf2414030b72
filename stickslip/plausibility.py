"""Checks of finished results: impossible rows, and suspicious ones that deserve a closer look.

An orbit that violates an invariant has the status `invariant_violated`; `stability.py` checks in
advance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.model import drive
from stickslip.parameters import ParameterValues
from stickslip.stability import static_strength
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS

SUSPICIOUS_BALANCE = 1e-3
"""An orbit is suspicious if both its power balance error and its amplitude error exceed this. A
balance error beyond 1e-2 makes it a failure. If the force is a few percent of the full force, the
balance is a small difference of large numbers, although the amplitudes are right."""

SUSPICIOUS_STRESS = 1.1
"""A stress, relative to its static maximum, that only slow kinetics can reach."""

# Below this fraction of the full spring force, over A, a stress is too small for a comparison.
_SMALL = 0.01

# This many strains give the static maximum to within one percent.
_SOME = 12

_MAX, _MIN, _BALANCE, _ERROR, _PERIODS, _STATUS, _CLOSES_AFTER = (
    RESULT_COLUMNS.index(name)
    for name in (
        "elastic_stress_max",
        "elastic_stress_min",
        "power_balance_error",
        "amplitude_error",
        "periods_integrated",
        "status",
        "orbit_periods",
    )
)

_COLUMNS = [RESULTS[name] for name in RESULT_COLUMNS]
_LOWER, _UPPER, _MISSING = np.array([(v.lower, v.upper, v.missing) for v in _COLUMNS]).T
_WHOLE = np.array([v.dtype != "f8" for v in _COLUMNS])
_UPPER[_WHOLE] = np.minimum(_UPPER, 2.0**31 - 1)[_WHOLE]
_SOMETIMES = np.array([not v.always for v in _COLUMNS])
_OF_FAILURES = [_PERIODS, _STATUS]  # the columns of a point without a result
_WITH_RESULT = [status for status in Status if status.is_result]

# The columns of an amplitude, a maximum and a minimum.
_RANGES = [
    [RESULT_COLUMNS.index(f"{name}_{what}") for what in ("amplitude", "max", "min")]
    for name in ("elastic_stress", "friction_force")
]
_ROUNDING = 1e-9
_UNKNOWN_ERROR = 1.0  # the largest amplitude error of an orbit that closes


def are_possible(results: NDArray[np.float64]) -> bool:
    """Return whether these rows (n, columns) could be the undamaged output of a computation.

    A point with a result has all values within the ranges of `variables.RESULTS`, and no amplitude
    above half the difference between maximum and minimum; if the orbit closes, the two are equal,
    and the stated relative error is at most 1. A point without a result has only a status and
    perhaps a number of periods.
    """
    statuses = results[:, _STATUS]
    with_result = np.isin(statuses, _WITH_RESULT)
    return (
        bool(np.isin(statuses, [*Status]).all())
        and _are_of_orbits(results[with_result])
        and _are_of_failures(results[~with_result])
    )


def _are_of_orbits(rows: NDArray[np.float64]) -> bool:
    rows = np.where(np.isnan(rows) & _SOMETIMES, 0.0, rows)
    within = _are_within(rows, _LOWER, _UPPER) and _are_whole(rows[:, _WHOLE])
    closed = rows[:, _CLOSES_AFTER] > 0
    within &= not (rows[closed, _ERROR] > _UNKNOWN_ERROR).any()
    for amplitude, high, low in _RANGES:
        half = 0.5 * (rows[:, high] - rows[:, low])
        most, least = half * (1.0 + _ROUNDING), np.where(closed, half * (1.0 - _ROUNDING), 0.0)
        within &= bool(((least <= rows[:, amplitude]) & (rows[:, amplitude] <= most)).all())
    return within


def _are_of_failures(rows: NDArray[np.float64]) -> bool:
    rows = rows.copy()
    counts = rows[:, _OF_FAILURES]
    rows[:, _OF_FAILURES] = _MISSING[_OF_FAILURES]
    empty = ((rows == _MISSING) | (np.isnan(rows) & np.isnan(_MISSING))).all()
    least = np.minimum(_LOWER, _MISSING)[_OF_FAILURES]
    return bool(empty) and _are_whole(counts) and _are_within(counts, least, _UPPER[_OF_FAILURES])


def _are_within(
    rows: NDArray[np.float64], lower: NDArray[np.float64], upper: NDArray[np.float64]
) -> bool:
    """Return whether all rows (n, columns) are within bounds (columns,); NaN is not."""
    if not len(rows):
        return True
    return bool((rows.min(axis=0) >= lower).all() and (rows.max(axis=0) <= upper).all())


def _are_whole(rows: NDArray[np.float64]) -> bool:
    return bool((rows == np.floor(rows)).all())


def suspicious_balance(results: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which rows (n, columns) exceed `SUSPICIOUS_BALANCE` in both errors."""
    return np.asarray(np.minimum(results[:, _BALANCE], results[:, _ERROR]) > SUSPICIOUS_BALANCE)


def suspicious_stress(
    points: NDArray[np.float64], results: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return which points (n, parameters) have results over 10 % above the static stress."""
    p = ParameterValues(*points.T)
    stress = np.maximum(np.abs(results[:, _MAX]), np.abs(results[:, _MIN]))
    displacement = np.abs(drive.tone_amplitudes(points)[1]).sum(axis=1)
    small = _SMALL * 2.0 * p.spring_stiffness * displacement / p.contact_area
    # A few strains are enough to clear most points; the others need many.
    suspicious = stress > SUSPICIOUS_STRESS * np.maximum(static_strength(points, _SOME), small)
    few = np.flatnonzero(suspicious)
    suspicious[few] = stress[few] > SUSPICIOUS_STRESS * static_strength(points[few])
    return np.asarray(suspicious)
