"""Unrolled vectors of a few components, and their linear systems, which stay in registers.

One source serves any number of components. Numba compiles no loop over a tuple, so the source of
each function is generated for a width, with every component written out.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_function, make_map

Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]


@inline
def larger(a: float, b: float) -> float:
    """Return the larger of two numbers in one instruction, or the second if one of them is NaN."""
    return a if a > b else b


class Algebra(NamedTuple):
    """Operations on vectors of one width; inline functions."""

    width: int

    add: Callable[[Vector, float, Vector], Vector]
    """(y, s, k): y + s k."""

    zero: Callable[[], Vector]
    """(): the vector of zeros."""

    largest: Callable[[Vector, Vector], float]
    """(error, weight): max |error_i| weight_i; NaN if a component is NaN."""

    finite: Callable[[Vector], bool]
    """(y): whether all components are finite."""

    factor: Callable[[Matrix, float], Matrix]
    """(J, shift): LU factors of shift*I - J, with reciprocal pivots on the diagonal. It does not
    exchange rows, because the shift dominates in an acceptable step; in any other step the error
    estimate rejects the result."""

    solve: Callable[[Matrix, Vector], Vector]
    """(LU, r): the solution of the factored system for the right-hand side r."""

    interpolate: Callable[[float, Vector, Vector, Vector, Vector], Vector]
    """(theta, y0, y1, d1, d2): the state at the fraction theta of a step, to third order."""

    end_slope: Callable[..., Vector]
    """(f1, y0, y1, d1, d2, h): f1 minus the slope of the continuous extension at the end of a step
    of length h."""

    choose: Callable[[bool, Vector, Vector], Vector]
    """(condition, a, b): a if the condition holds, else b; without a branch."""


@cache
def algebra(width: int) -> Algebra:
    """Return the operations on vectors of this width."""
    each = range(width)

    def vector(name: str, arguments: str, component: str, **names: Any) -> Any:
        written = (component.format(i=i) for i in each)
        return make_map(f"{name}[{width}]", arguments, written, names)

    return Algebra(
        width=width,
        add=vector("add", "y, s, k", "y[{i}] + s * k[{i}]"),
        zero=vector("zero", "", "0.0"),
        largest=_make_largest(width),
        finite=_make_finite(width),
        factor=_make_factor(width),
        solve=_make_solve(width),
        interpolate=vector(
            "interpolate",
            "theta, y0, y1, d1, d2",
            "(1.0 - theta) * y0[{i}]"
            " + theta * (y1[{i}] + (1.0 - theta) * (d1[{i}] + theta * d2[{i}]))",
        ),
        end_slope=vector(
            "end_slope",
            "f1, y0, y1, d1, d2, h",
            "f1[{i}] - (y1[{i}] - y0[{i}] - d1[{i}] - d2[{i}]) / h",
        ),
        choose=vector("choose", "condition, a, b", "a[{i}] if condition else b[{i}]"),
    )


def _make_largest(width: int) -> Any:
    sizes = make_map(f"sizes[{width}]", "e, w", (f"abs(e[{i}]) * w[{i}]" for i in range(width)), {})
    chain = "a[0]"
    for i in range(1, width):
        chain = f"larger({chain}, a[{i}])"
    total = " + ".join(f"a[{i}]" for i in range(width))
    # A comparison may drop a NaN, a sum does not.
    found = make_map(f"largest[{width}]", "a", [f"{chain} + 0.0 * ({total})"], {"larger": larger})

    @inline
    def largest(error: Vector, weight: Vector) -> float:
        return found(sizes(error, weight))[0]

    return largest


def _make_finite(width: int) -> Any:
    total = " + ".join(f"y[{i}]" for i in range(width))
    found = make_map(f"finite[{width}]", "y", [f"0.0 * ({total}) == 0.0"], {})

    @inline
    def finite(y: Vector) -> bool:
        return found(y)[0]

    return finite


def _make_factor(width: int) -> Any:
    """Return `Algebra.factor`; the entries of a row follow from the rows above."""

    def less_known(i: int, j: int, diagonal: str = "") -> str:
        known = range(min(i, j))
        return diagonal + f"-J[{i}][{j}]" + "".join(f" - l{i}{k} * u{k}{j}" for k in known)

    lines = []
    for i in range(width):
        lines += [f"l{i}{j} = ({less_known(i, j)}) * p{j}" for j in range(i)]
        lines.append(f"p{i} = 1.0 / ({less_known(i, i, 'shift ')})")
        lines += [f"u{i}{j} = {less_known(i, j)}" for j in range(i + 1, width)]
    rows = [
        [f"l{i}{j}" if j < i else f"p{i}" if j == i else f"u{i}{j}" for j in range(width)]
        for i in range(width)
    ]
    return _written(f"factor[{width}]", "J, shift", lines, rows)


def _make_solve(width: int) -> Any:
    lines = [
        f"r{i} = r[{i}]" + "".join(f" - LU[{i}][{k}] * r{k}" for k in range(i))
        for i in range(width)
    ]
    for i in reversed(range(width)):
        above = "".join(f" - LU[{i}][{k}] * x{k}" for k in range(i + 1, width))
        lines.append(f"x{i} = (r{i}{above}) * LU[{i}][{i}]")
    return _written(f"solve[{width}]", "LU, r", lines, [f"x{i}" for i in range(width)])


def _written(name: str, arguments: str, lines: list[str], result: list[Any]) -> Any:
    """Return an inline function from its lines; its result is a tuple, or a tuple of tuples."""
    rows = [f"({', '.join(row)},)" if isinstance(row, list) else row for row in result]
    return make_function(name, arguments, [*lines, f"return ({', '.join(rows)},)"], {})
