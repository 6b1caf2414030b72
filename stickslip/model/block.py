"""The lower block between its springs: Eq. 3, and the energy of its motion.

All forces on the block except friction are here. A new one needs a term in `own_force`, its two
derivatives in `own_slopes`, and its dissipated power in `own_loss`.
"""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.parameters import Parameters


@inline
def own_force(p: Parameters, x: float, v: float) -> float:
    """Force of the springs [N], the only one on the block except friction."""
    return -2.0 * p.spring_stiffness * x


@inline
def own_slopes(p: Parameters, x: float, v: float) -> tuple[float, float]:
    """Derivatives of `own_force` with respect to x [N/m] and v [N s/m]."""
    return -2.0 * p.spring_stiffness, 0.0


@inline
def own_loss(p: Parameters, x: float, v: float) -> float:
    """Power that the block dissipates without friction [W], not negative."""
    return 0.0


@inline
def harmonic_force(p: Parameters, x: float, v: float) -> float:
    """Friction force [N] at the frequency of the drive, from the motion of the block.

    It is M d2x/dt2 minus the other forces (Eq. 3), with -omega^2 x in place of d2x/dt2. Over a
    closed orbit both have the same first harmonic. It is as smooth as the motion, unlike F.
    """
    return -p.block_mass * (p.angular_frequency * p.angular_frequency) * x - own_force(p, x, v)


@inline
def energy(p: Parameters, x: float, v: float) -> float:
    """Energy of the block and its springs [J]: M v^2/2 + K x^2."""
    return 0.5 * p.block_mass * v**2 + p.spring_stiffness * x**2


@inline
def acceleration(p: Parameters, x: float, v: float, F: float) -> float:
    """Acceleration of the block [m/s2] under a friction force F [N], Eq. 3."""
    return (F + own_force(p, x, v)) / p.block_mass
