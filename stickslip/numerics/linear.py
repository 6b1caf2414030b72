"""Vectors of three components and their linear systems, unrolled: the states live in registers."""

from __future__ import annotations

import math

from stickslip.compiled import inline

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]


@inline
def add(y: Vector, s: float, k: Vector) -> Vector:
    """y + s k."""
    return y[0] + s * k[0], y[1] + s * k[1], y[2] + s * k[2]


@inline
def largest_ratio(error: Vector, scale: Vector) -> float:
    """max |error_i|/scale_i; NaN where any component is NaN."""
    first, second, third = (
        abs(error[0]) / scale[0],
        abs(error[1]) / scale[1],
        abs(error[2]) / scale[2],
    )
    largest = max(first, max(second, third))
    return largest + 0.0 * (first + second + third)  # max() may drop a NaN, a sum does not


@inline
def with_signs(size: Vector, direction: Vector) -> Vector:
    """Components of `size` with the signs of `direction`: where that points, mirrors with it."""
    return (
        math.copysign(size[0], direction[0]),
        math.copysign(size[1], direction[1]),
        math.copysign(size[2], direction[2]),
    )


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
