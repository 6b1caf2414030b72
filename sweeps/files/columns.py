"""The columns of a result row: their order, and counts of what they hold.

A result row is one number a column of `RESULT_COLUMNS`, as float64; NaN throughout is a point that
was not computed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

Rows = NDArray[np.float64]

STATUS = RESULT_COLUMNS.index("status")
STATUS_CODES = int(Status.PENDING) + 1  # a count for every code of a status, known or not


def status_counts(codes: NDArray[np.generic]) -> NDArray[np.int64]:
    """Count the points (any shape) of each status, (STATUS_CODES,)."""
    return np.bincount(np.asarray(codes).ravel().astype(np.int64), minlength=STATUS_CODES)


def failures(statuses: NDArray[np.int64]) -> int:
    """Return the number of points without a result, given the count of each status."""
    others = [Status.PENDING, *(status for status in Status if status.is_result)]
    return int(statuses.sum() - statuses[others].sum())
