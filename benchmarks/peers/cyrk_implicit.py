"""CyRK: BDF, LSODA and Radau in C++, called with a compiled right-hand side."""

from __future__ import annotations

from functools import cache

import numpy as np

from peers.base import Peer, PeerFailed
from peers.scaled import fill_rates
from stickslip.parameters import Parameters

_PLENTY = 100_000_000
_PARAMETERS = len(Parameters._fields)


class Cyrk(Peer):
    """`CyRK.nbsolve2_ivp` with one of its implicit methods; it takes no Jacobian."""

    package = "CyRK"

    def __init__(self, method: str) -> None:
        self.method, self.slow = method, method != "LSODA"

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        from CyRK import nbsolve2_ivp

        ends = np.array([phase])  # one output: otherwise every step is kept
        result = nbsolve2_ivp(
            _right_hand_side(), (0.0, phase), begin,
            method=self.method, t_eval=ends, args=row, rtol=rtol, atol=rtol,
            max_num_steps=_PLENTY,
        )  # fmt: skip
        try:
            if not result.success:
                raise PeerFailed(str(result.message))
            return np.array(result.y[:, -1])
        finally:
            result.free()


@cache
def _right_hand_side() -> int:
    """Return address of the compiled right-hand side, which is kept."""
    return int(_callback().address)


@cache
def _callback():
    from CyRK import cyjit
    from numba import carray

    @cyjit
    def callback(out, s, y, row):
        fill_rates(carray(row, (_PARAMETERS,)), s, carray(y, (3,)), carray(out, (3,)))

    return callback
