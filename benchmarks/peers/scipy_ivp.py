"""SciPy: `solve_ivp` with LSODA, BDF and Radau."""

from __future__ import annotations

import warnings

import numpy as np

from peers.base import Peer, PeerFailed
from peers.scaled import rates, rates_jacobian


class ScipyIvp(Peer):
    """`scipy.integrate.solve_ivp` with compiled right-hand side and Jacobian."""

    package = "scipy"

    def __init__(self, method: str) -> None:
        self.method, self.slow = method, method != "LSODA"

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        from scipy.integrate import solve_ivp

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                solution = solve_ivp(
                    lambda s, y: rates(row, s, y),
                    (0.0, phase),
                    begin,
                    method=self.method,
                    t_eval=[phase],
                    rtol=rtol,
                    atol=rtol,
                    jac=lambda s, y: rates_jacobian(row, s, y),
                )
            except ValueError as error:  # NaN in a linear system
                raise PeerFailed(str(error)) from error
        if not solution.success or not solution.y.size:
            raise PeerFailed(str(solution.message))
        return np.asarray(solution.y[:, -1])
