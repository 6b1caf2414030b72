"""Vectors of three components and their linear systems, unrolled: the states live in registers."""

from __future__ import annotations

from stickslip.compiled.decorators import inline

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]


@inline
def add(y: Vector, s: float, k: Vector) -> Vector:
    """y + s k."""
    return y[0] + s * k[0], y[1] + s * k[1], y[2] + s * k[2]


@inline
def larger(a: float, b: float) -> float:
    """The larger of two numbers as one instruction; the second one where either is NaN."""
    return a if a > b else b


@inline
def largest(error: Vector, weight: Vector) -> float:
    """max |error_i| weight_i; NaN where any component is NaN."""
    a, b, c = abs(error[0]) * weight[0], abs(error[1]) * weight[1], abs(error[2]) * weight[2]
    return larger(larger(a, b), c) + 0.0 * (a + b + c)  # a comparison may drop a NaN, a sum not


@inline
def finite(y: Vector) -> bool:
    """Whether all components are finite."""
    return 0.0 * (y[0] + y[1] + y[2]) == 0.0


@inline
def factor(J: Matrix, shift: float) -> Matrix:
    """LU factors of shift*I - J without pivoting, with reciprocal pivots on the diagonal.

    No pivoting, because the shift dominates where a step is acceptable; where it does not, the
    step is poor anyway and its error estimate rejects it.
    """
    (a, b, c), (d, e, f), (g, h, i) = J
    p0 = 1.0 / (shift - a)
    l10, l20 = -d * p0, -g * p0
    p1 = 1.0 / (shift - e + l10 * b)
    u12 = -f + l10 * c
    l21 = (-h + l20 * b) * p1
    p2 = 1.0 / (shift - i + l20 * c - l21 * u12)
    return (p0, -b, -c), (l10, p1, u12), (l20, l21, p2)


@inline
def solve(LU: Matrix, r: Vector) -> Vector:
    """Solution of the factored system for the right-hand side `r`."""
    (p0, u01, u02), (l10, p1, u12), (l20, l21, p2) = LU
    r1 = r[1] - l10 * r[0]
    r2 = r[2] - l20 * r[0] - l21 * r1
    z = r2 * p2
    y = (r1 - u12 * z) * p1
    x = (r[0] - u01 * y - u02 * z) * p0
    return x, y, z
