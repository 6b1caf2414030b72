"""The lower block between its springs: Eq. 3, and the energy of its motion.

All forces on it except friction are declared here: a new one is a term of `own_force`, its two
derivatives in `own_slopes`, and the power it dissipates in `own_loss`.
"""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.parameters import Parameters


@inline
def own_force(p: Parameters, x: float, v: float) -> float:
    """Force on the block other than friction [N]: that of the springs."""
    return -2.0 * p.spring_stiffness * x


@inline
def own_slopes(p: Parameters, x: float, v: float) -> tuple[float, float]:
    """Derivatives of `own_force` with respect to x [N/m] and v [N s/m]."""
    return -2.0 * p.spring_stiffness, 0.0


@inline
def own_loss(p: Parameters, x: float, v: float) -> float:
    """Power that the block dissipates other than by friction [W], at least 0."""
    return 0.0


@inline
def harmonic_force(p: Parameters, x: float, v: float) -> float:
    """Friction force [N] at the frequency of the drive, by the motion of the block.

    M d2x/dt2 minus the other forces, Eq. 3, with -omega^2 x for d2x/dt2: over a closed orbit they
    have the same first harmonic. It is as smooth as the motion, where F is not.
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
