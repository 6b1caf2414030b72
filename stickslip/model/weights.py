"""Weights of the errors of state variables, by which the step is controlled."""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import drive, film, noise
from stickslip.parameters import Parameters

# An error of the velocity also counts by the error of the force that it causes, relative to this
# many times the force that locks the block: a locked block follows the drive to parts in 1e5, and
# its slip must be right, not just its speed.
_FORCE_WEIGHT = 20.0
LARGEST_AT_CUSP = 100.0

# Where the noise sustains ln(phi), an error decays at the rate 2 D_eff/phi^2. It counts less there,
# by this many times that rate over the film's own, but at least a thousandth.
_FORGETTING_WEIGHT, _LARGEST_RELIEF = 10.0, 1000.0
_SLOWEST_FILM = 100.0  # rates omega


@inline
def force_weight(p: Parameters, change: float) -> float:
    """Weight of an error that changes the friction force by `change` [N]."""
    X_m, V_m = drive.largest_displacement(p), drive.acceleration_speed(p)
    # The sum of the forces of springs and inertia of a locked block.
    locking = 2.0 * p.spring_stiffness * X_m + p.block_mass * p.angular_frequency * V_m
    return change / (_FORCE_WEIGHT * locking)


@inline
def film_weight(p: Parameters, psi: float) -> float:
    """Weight of an error of ln(phi)."""
    _, inverse_phi = exponentials(psi)
    forgetting = _FORGETTING_WEIGHT * (2.0 * noise.typical_path(p, inverse_phi))
    own = _SLOWEST_FILM * p.angular_frequency + p.kinetic_coefficient * abs(film.heating(p))
    most = _LARGEST_RELIEF * own
    forgetting = most if forgetting > most else forgetting
    return own / ((1.0 + abs(psi)) * (own + forgetting))
