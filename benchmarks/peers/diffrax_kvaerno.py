"""diffrax: Kvaerno5, an implicit Runge-Kutta method, compiled by JAX for the processor."""

from __future__ import annotations

import os
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from peers.base import Peer, PeerFailed
from peers.scaled import symbolic_rates
from stickslip.parameters import ParameterValues

_MOST_STEPS = 10_000_000
_INDEX = ParameterValues._fields.index("rheological_index")


class DiffraxKvaerno5(Peer):
    """`diffrax.diffeqsolve` with Kvaerno5 and a PI controller, in double precision."""

    package = "diffrax"
    slow = True

    def integrate(
        self, row: np.ndarray, begin: np.ndarray, phase: float, rtol: float
    ) -> np.ndarray:
        """See Peer."""
        end, success = _solve(float(row[_INDEX]))(row, begin, phase, rtol)
        if not bool(success):
            raise PeerFailed("diffeqsolve reports no success")
        return np.asarray(end)


@cache
def _solve(gamma: float) -> Any:
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    jnp = jax.numpy
    ops = SimpleNamespace(exp=jnp.exp, sin=jnp.sin, fabs=jnp.abs, sign=jnp.sign, fmax=jnp.maximum)

    def rates(s: Any, y: Any, row: Any) -> Any:
        values = [row[i] for i in range(len(ParameterValues._fields))]
        values[_INDEX] = gamma
        return jnp.stack(symbolic_rates(ops, ParameterValues(*values), s, y))

    @jax.jit
    def solve(row: Any, begin: Any, phase: Any, rtol: Any) -> Any:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(rates),
            diffrax.Kvaerno5(),
            t0=0.0,
            t1=phase,
            dt0=None,
            y0=begin,
            args=row,
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=rtol),
            saveat=diffrax.SaveAt(t1=True),
            max_steps=_MOST_STEPS,
            throw=False,
            adjoint=diffrax.ForwardMode(),
        )
        return solution.ys[-1], solution.result == diffrax.RESULTS.successful

    return solve
