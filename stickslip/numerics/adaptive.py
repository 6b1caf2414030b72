"""The adaptive drive: steps of a Rosenbrock method under error control from one time to another."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stickslip.compiled import inline, jit
from stickslip.numerics.linear import Vector, add, finite, largest_ratio, with_signs
from stickslip.numerics.rosenbrock import defect_error, make_step
from stickslip.numerics.tableaus import RosenbrockTableau
from stickslip.status import Status

# How a drive can end, as plain integers for compiled code.
OK, STEP_LIMIT, DIVERGED = int(Status.OK), int(Status.STEP_LIMIT), int(Status.DIVERGED)

# Classical controller constants (Hairer & Wanner): aim below the tolerance so that few steps are
# rejected, and never change the step by more than an order of magnitude.
_SAFETY = 0.9
_GROWTH, _SHRINKAGE = 6.0, 0.1

# Weight of the end-point defect against the embedded estimate: on smooth problems the embedded
# one decides (docs/numerics.md has the measurement).
_DEFECT_WEIGHT = 0.25


@inline
def _step_factor(error: float) -> float:
    """Ratio of the next step to this one for an estimate of fourth order in the step."""
    return min(_GROWTH, max(_SHRINKAGE, _SAFETY / (max(error, 1e-12) ** 0.25)))


def make_adaptive(
    rhs: Callable[..., Vector],
    jacobian: Callable[..., tuple[Vector, Vector, Vector, Vector]],
    error_scale: Callable[..., Vector],
    observe: Callable[..., None],
    tableau: RosenbrockTableau,
) -> Any:
    """The adaptive drive of y' = rhs(p, t, y).

    `error_scale(p, y, J)` gives the size against which each component's error counts;
    `observe(p, t, h, y0, y1, d1, d2, record)` sees every accepted step.

    The drive maps (p, rtol, t0, t1, y, h, budget, record) to (y, h, steps, status): the state at
    t1, the step to go on with, the number of attempted steps, and OK, STEP_LIMIT or DIVERGED
    (not finite, or a step that underflows). Local errors are of order rtol; order 4(3).
    """
    step = make_step(rhs, tableau)
    gamma = tableau.gamma

    @jit
    def advance(
        p: Any, rtol: float, t0: float, t1: float, y: Vector, h: float, budget: int, record: Any
    ) -> tuple[Vector, float, int, int]:
        t, attempts, grow = t0, 0, True
        f, J = rhs(p, t, y), jacobian(p, t, y)
        while t < t1:
            if attempts >= budget:
                return y, h, attempts, STEP_LIMIT
            attempts += 1
            last = t + 1.0001 * h >= t1
            used = t1 - t if last else min(h, 0.5 * (t1 - t))  # no sliver is left for the end
            if not (last or t1 + used > t1):  # the step has shrunk to rounding, or is NaN
                return y, h, attempts, DIVERGED
            y1, error, d1, d2 = step(p, t, y, used, f, J)
            scale = error_scale(p, y, J)
            ratio = largest_ratio(error, scale) / rtol
            if ratio <= 1.0:
                f1, J1 = rhs(p, t + used, y1), jacobian(p, t + used, y1)
                blurred = jacobian(p, t + used, add(y1, rtol, with_signs(scale, f1)))
                rows = (blurred[0], blurred[1], blurred[2])
                defect = defect_error(f1, rows, y, y1, d1, d2, used, gamma)
                seen = _DEFECT_WEIGHT * largest_ratio(defect, scale) / rtol
                if not seen <= ratio:  # so that NaN counts
                    ratio = seen
            if ratio <= 1.0:
                observe(p, t, used, y, y1, d1, d2, record)
                t = t1 if last else t + used
                y, f, J = y1, f1, J1
                proposal = used * _step_factor(ratio)
                if not last or proposal < h:
                    h = proposal if grow else min(proposal, used)
                grow = True
            else:
                # NaN arrives here too: a quarter of the step may avoid the overflow.
                h = used * (_step_factor(ratio) if ratio == ratio else 0.25)
                grow = False
                if not finite(y):
                    return y, h, attempts, DIVERGED
        return y, h, attempts, OK

    return advance
