"""Input and output rows of kernels: parameters, results and final states."""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import kernel
from stickslip.compiled.fields import make_row_reader
from stickslip.measure.results import Measured, write_result
from stickslip.model.models import model_of
from stickslip.options import Physics
from stickslip.parameters import ParameterValues

parameters_of = make_row_reader(ParameterValues)
"""The inline function that reads parameters from a row in the order of `Parameters._fields`."""

FIRST_STEP = 1e-6
"""The first step as a fraction of the drive period. It is short on every time scale of the paper's
figures, and the controller can make each step six times as long as the one before."""


def final_columns(physics: Physics) -> tuple[str, ...]:
    """Return the columns of a final row: the stroboscopic state (x, v, ln phi, ...), next step."""
    return (*(component.name for component in model_of(physics).components), "step")


def write_results(points: np.ndarray, measured: Measured, results: np.ndarray) -> None:
    """Write the result rows (n, columns) of motions of points (n, parameters)."""
    # Columns of other arrays are not contiguous, which would need a second signature of the kernel.
    _write_results(points, Measured(*map(np.ascontiguousarray, measured)), results)


@kernel
def _write_results(points: np.ndarray, measured: Measured, results: np.ndarray) -> None:
    for i in range(points.shape[0]):
        write_result(parameters_of(points[i]), measured, i, results[i])
