"""The adaptive integrator: error-controlled steps of a Rosenbrock method between two times."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from stickslip.compiled.decorators import jit
from stickslip.compiled.fields import make_map
from stickslip.numerics import step_control
from stickslip.numerics.linear import Algebra, Vector
from stickslip.numerics.rosenbrock import make_defect_error, make_step
from stickslip.numerics.tableaus import RosenbrockTableau
from stickslip.status import Status

# Outcomes of an integration, as plain integers for compiled code.
OK, STEP_LIMIT, DIVERGED = int(Status.OK), int(Status.STEP_LIMIT), int(Status.DIVERGED)


# A step below this fraction of the interval makes no progress, even from t = 0.
_LEAST_STEP = 1e-25


_undisturbed = make_map(
    "undisturbed", "p, t, h, y0, y1, f1, d1, d2, record", ("y1", "f1", "inf"), {"inf": math.inf}
)


def make_adaptive(
    rhs: Callable[..., Vector],
    jacobian: Callable[..., tuple[Vector, ...]],
    error_weight: Callable[..., Vector],
    observe: Callable[..., None],
    tableau: RosenbrockTableau,
    algebra: Algebra,
    disturb: Callable[..., tuple[Vector, Vector, float]] = _undisturbed,
    limits: Callable[..., tuple[float, float]] = step_control.unlimited,
) -> Any:
    """Return the adaptive integrator of y' = rhs(p, t, y).

    `error_weight(p, y, y1, J)` returns the weights of the errors of the components in a step from y
    to y1. `observe(p, t, h, y0, y1, d1, d2, record)` is called after every accepted step. After it,
    `disturb(p, t, h, y0, y1, f1, d1, d2, record)` may change the state: it returns the new state,
    its rates, and the largest length of the next step. `limits(p, y0, f0, y1, f1, h)` returns the
    allowed part of a step, less than 1 if the step would miss something, and the longest step after
    it; f0 and f1 are the rates at the ends.

    The integrator maps (p, rtol, t0, t1, y, h, budget, record) to (y, h, steps, status): the state
    at t1, the next step, the number of attempted steps, and OK, STEP_LIMIT or DIVERGED (not finite,
    or a step that underflows). Local errors are of order rtol; the method is of order 4(3).
    """
    step, defect_error = make_step(rhs, tableau, algebra), make_defect_error(algebra)
    largest, finite = algebra.largest, algebra.finite

    @jit
    def advance(
        p: Any, rtol: float, t0: float, t1: float, y: Vector, h: float, budget: int, record: Any
    ) -> tuple[Vector, float, int, int]:
        t, attempts, grow, remembered = t0, 0, True, step_control.START
        f, J = rhs(p, t, y), jacobian(p, t, y)
        while t < t1:
            if attempts >= budget:
                return y, h, attempts, STEP_LIMIT
            attempts += 1
            # A step that nearly reaches the end is stretched to it.
            last = t + 1.0001 * h >= t1
            used = t1 - t if last else min(h, 0.5 * (t1 - t))  # leaves no tiny last step
            # A step that has shrunk to rounding level, or is NaN.
            if not (last or (t + used > t and used > _LEAST_STEP * (t1 - t0))):
                return y, h, attempts, DIVERGED
            y1, error, d1, d2, LU = step(p, t, y, used, f, J)
            weight = error_weight(p, y, y1, J)
            ratio = largest(error, weight) / rtol
            part, ahead = 1.0, math.inf
            if ratio <= 1.0:
                # The defect reveals what the embedded error misses, a cusp inside the step.
                f1 = rhs(p, t + used, y1)
                defect = largest(defect_error(f1, LU, y, y1, d1, d2, used), weight) / rtol
                if not defect <= ratio:  # true for NaN
                    ratio = defect
                part, ahead = limits(p, y, f, y1, f1, used)
            if ratio <= 1.0 and part >= 1.0:
                observe(p, t, used, y, y1, d1, d2, record)
                y, f, longest = disturb(p, t, used, y, y1, f1, d1, d2, record)
                t = t1 if last else t + used
                J = jacobian(p, t, y)
                factor, remembered = step_control.after_success(ratio, remembered)
                proposal = used * factor
                # The last step was cut, so that its small error is no reason for a longer next one.
                if not last or proposal < h:
                    h = proposal if grow else min(proposal, used)
                h = min(h, longest, ahead)
                grow = True
            else:
                h = used * (part if part < 1.0 else step_control.after_rejection(ratio))
                grow = False
                if not finite(y):
                    return y, h, attempts, DIVERGED
        return y, h, attempts, OK

    return advance
