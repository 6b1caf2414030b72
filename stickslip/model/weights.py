"""How much an error of a state variable counts: the weights that a step is controlled by."""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import drive, film, noise
from stickslip.parameters import Parameters

# An error of the velocity counts also by the error of the force that it makes, against this many
# times the force that locks the block: a locked block moves with the drive to parts in 1e5, and its
# slip must be right, not just its speed.
_FORCE_WEIGHT = 20.0
LARGEST_AT_CUSP = 100.0

# Where the noise holds ln(phi) up, it forgets an error at the rate 2 D_eff/phi^2. The error counts
# less there, by this many times that rate over the film's own, but at least a thousandth.
_FORGETTING_WEIGHT, _LARGEST_RELIEF = 10.0, 1000.0
_SLOWEST_FILM = 100.0  # rates omega


@inline
def force_weight(p: Parameters, change: float) -> float:
    """The weight of an error that changes the friction force by `change` [N]."""
    X_m, V_m = abs(p.drive_amplitude), drive.largest_speed(p)
    # The sum of the forces that springs and inertia of a locked block need.
    locking = 2.0 * p.spring_stiffness * X_m + p.block_mass * p.angular_frequency * V_m
    return change / (_FORCE_WEIGHT * locking)


@inline
def film_weight(p: Parameters, psi: float) -> float:
    """The weight of an error of ln(phi)."""
    _, inverse_phi = exponentials(psi)
    forgetting = _FORGETTING_WEIGHT * (2.0 * noise.typical_path(p, inverse_phi))
    own = _SLOWEST_FILM * p.angular_frequency + p.kinetic_coefficient * abs(film.heating(p))
    most = _LARGEST_RELIEF * own
    forgetting = most if forgetting > most else forgetting
    return own / ((1.0 + abs(psi)) * (own + forgetting))
