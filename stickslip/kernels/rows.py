"""What goes into a door and what comes out: settings, parameter rows, result rows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.parameters import Parameters, ParameterValues

# The first step as a part of the drive period: short against every rate of the paper's scenes,
# and the controller lengthens it six-fold a step.
FIRST_STEP = 1e-6


class Settings(NamedTuple):
    """What a door needs beside the parameters; `integrator.rtol` and so on in a config."""

    rtol: float
    dt: float
    max_steps: int
    stationary_rtol: float
    max_periods: int
    accelerate: bool


RESULT_COLUMNS = (
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
"""Columns of a result row; the names are those of `variables.RESULTS`."""

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
