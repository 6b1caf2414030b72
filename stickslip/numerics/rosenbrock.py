"""One step of a six-stage Rosenbrock method, its error estimates and its continuous extension."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_map
from stickslip.numerics.linear import Algebra, Matrix, Vector
from stickslip.numerics.tableaus import RosenbrockTableau


def make_defect_error(algebra: Algebra) -> Any:
    """Return the function (f1, LU, y0, y1, d1, d2, h) of the defect error of a step, a vector.

    Defect control (Enright 1989): a linearly implicit step takes all slopes of the function from
    the Jacobian at the start. At the end of the step the slope of the continuous extension,
    compared with the function, shows what the step missed. The filter (I - h gamma J)^-1 keeps the
    estimate bounded for stiff components. Its order is that of the continuous extension, which
    equals the embedded order. It fails if the Jacobian at the start is huge in a small
    neighbourhood only, so functions must be smooth on the scale of the tolerance
    (docs/decisions/integrator.md).
    """
    end_slope, solve = algebra.end_slope, algebra.solve

    @inline
    def defect_error(
        f1: Vector, LU: Matrix, y0: Vector, y1: Vector, d1: Vector, d2: Vector, h: float
    ) -> Vector:
        return solve(LU, end_slope(f1, y0, y1, d1, d2, h))

    return defect_error


def make_step(rhs: Callable[..., Vector], tableau: RosenbrockTableau, algebra: Algebra) -> Any:
    """Return the function that takes one step of `tableau` (six stages) for y' = rhs(p, t, y).

    The step maps (p, t, y, h, f, J) with f = rhs(p, t, y) and J = (rows of df/dy, df/dt) to
    (y1, error, d1, d2, LU): the new state, the embedded error, the coefficients of `interpolate`
    and the factored matrix. It needs five further evaluations of rhs and one factorisation.
    """
    gamma = tableau.gamma
    (a21,), (a31, a32), (a41, a42, a43), (a51, a52, a53, a54), _ = tableau.a[1:]
    (c21,), (c31, c32), (c41, c42, c43), (c51, c52, c53, c54) = tableau.C[1:5]
    c61, c62, c63, c64, c65 = tableau.C[5]
    _, t2, t3, t4, _, _ = tableau.c
    g1, g2, g3, g4, _, _ = tableau.d
    (p1, p2, p3, p4, p5), (q1, q2, q3, q4, q5) = tableau.dense
    add, factor, solve, zeros = algebra.add, algebra.factor, algebra.solve, algebra.zero
    rows_of = make_map("rows", "J", (f"J[{i}]" for i in range(algebra.width)), {})
    width = algebra.width

    @inline
    def step(
        p: Any, t: float, y: Vector, h: float, f: Vector, J: tuple[Vector, ...]
    ) -> tuple[Vector, Vector, Vector, Vector, Matrix]:
        f_t = J[width]
        LU = factor(rows_of(J), 1.0 / (h * gamma))
        i = 1.0 / h
        u1 = solve(LU, add(f, h * g1, f_t))

        f2 = rhs(p, t + t2 * h, add(y, a21, u1))
        u2 = solve(LU, add(add(f2, c21 * i, u1), h * g2, f_t))

        f3 = rhs(p, t + t3 * h, add(add(y, a31, u1), a32, u2))
        u3 = solve(LU, add(add(add(f3, c31 * i, u1), c32 * i, u2), h * g3, f_t))

        f4 = rhs(p, t + t4 * h, add(add(add(y, a41, u1), a42, u2), a43, u3))
        r4 = add(add(add(f4, c41 * i, u1), c42 * i, u2), c43 * i, u3)
        u4 = solve(LU, add(r4, h * g4, f_t))

        y5 = add(add(add(add(y, a51, u1), a52, u2), a53, u3), a54, u4)
        f5 = rhs(p, t + h, y5)
        r5 = add(add(add(add(f5, c51 * i, u1), c52 * i, u2), c53 * i, u3), c54 * i, u4)
        u5 = solve(LU, r5)

        y6 = add(y5, 1.0, u5)
        f6 = rhs(p, t + h, y6)
        r6 = add(add(add(f6, c61 * i, u1), c62 * i, u2), c63 * i, u3)
        u6 = solve(LU, add(add(r6, c64 * i, u4), c65 * i, u5))

        zero = zeros()
        d1 = add(add(add(add(add(zero, p1, u1), p2, u2), p3, u3), p4, u4), p5, u5)
        d2 = add(add(add(add(add(zero, q1, u1), q2, u2), q3, u3), q4, u4), q5, u5)
        return add(y6, 1.0, u6), u6, d1, d2, LU

    return step
