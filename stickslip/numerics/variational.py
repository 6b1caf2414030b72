"""One step of the variational equations w' = J(t) w, for the growth of small displacements.

Alexander's method (SIAM J. Numer. Anal. 14 (1977) 1006) is diagonally implicit, of third order and
L-stable, so that fast modes decay within a step as they do in a stiff motion. It needs J alone, at
three times of a step of the motion. The displacements are infinitesimal, so that no size has to be
chosen between the curvature of the map and the noise of the integrator.

A step across a cusp of the right-hand side samples the infinite slope at three points, or misses
it. But whatever the slope, the displacement along the motion is known exactly: its rate f obeys f'
= J f + df/dt. So a multiple of f moves with the motion, and J moves only the rest.
"""

from __future__ import annotations

from collections.abc import Callable

from stickslip.compiled.decorators import inline
from stickslip.numerics.linear import Algebra, Matrix, Vector

GAMMA = 0.4358665215084590
"""A root of x^3 - 3 x^2 + 3/2 x - 1/6."""

NODES = (GAMMA, 0.5 * (1.0 + GAMMA), 1.0)
"""The times at which a step needs the Jacobian, as fractions of the step."""

DAMPING = 1.0 / 24.0 - 0.5 * GAMMA + 1.5 * GAMMA**2 - GAMMA**3
"""The spurious damping of an oscillation of rate w in a step h is this number times (w h)^4, to
leading order; it is the logarithm of the amplitude."""

# The coefficients of the increments of earlier stages, over GAMMA.
_SECOND = 0.5 * (1.0 - GAMMA) / GAMMA
_THIRD = (
    -(6.0 * GAMMA**2 - 16.0 * GAMMA + 1.0) / 4.0 / GAMMA,
    (6.0 * GAMMA**2 - 20.0 * GAMMA + 5.0) / 4.0 / GAMMA,
)


@inline
def shift_of(h: float) -> float:
    """Return the shift for the factors of the Jacobians of a step of length `h`."""
    return 1.0 / (GAMMA * h)


def make_variational_step(algebra: Algebra) -> Callable[..., Vector]:
    """Return the inline function (w, share, f0, f1, shift, LUs, f_ts) that moves w over a step.

    The part `share` f0 of w moves with the motion, whose rates are f0 before and f1 after the step.
    LUs are the factors of shift*I - J at the NODES, from `Algebra.factor`; f_ts are df/dt there.
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
