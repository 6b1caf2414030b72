"""scikit-sundae: CVODE (BDF), which calls back into Python for a compiled right-hand side."""

from __future__ import annotations

import numpy as np

from peers.base import Peer, PeerFailed
from peers.scaled import fill_jacobian, fill_rates

_PLENTY = 100_000_000
_ATOL = 0.1  # in rtol
_MAX_ORDER = 3


class SksundaeCvode(Peer):
    """`sksundae.cvode.CVODE` with the compiled right-hand side and Jacobian.

    With orders above 3 its error test fails at the cusps of the paper's fluid at rtol 1e-5, 1e-6.
    """

    package = "scikit-sundae"
    slow = True

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        from sksundae.cvode import CVODE

        def rhs(s: float, y: np.ndarray, out: np.ndarray) -> None:
            fill_rates(row, s, y, out)

        def jacobian(s: float, y: np.ndarray, _: np.ndarray, out: np.ndarray) -> None:
            fill_jacobian(row, s, y, out)

        solver = CVODE(
            rhs,
            rtol=rtol,
            atol=_ATOL * rtol,
            jacfn=jacobian,
            max_order=_MAX_ORDER,
            max_num_steps=_PLENTY,
        )
        solution = solver.solve(np.array([0.0, phase]), begin)
        if not solution.success:
            raise PeerFailed(str(solution.message))
        return np.asarray(solution.y[-1])
