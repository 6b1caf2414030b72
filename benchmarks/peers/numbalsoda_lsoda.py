"""numbalsoda: LSODA in C++, called with a compiled right-hand side."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from peers.base import LADDER, Peer, PeerFailed
from peers.scaled import FLAGS, fill_rates
from stickslip.parameters import Parameters

# Steps between two outputs from which a run counts as stuck: a period takes up to 1e4 of them, and
# at tight tolerances LSODA may go on for ever with steps of no length.
MOST_STEPS = 2_000_000

_PARAMETERS = len(Parameters._fields)


class NumbalsodaLsoda(Peer):
    """`numbalsoda.lsoda`; it takes one absolute tolerance and no Jacobian.

    In scaled variables atol = rtol came out best of 0.001 to 10 rtol and of four scales of ln phi:
    the others are not faster at equal error, and fail on more points at loose tolerances. It fails
    on more and more points of the paper's fluid below rtol 1e-8, hence 5e-9 in its ladder, and
    needs 1e-10 for an error of 1e-8 with the others.
    """

    package = "numbalsoda"
    ladder = tuple(sorted({*LADDER, 5e-9, 1e-10}, reverse=True))
    slow = False

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        states, success = compiled_lsoda()(
            right_hand_side(), begin, np.array([0.0, phase]), row, rtol, rtol, MOST_STEPS
        )
        if not success:
            raise PeerFailed("LSODA reports no success")
        return np.asarray(states[-1])


@cache
def right_hand_side() -> int:
    """Return address of the compiled right-hand side."""
    return int(_callback().address)


@cache
def compiled_lsoda() -> Any:
    """Return `numbalsoda.lsoda` itself, which compiled functions can call."""
    from numbalsoda import lsoda

    return lsoda


@cache
def _callback() -> Any:
    from numba import carray, cfunc
    from numbalsoda import lsoda_sig

    @cfunc(lsoda_sig, **FLAGS)
    def callback(s, y, out, row):
        fill_rates(carray(row, (_PARAMETERS,)), s, carray(y, (3,)), carray(out, (3,)))

    return callback
