"""The model in units in which one absolute tolerance fits every component.

State (x/|X_m|, u/(|X_m| omega), ln phi) with the relative velocity u, as in the product; time in
radians of the drive.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.compiled.decorators import kernel, kernel_making_arrays
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.model.models import model_of
from stickslip.options import DEFAULTS

EQUATIONS = model_of(DEFAULTS.physics).equations
rhs, jacobian = EQUATIONS.rhs, EQUATIONS.jacobian

# The flags of stickslip.compiled, for code that cannot be a kernel of it.
FLAGS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}


@kernel
def fill_rates(row: np.ndarray, s: float, y: np.ndarray, out: np.ndarray) -> None:
    """Write dy/ds at phase `s` into `out` (3,); `row` (parameters,) as `Parameters`."""
    p = parameters_of(row)
    omega = p.angular_frequency
    X_m = abs(p.drive_amplitude)
    V_m = X_m * omega
    x_rate, u_rate, psi_rate = rhs(p, s / omega, (y[0] * X_m, y[1] * V_m, y[2]), 0.0)
    out[0] = x_rate / V_m
    out[1] = u_rate / (V_m * omega)
    out[2] = psi_rate / omega


@kernel_making_arrays
def rates(row: np.ndarray, s: float, y: np.ndarray) -> np.ndarray:
    """Return the rates dy/ds as a new array (3,)."""
    out = np.empty(3)
    fill_rates(row, s, y, out)
    return out


@kernel_making_arrays
def rates_jacobian(row: np.ndarray, s: float, y: np.ndarray) -> np.ndarray:
    """Return the Jacobian d(dy/ds)/dy at phase `s` as a new array (3, 3)."""
    p, out = parameters_of(row), np.empty((3, 3))
    omega = p.angular_frequency
    X_m = abs(p.drive_amplitude)
    scale = (X_m, X_m * omega, 1.0)
    J = jacobian(p, s / omega, (y[0] * scale[0], y[1] * scale[1], y[2]), 0.0)
    for i in range(3):
        for j in range(3):
            out[i, j] = J[i][j] * scale[j] / (scale[i] * omega)
    return out
