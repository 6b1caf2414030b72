"""casadi: CVODES (BDF) on casadi's expressions, with derivatives by automatic differentiation."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

import numpy as np

from peers.base import Peer, PeerFailed, State
from peers.scaled import symbolic_rates
from stickslip.parameters import Parameters, ParameterValues

_PLENTY = 100_000_000
_ATOL = 1e-3  # in rtol
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
    rates = casadi.vertcat(*symbolic_rates(casadi, ParameterValues(*values), s, y))
    options = {"abstol": _ATOL * rtol, "reltol": rtol, "max_num_steps": _PLENTY}
    equations = {"t": s, "x": y, "p": row, "ode": rates}
    return casadi.integrator("model", "cvodes", equations, 0.0, phase, options)


def _short(message: str) -> str:
    """What CVODES returned, out of casadi's message."""
    name = re.search(r"CV_\w+", message)
    return f"CVODES returns {name[0]}" if name else message.strip().splitlines()[-1][:120]
