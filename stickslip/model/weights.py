"""Control of the step: the weights of errors of the state variables, and limits of its length."""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import drive, film, noise, solids
from stickslip.parameters import Parameters

# An error of the velocity also counts by the error of the force that it causes, relative to this
# many times the force that locks the block. A locked block follows the drive to parts in 1e5, and
# its slip must be accurate, not just its speed.
_FORCE_WEIGHT = 20.0
LARGEST_AT_CUSP = 100.0

# Where the noise sustains ln(phi), an error decays at the rate 2 D_eff/phi^2. It counts less there,
# by the first number times this rate over the rate of the film, but never less than a thousandth.
_FORGETTING_WEIGHT, _LARGEST_RELIEF = 10.0, 1000.0
_SLOWEST_FILM = 100.0  # in units of omega

# The largest error of ln(phi) in a step, above which D_eff/phi^2 is no longer linear in it. An
# error that left the film far above the noise level would force the integrator to follow it down
# at the full rate of melting, with steps that may be shorter than the rounding of time.
_LARGEST_ERROR = 0.5

# A liquid film may freeze while its strain passes through zero. Below the first number of
# solidification strains a step may change the strain by no more than the second number of them,
# unless the order parameter can grow by less than the third number of e-folds in the whole passage.
_NEAR_PASSAGE, _STRIDE, _LEAST_GROWTH = 2.0, 1.0, 1.0


@inline
def _growth_at_unit_rate(p: Parameters) -> float:
    """Growth of ln(phi) while the strain passes through zero, times the rate of the strain [1/s].

    B of Eq. 15 is a parabola in time: the growth is 4/3 of the rate at rest times the time from the
    solidification strain to zero.
    """
    rate = -p.kinetic_coefficient * film.heating(p)
    return 4.0 / 3.0 * rate * solids.solidification_strain(p)


@inline
def force_weight(p: Parameters, change: float) -> float:
    """Weight of an error that changes the friction force by `change` [N]."""
    X_m, V_m = drive.largest_displacement(p), drive.acceleration_speed(p)
    # The sum of the forces of springs and inertia of a locked block.
    locking = 2.0 * p.spring_stiffness * X_m + p.block_mass * p.angular_frequency * V_m
    return change / (_FORCE_WEIGHT * locking)


@inline
def film_weight(p: Parameters, rtol: float, psi: float, eps0: float, eps1: float) -> float:
    """Weight of an error of ln(phi) in a step that begins at `psi`, between two strains."""
    _, inverse_phi = exponentials(psi)
    forgetting = _FORGETTING_WEIGHT * (2.0 * noise.typical_path(p, inverse_phi))
    own = _SLOWEST_FILM * p.angular_frequency + p.kinetic_coefficient * abs(film.heating(p))
    most = _LARGEST_RELIEF * own
    forgetting = most if forgetting > most else forgetting
    # If the film may freeze at either end of the step, errors no longer decay: B is negative, and
    # the rate at the start does not hold for the rest of the step.
    critical = solids.solidification_strain(p)
    forgets = (abs(eps0) >= critical) & (abs(eps1) >= critical)
    weight = own / ((1.0 + abs(psi)) * (own + (forgetting if forgets else 0.0)))
    least = rtol / _LARGEST_ERROR
    return weight if weight > least else least


@inline
def _outside(eps: float, near: float) -> float:
    """Distance of a strain from the interval between -`near` and `near`."""
    size = abs(eps)
    return size - near if size > near else 0.0


@inline
def passage_limits(
    p: Parameters,
    liquid: bool,
    begin: tuple[float, float],
    end: tuple[float, float],
    h: float,
) -> tuple[float, float]:
    """Largest allowed part of a step of length h, and the longest step after it.

    A step must not jump over the strains at which a liquid film may freeze: at both of its ends the
    film may be at the noise level, and no error estimate shows what happened in between
    (docs/decisions/short-freezing.md). `liquid` says whether the film is liquid; `begin` and `end`
    are the strain and its rate [1, 1/s] at the ends of the step. Hermite's cubic gives the strain
    in the middle.
    """
    critical = solids.solidification_strain(p)
    near, stride = _NEAR_PASSAGE * critical, _STRIDE * critical
    (eps0, rate0), (eps1, rate1) = begin, end
    middle = 0.5 * (eps0 + eps1) + 0.125 * h * (rate0 - rate1)
    way, speed = abs(middle - eps0) + abs(eps1 - middle), abs(rate1)
    before, after = _outside(eps0, near), _outside(eps1, near)
    # Whether the film can grow in a passage at the rate of the step, and at the rate of its end.
    # Without a division, which would be 0/0 for a constant strain.
    growth = _growth_at_unit_rate(p) / _LEAST_GROWTH
    grows, will_grow = liquid & (growth * h > way), liquid & (growth > speed)
    unseen = grows & (way - before - after > stride)
    aimed = before + 0.5 * stride if before > 0.0 else stride
    ahead = after + 0.5 * stride if after > 0.0 else stride
    nearing = (eps1 * rate1 < 0.0) | (after <= 0.0)
    return aimed / way if unseen else 1.0, ahead / speed if nearing & will_grow else math.inf
