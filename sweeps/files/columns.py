"""The columns of a result row: their order, their types, and rows of other versions.

A result row is one number a column of `RESULT_COLUMNS`, as float64; NaN throughout is a point that
was not computed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS

Rows = NDArray[np.float64]

STATUS = RESULT_COLUMNS.index("status")
STATUS_CODES = int(Status.PENDING) + 1  # a count for each code, known or not, of a status

# The columns of journals that do not name theirs: those of the first version.
FIRST_COLUMNS = (
    "elastic_stress_amplitude",
    "friction_force_amplitude",
    "elastic_stress_max",
    "elastic_stress_min",
    "friction_force_max",
    "friction_force_min",
    "amplitude_error",
    "power_balance_error",
    "orbit_periods",
    "melting_count",
    "asymmetry",
    "periods_integrated",
    "status",
)


def result_values(name: str, column: NDArray[np.float64]) -> NDArray[np.generic]:
    """A column (n,) of result rows as a file holds it; NaN becomes the value that says missing."""
    variable = RESULTS[name]
    real = np.isnan(variable.missing)
    return (column if real else np.nan_to_num(column, nan=variable.missing)).astype(variable.dtype)


def lacking(columns: Iterable[str]) -> tuple[str, ...]:
    """The columns of today that are not among these."""
    known = set(columns)
    return tuple(name for name in RESULT_COLUMNS if name not in known)


def conformed(rows: Rows, columns: Sequence[str]) -> Rows:
    """Rows (n, len(columns)) of another version with the columns of today.

    A column that they lack gets the value that says missing; one that is unknown is left out.
    """
    if tuple(columns) == RESULT_COLUMNS:
        return rows
    taken = np.empty((len(rows), len(RESULT_COLUMNS)))
    for place, name in enumerate(RESULT_COLUMNS):
        taken[:, place] = rows[:, columns.index(name)] if name in columns else RESULTS[name].missing
    return taken


def status_counts(codes: NDArray[np.generic]) -> NDArray[np.int64]:
    """How many points (any shape) have each status: (STATUS_CODES,)."""
    return np.bincount(np.asarray(codes).ravel().astype(np.int64), minlength=STATUS_CODES)


def failures(statuses: NDArray[np.int64]) -> int:
    """How many points ended without a result; `statuses` (STATUS_CODES,) counts each status."""
    others = [Status.PENDING, *(status for status in Status if status.is_result)]
    return int(statuses.sum() - statuses[others].sum())
