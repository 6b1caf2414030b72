"""heyoka: Taylor's method of an order that fits the tolerance, compiled by LLVM for each point."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from peers.base import LADDER, Peer, PeerFailed
from peers.scaled import symbolic_rates
from stickslip.parameters import ParameterValues

_INDEX = ParameterValues._fields.index("rheological_index")


class HeyokaTaylor(Peer):
    """`heyoka.taylor_adaptive`: explicit, the fastest rate of a stiff film limits its steps.

    Compiled once for each rheological index and tolerance, with the other parameters left open.
    """

    package = "heyoka"
    ladder = LADDER[1::2]
    slow = True

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        integrator = _integrator(float(row[_INDEX]), rtol)
        integrator.pars[:] = row[: len(integrator.pars)]  # the last ones do not occur
        integrator.time = 0.0
        integrator.state[:] = begin
        integrator.propagate_until(phase)
        if integrator.time != phase:
            raise PeerFailed("does not get to the end")
        return np.array(integrator.state)


@cache
def _integrator(gamma: float, rtol: float) -> Any:
    import heyoka

    def chosen(condition: Any, yes: Any, no: Any) -> Any:
        return heyoka.select(condition, heyoka.expression(yes), heyoka.expression(no))

    def fabs(value: Any) -> Any:
        return chosen(heyoka.lt(value, heyoka.expression(0.0)), -value, value)

    def sign(value: Any) -> Any:
        return chosen(heyoka.lt(value, heyoka.expression(0.0)), -1.0, 1.0)

    def fmax(a: Any, b: Any) -> Any:
        return chosen(heyoka.lt(a, heyoka.expression(b)), b, a)

    ops = SimpleNamespace(exp=heyoka.exp, sin=heyoka.sin, fabs=fabs, sign=sign, fmax=fmax)
    values: list[Any] = [heyoka.par[i] for i in range(len(ParameterValues._fields))]
    values[_INDEX] = gamma
    y = list(heyoka.make_vars("x", "u", "psi"))
    rates = symbolic_rates(ops, ParameterValues(*values), heyoka.time, y)
    return heyoka.taylor_adaptive(list(zip(y, rates, strict=True)), [0.0] * len(y), tol=rtol)
