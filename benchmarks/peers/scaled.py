"""The model in units in which one absolute tolerance fits every component.

State (x/|X_m|, u/(|X_m| omega), ln phi) with the relative velocity u, as in the product; time in
radians of the drive. The compiled functions call
`stickslip.model`; the symbolic one, for packages that build their own expressions, writes the same
equations out.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.compiled.decorators import kernel
from stickslip.kernels.points import parameters_of
from stickslip.model import noise
from stickslip.model.models import model_of
from stickslip.options import DEFAULTS
from stickslip.parameters import ParameterValues

EQUATIONS = model_of(DEFAULTS.physics).equations
rhs, jacobian = EQUATIONS.rhs, EQUATIONS.jacobian

# The flags of stickslip.compiled, for code that cannot be a kernel of it.
FLAGS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract"}}

# As in the model: a strain rate that stands for 0 where a derivative is infinite.
_SMALLEST_STRAIN_RATE = 1e-90


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


@kernel
def fill_jacobian(row: np.ndarray, s: float, y: np.ndarray, out: np.ndarray) -> None:
    """Write the Jacobian d(dy/ds)/dy at phase `s` into `out` (3, 3)."""
    p = parameters_of(row)
    omega = p.angular_frequency
    X_m = abs(p.drive_amplitude)
    scale = (X_m, X_m * omega, 1.0)
    J = jacobian(p, s / omega, (y[0] * scale[0], y[1] * scale[1], y[2]), 0.0)
    for i in range(3):
        for j in range(3):
            out[i, j] = J[i][j] * scale[j] / (scale[i] * omega)


@kernel
def rates(row: np.ndarray, s: float, y: np.ndarray) -> np.ndarray:
    """The rates dy/ds as a new array (3,)."""
    out = np.empty(3)
    fill_rates(row, s, y, out)
    return out


@kernel
def rates_jacobian(row: np.ndarray, s: float, y: np.ndarray) -> np.ndarray:
    """The Jacobian of the rates as a new array (3, 3)."""
    out = np.empty((3, 3))
    fill_jacobian(row, s, y, out)
    return out


def compile_all(row: np.ndarray, y: np.ndarray) -> None:
    """Have everything above compiled: a solver may ask for its first Jacobian late."""
    rates(row, 0.0, y)
    rates_jacobian(row, 0.0, y)
    fill_rates(row, 0.0, y, np.empty(3))
    fill_jacobian(row, 0.0, y, np.empty((3, 3)))


def symbolic_rates(ops: Any, p: ParameterValues, s: Any, y: Any) -> list[Any]:
    """The rates dy/ds as expressions.

    `ops` has exp, sin, fabs, sign, fmax; the fields of `p` may be symbols, except for the
    rheological index, which decides the form of the expression.
    """
    omega, X_m = p.angular_frequency, ops.fabs(p.drive_amplitude)
    V_m = X_m * omega
    phi = ops.exp(y[2])
    u, sign = y[1] * V_m, ops.sign(p.drive_amplitude)
    strain = u * p.strain_relaxation_time / p.film_thickness
    viscous = p.viscosity_coefficient * _rate_power(ops, u / p.film_thickness, p.rheological_index)
    force = (p.elastic_coefficient * phi**2 * strain + viscous) * p.contact_area
    growth = 2 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    growth = growth + p.elastic_coefficient * strain**2
    growth = growth - p.cubic_coefficient * phi + p.quartic_coefficient * phi**2
    noise_rate = noise.TYPICAL_FRACTION * p.noise_intensity / ops.fmax(phi**2, 1e-300)
    acceleration = (force - 2 * p.spring_stiffness * y[0] * X_m) / p.block_mass
    psi_rate = noise_rate - p.kinetic_coefficient * growth
    x_rate, V_rate = -sign * ops.sin(s) - y[1], -sign * ops.sin(s + 0.5 * np.pi)
    return [x_rate, V_rate - acceleration / (V_m * omega), psi_rate / omega]


def _rate_power(ops: Any, strain_rate: Any, gamma: float) -> Any:
    """sgn(r) |r|^(gamma + 1) with finite derivatives."""
    if gamma == 0.0:
        return strain_rate
    size = ops.fmax(ops.fabs(strain_rate), _SMALLEST_STRAIN_RATE)
    return ops.sign(strain_rate) * size ** (gamma + 1.0)
