"""One step of the variational equations w' = J(t) w: how a small displacement moves along.

Alexander's method (SIAM J. Numer. Anal. 14 (1977) 1006): diagonally implicit, of third order, and
L-stable, so that what a stiff motion forgets within a step is forgotten. It needs J alone, at three
times of a step that the motion has taken, and follows infinitesimal displacements: no size of a
displacement has to be chosen between the curvature of the map and the noise of the integrator.

A step that crosses a cusp of the right-hand side sees its infinite slope at three points, or not at
all. But one displacement is known exactly there, whatever the slope: along the motion itself, whose
rate f obeys f' = J f + df/dt. So a multiple of f is moved with the motion, and only the rest by J.
"""

from __future__ import annotations

from collections.abc import Callable

from stickslip.compiled.decorators import inline
from stickslip.numerics.linear import Algebra, Matrix, Vector

GAMMA = 0.4358665215084590
"""A root of x^3 - 3 x^2 + 3/2 x - 1/6."""

NODES = (GAMMA, 0.5 * (1.0 + GAMMA), 1.0)
"""The times of a step at which the Jacobian is needed, as fractions of it."""

# Coefficients of the increments of earlier stages, over GAMMA.
_SECOND = 0.5 * (1.0 - GAMMA) / GAMMA
_THIRD = (
    -(6.0 * GAMMA**2 - 16.0 * GAMMA + 1.0) / 4.0 / GAMMA,
    (6.0 * GAMMA**2 - 20.0 * GAMMA + 5.0) / 4.0 / GAMMA,
)


@inline
def shift_of(h: float) -> float:
    """The shift with which the Jacobians of a step of length `h` are factored."""
    return 1.0 / (GAMMA * h)


def make_variational_step(algebra: Algebra) -> Callable[..., Vector]:
    """Return the inline function (w, share, f0, f1, shift, LUs, f_ts) that takes w over a step.

    `share` times f0 of w is moved with the motion, whose rates are f0 before and f1 after the step.
    LUs are the factors of shift*I - J at the NODES, `Algebra.factor`, and f_ts df/dt there.
    """
    add, solve, zero = algebra.add, algebra.solve, algebra.zero

    @inline
    def stage(LU: Matrix, f_t: Vector, shift: float, share: float, r: Vector) -> Vector:
        return solve(LU, add(add(zero(), shift, r), -share, f_t))

    @inline
    def step(
        w: Vector,
        share: float,
        f0: Vector,
        f1: Vector,
        shift: float,
        LUs: tuple[Matrix, Matrix, Matrix],
        f_ts: tuple[Vector, Vector, Vector],
    ) -> Vector:
        r1 = add(w, -share, f0)
        k1 = add(stage(LUs[0], f_ts[0], shift, share, r1), -1.0, r1)
        r2 = add(r1, _SECOND, k1)
        k2 = add(stage(LUs[1], f_ts[1], shift, share, r2), -1.0, r2)
        r3 = add(add(r1, _THIRD[0], k1), _THIRD[1], k2)
        return add(stage(LUs[2], f_ts[2], shift, share, r3), share, f1)

    return step
