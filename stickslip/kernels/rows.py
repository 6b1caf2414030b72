"""What goes into a door and what comes out: settings, parameter rows, result rows."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.options import Settings as Settings
from stickslip.parameters import Parameters, ParameterValues
from stickslip.variables import RESULT_COLUMNS as RESULT_COLUMNS

# The first step as a part of the drive period: short against every rate of the paper's scenes,
# and the controller lengthens it six-fold a step.
FIRST_STEP = 1e-6


FINAL_COLUMNS = ("displacement", "velocity", "log_order_parameter", "step")
"""Columns of a final row: the stroboscopic state (x, v, ln phi) on the orbit, the next step."""


@inline
def period_of(p: Parameters) -> float:
    """Drive period 2 pi/omega [s]."""
    return 2.0 * math.pi / p.angular_frequency


@inline
def parameters_of(row: np.ndarray) -> ParameterValues:
    """The parameters held by a row of 20 floats in the order of the fields."""
    return ParameterValues(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9],
        row[10], row[11], row[12], row[13], row[14], row[15], row[16], row[17], row[18], row[19],
    )  # fmt: skip


@jit
def fail(result: np.ndarray, periods: int, status: int) -> None:
    """Make a result row that of a point that did not end ok."""
    for column in range(result.shape[0]):  # a slice would compile NumPy's shape errors
        result[column] = np.nan
    result[8], result[9] = -1, -1
    result[11] = periods
    result[12] = status
