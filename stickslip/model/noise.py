"""The weak additive noise of Eq. 26 and its typical path.

The noise is dphi = ... + sqrt(2 D) dW, reflected at phi = 0. While phi is small its dynamics are
linear and Gaussian. The geometric mean of |phi| then follows a smooth equation, the deterministic
one plus D_eff/phi with D_eff = D exp(E ln chi^2_1). This closure keeps phi positive, needs no
random number and vanishes in the solid (docs/equations.md).

For stochastic noise `no_path` replaces the typical path, and every step draws a random number
(`chance.py`).
"""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.model import film, solids
from stickslip.parameters import Parameters

# exp(E ln chi^2_1) = exp(-Euler's constant)/2.
TYPICAL_FRACTION = 0.5 * math.exp(-0.57721566490153286061)

# A film freezes at each stop if half a drive period is long enough for this many freezings.
_AT_ONCE = 3.0

# A film certainly does not freeze on the way to a limit if its possible growth is at most the first
# fraction of the growth that it needs. The second number is a head start in e-folds, for the noise
# itself. The third allows for the arc of the strain: a passage through zero takes less than this
# many times as long as at the largest rate.
_CERTAIN, _HEAD_START, _ARC = 0.9, 2.0, 1.1

# Between passages the strain must rise this far above the critical one, or growth would add up.
_FEWEST = 1.5

# An order parameter below this multiple of the noise level counts as being at that level.
_NEAR = 3.0

# Noise overcomes a barrier of this many D in one case in 1e17.
_BEYOND_CHANCE = 40.0

# Floor of a divisor, which avoids 0/0 without noise.
_SMALLEST = 1e-300


@inline
def effective_intensity(p: Parameters) -> float:
    """Noise intensity D_eff [1/s] of the typical path."""
    return TYPICAL_FRACTION * p.noise_intensity


@inline
def typical_path(p: Parameters, inverse_phi: float) -> float:
    """Contribution of the noise to the rate of ln(phi) [1/s]: D_eff/phi^2."""
    return effective_intensity(p) * (inverse_phi * inverse_phi)


@inline
def no_path(p: Parameters, inverse_phi: float) -> float:
    """Contribution of stochastic noise to the rate of ln(phi) [1/s]: 0, as its steps are random."""
    return 0.0


@inline
def typical_kick(p: Parameters, phi: float, dt: float) -> float:
    """Contribution of the noise to phi in a fixed step `dt`: D_eff dt/phi.

    Below phi = sqrt(D_eff dt), the noise of a single step, the closure is meaningless. There the
    kick is limited to this size, because 1/phi would make an explicit step overshoot.
    """
    gained = effective_intensity(p) * dt
    return gained / max(phi, max(math.sqrt(gained), _SMALLEST))


@inline
def random_kick(p: Parameters, dt: float, xi: float) -> float:
    """Random contribution to phi in a fixed step `dt` [s]; `xi` has variance 1."""
    return math.sqrt(2.0 * p.noise_intensity * dt) * xi


@inline
def starting_order_parameter(p: Parameters) -> float:
    """Order parameter at the start: phi_0, or the level of the noise if that is higher."""
    return max(p.initial_order_parameter, level(p))


@inline
def level(p: Parameters) -> float:
    """Order parameter that the noise alone maintains in a liquid film at rest.

    There D_eff/phi balances the linear, the quadratic, the cubic or a restoring higher term of
    Eq. 26, whichever sets the lowest level. A term whose coefficient is 0 sets none.
    """
    D_eff, b, delta = effective_intensity(p), p.cubic_coefficient, p.kinetic_coefficient
    balanced = math.inf
    if p.quartic_coefficient > 0.0:
        balanced = math.sqrt(math.sqrt(D_eff / (p.quartic_coefficient * delta)))
    if film.has_higher_terms(p):
        for place, power in film.RESTORING:
            k = p[place]
            if k > 0.0:
                balanced = min(balanced, (D_eff / (k * delta)) ** (1.0 / (power + 2.0)))
    linear = abs(film.heating(p)) * delta
    if linear > 0.0:
        balanced = min(balanced, math.sqrt(D_eff / linear))
    if b > 0.0:
        balanced = min(balanced, (D_eff / (b * delta)) ** (1.0 / 3.0))
    return balanced


@inline
def freezes_late(p: Parameters) -> bool:
    """Return whether a liquid film may freeze only after many periods, or never.

    Below T_c the noise freezes such a film in the end, but not within a fraction of half a drive
    period, so that the outcome depends on the motion over many periods. This is not so for a film
    that freezes at each stop, or for one above T_c, which never freezes again.
    """
    growth = -film.heating(p) * p.kinetic_coefficient
    foldings = growth * math.pi / p.angular_frequency
    way = -math.log(max(level(p), _SMALLEST))
    return growth > 0.0 and foldings < _AT_ONCE * way


@inline
def clearance(p: Parameters, critical: float) -> tuple[float, float]:
    """Bounds (gain, least) [1, m/s] for a film that cannot freeze on its way to a liquid limit.

    Liquid motions approach one another: if the offset from the limit has the speed rho, u stays
    within rho of the u of the limit forever. When the latter, of amplitude U, passes through zero,
    the strain is below the critical one, reached at the speed `critical` [m/s], for no longer than
    2 (critical + rho)/U omega. ln(phi) grows by no more than (4/3 critical + 2 rho)/U omega times
    its rate at rest. If U > gain rho + least, this is too little to freeze, as long as the friction
    does not matter (docs/decisions/late-freezing.md).
    """
    growth = -film.heating(p) * p.kinetic_coefficient / p.angular_frequency
    way = math.log(max(solids.solid_threshold(p), _SMALLEST) / max(level(p), _SMALLEST))
    needed = _CERTAIN * (way - _HEAD_START)
    if not needed > 0.0:
        return math.inf, math.inf
    times = _ARC * growth / needed
    return max(2.0 * times, _FEWEST), max(4.0 / 3.0 * times, _FEWEST) * critical


@inline
def may_reach(p: Parameters, phi: float, bound: float) -> bool:
    """Return whether random noise may lift the order parameter from `bound` to `phi` above it.

    The probability is proportional to exp(-delta f/D), with f of the unstrained film, which is the
    softest.
    """
    barrier = film.free_energy(p, phi, 0.0) - film.free_energy(p, bound, 0.0)
    return p.kinetic_coefficient * barrier <= _BEYOND_CHANCE * p.noise_intensity


@inline
def in_between(p: Parameters, phi: float) -> bool:
    """Return whether a film is neither solid nor at the noise level, so that it may be freezing."""
    return _NEAR * level(p) <= phi < solids.solid_threshold(p)
