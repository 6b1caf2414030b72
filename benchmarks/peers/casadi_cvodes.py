"""casadi: CVODES (BDF) on casadi's expressions, with derivatives by automatic differentiation."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

import numpy as np

from peers.base import Peer, PeerFailed, State
from stickslip.model import noise
from stickslip.parameters import Parameters, ParameterValues

_PLENTY = 100_000_000
_ATOL = 1e-3  # in rtol
_SMALLEST_STRAIN_RATE = 1e-90  # as in the model: stands for 0 where a derivative is infinite
_INDEX = ParameterValues._fields.index("rheological_index")


class CasadiCvodes(Peer):
    """`casadi.integrator` with CVODES; one integrator a fluid, tolerance and phase.

    At absolute tolerances from 0.01 rtol on, CVODES fails at rtol 1e-5 and 1e-6 on the paper's
    fluid; C code from the expressions (`jit`) is not faster than casadi's own evaluation.
    """

    package = "casadi"
    slow = False

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        integrator = _integrator(float(row[_INDEX]), phase, rtol)
        try:
            return np.asarray(integrator(x0=begin, p=row)["xf"]).ravel()
        except RuntimeError as error:
            raise PeerFailed(_short(str(error))) from error

    def prepare(
        self,
        parameters: Parameters,
        start: State,  # noqa: ARG002
        periods: int,
        rtol: float,
    ) -> None:
        """Build the integrator: its end is part of it."""
        _integrator(parameters.rheological_index, 2.0 * math.pi * periods, rtol)


@cache
def _integrator(gamma: float, phase: float, rtol: float) -> Any:
    import casadi

    s, y = casadi.SX.sym("s"), casadi.SX.sym("y", 3)
    row = casadi.SX.sym("row", len(ParameterValues._fields))
    values = [row[i] for i in range(row.numel())]
    values[_INDEX] = gamma
    rates = casadi.vertcat(*_rates(casadi, ParameterValues(*values), s, y))
    options = {"abstol": _ATOL * rtol, "reltol": rtol, "max_num_steps": _PLENTY}
    equations = {"t": s, "x": y, "p": row, "ode": rates}
    return casadi.integrator("model", "cvodes", equations, 0.0, phase, options)


def _short(message: str) -> str:
    """Return what CVODES returned, out of casadi's message."""
    name = re.search(r"CV_\w+", message)
    return f"CVODES returns {name[0]}" if name else message.strip().splitlines()[-1][:120]


def _rates(ops: Any, p: ParameterValues, s: Any, y: Any) -> list[Any]:
    """Return dy/ds of `peers.scaled` as expressions.

    `ops` is casadi; the fields of `p` may be symbols, except for the rheological index, which
    decides the form of the expression.
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
    """Return sgn(r) |r|^(gamma + 1) with finite derivatives."""
    if gamma == 0.0:
        return strain_rate
    size = ops.fmax(ops.fabs(strain_rate), _SMALLEST_STRAIN_RATE)
    return ops.sign(strain_rate) * size ** (gamma + 1.0)
