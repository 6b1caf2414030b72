"""The generic integrator on the stiff test set of Hairer and Wanner.

Those of at most three unknowns, with the solutions published with the set (E. Hairer, G. Wanner,
*Solving Ordinary Differential Equations II*, section IV.10; the test set for IVP solvers has the
digits).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from inside.scalar import generic_drive

from stickslip.compiled.decorators import inline

TOLERANCES = tuple(float(f"1e-{i}") for i in range(2, 11))


class Problem(NamedTuple):
    """y' = rhs from `start` at t = 0; `solution` at the time `end`; the least size that counts."""

    rhs: Any
    jacobian: Any
    start: tuple[float, ...]
    end: float
    solution: tuple[float, ...]
    sizes: tuple[float, ...]


@inline
def _van_der_pol(p: Any, t: float, y: Any) -> Any:
    return y[1], ((1.0 - y[0] * y[0]) * y[1] - y[0]) * 1e6


@inline
def _van_der_pol_jacobian(p: Any, t: float, y: Any) -> Any:
    return (0.0, 1.0), ((-2.0 * y[0] * y[1] - 1.0) * 1e6, (1.0 - y[0] * y[0]) * 1e6), (0.0, 0.0)


@inline
def _robertson(p: Any, t: float, y: Any) -> Any:
    slow, fast, quadratic = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] * y[1]
    return fast - slow, slow - fast - quadratic, quadratic


@inline
def _robertson_jacobian(p: Any, t: float, y: Any) -> Any:
    return (
        (-0.04, 1e4 * y[2], 1e4 * y[1]),
        (0.04, -1e4 * y[2] - 6e7 * y[1], -1e4 * y[1]),
        (0.0, 6e7 * y[1], 0.0),
        (0.0, 0.0, 0.0),  # no explicit time
    )


@inline
def _orego(p: Any, t: float, y: Any) -> Any:
    return (
        77.27 * (y[1] + y[0] * (1.0 - 8.375e-6 * y[0] - y[1])),
        (y[2] - (1.0 + y[0]) * y[1]) / 77.27,
        0.161 * (y[0] - y[2]),
    )


@inline
def _orego_jacobian(p: Any, t: float, y: Any) -> Any:
    return (
        (77.27 * (1.0 - 2.0 * 8.375e-6 * y[0] - y[1]), 77.27 * (1.0 - y[0]), 0.0),
        (-y[1] / 77.27, -(1.0 + y[0]) / 77.27, 1.0 / 77.27),
        (0.161, 0.0, -0.161),
        (0.0, 0.0, 0.0),
    )


PROBLEMS = {
    "Van der Pol, mu = 1e6": Problem(
        _van_der_pol, _van_der_pol_jacobian, (2.0, 0.0), 2.0,
        (0.1706167732170483e1, -0.8928097010247975), (1e-3, 1e-3),
    ),
    "Robertson": Problem(
        _robertson, _robertson_jacobian, (1.0, 0.0, 0.0), 1e11,
        (0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050), (1e-8, 1e-14, 1e-3),
    ),
    "OREGO": Problem(
        _orego, _orego_jacobian, (1.0, 2.0, 3.0), 360.0,
        (0.1000814870318523e1, 0.1228178521549917e4, 0.1320554942846706e3), (1e-3, 1e-3, 1e-3),
    ),
}  # fmt: skip


def run(quick: bool) -> dict[str, Any]:
    """Return the largest relative error of a component at each tolerance, and the steps."""
    tolerances = TOLERANCES[::3] if quick else TOLERANCES
    return {"problems": {name: _ladder(each, tolerances) for name, each in PROBLEMS.items()}}


def _ladder(problem: Problem, tolerances: tuple[float, ...]) -> list[dict[str, Any]]:
    drive, found = generic_drive(problem.rhs, problem.jacobian, problem.sizes), []
    for rtol in tolerances:
        y, _, steps, status = drive(0, rtol, 0.0, problem.end, problem.start, 1e-4, 10**7, 0)
        error = np.abs(np.array(y) / problem.solution - 1.0).max()
        found.append(
            {"rtol": rtol, "error": float(error), "steps": int(steps), "status": int(status)}
        )
    return found
