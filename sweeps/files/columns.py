"""The columns of a result row: their order and their types.

A result row is one number a column of `RESULT_COLUMNS`, as float64; NaN throughout is a point that
was not computed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS

Rows = NDArray[np.float64]

STATUS = RESULT_COLUMNS.index("status")
STATUS_CODES = int(Status.PENDING) + 1  # a count for each code, known or not, of a status


def result_values(name: str, column: NDArray[np.float64]) -> NDArray[np.generic]:
    """A column (n,) of result rows as a file holds it; NaN becomes the value that says missing."""
    variable = RESULTS[name]
    real = np.isnan(variable.missing)
    return (column if real else np.nan_to_num(column, nan=variable.missing)).astype(variable.dtype)


def status_counts(codes: NDArray[np.generic]) -> NDArray[np.int64]:
    """How many points (any shape) have each status: (STATUS_CODES,)."""
    return np.bincount(np.asarray(codes).ravel().astype(np.int64), minlength=STATUS_CODES)


def failures(statuses: NDArray[np.int64]) -> int:
    """How many points ended without a result; `statuses` (STATUS_CODES,) counts each status."""
    others = [Status.PENDING, *(status for status in Status if status.is_result)]
    return int(statuses.sum() - statuses[others].sum())
