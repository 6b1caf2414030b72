"""The fixed-step integrator: Euler-Cromer for a position, its velocity and a third variable."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stickslip.compiled.decorators import inline, jit
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.linear import Vector, algebra

# A check for NaN after every step would cost as much as the step.
_STEPS_BETWEEN_CHECKS = 4096

_finite = algebra(3).finite


@inline
def _no_draw(record: Any) -> float:
    return 0.0


def make_euler_cromer(
    increments: Callable[..., tuple[float, float]],
    observe: Callable[..., None],
    draw: Callable[..., float] = _no_draw,
) -> Any:
    """Return the Euler-Cromer integrator of the state (x, v, w), as in the paper.

    `increments(p, t, dt, y, xi)` returns the increments of v and w in a step from the old state; x
    then moves with the *new* v, and w is reflected at 0. `observe(p, t, dt, y0, y1, record)` is
    called after every step; `draw(record)` returns the random number xi of the next step.

    The integrator maps (p, t0, t1, steps, y, budget, record) to (y, done, status) in `steps` equal
    steps. It ends with OK, STEP_LIMIT, or DIVERGED, within 4096 steps after the state stopped being
    finite. The method is of order 1, and stable only for steps below 2/(fastest rate), which is not
    checked here.
    """

    @jit
    def advance(
        p: Any, t0: float, t1: float, steps: int, y: Vector, budget: int, record: Any
    ) -> tuple[Vector, int, int]:
        dt = (t1 - t0) / steps
        x, v, w = y
        for done in range(steps):
            if done % _STEPS_BETWEEN_CHECKS == 0 and not _finite((x, v, w)):
                return (x, v, w), done, DIVERGED
            if done >= budget:
                return (x, v, w), done, STEP_LIMIT
            t = t0 + done * dt
            dv, dw = increments(p, t, dt, (x, v, w), draw(record))
            old = (x, v, w)
            v += dv
            x += dt * v
            w = abs(w + dw)
            observe(p, t, dt, old, (x, v, w), record)
        return (x, v, w), steps, OK if _finite((x, v, w)) else DIVERGED

    return advance
