"""The equations of motion: Eq. 3 with x' = v, and Eq. 26 for ln(phi).

The integrated variables are (x, u, psi), followed by the elastic strain if that relaxes
(`relaxing.py`). The slip of a locked block is parts in 1e5 of the drive. Because the relative
velocity u = V - v is the unknown, this slip, and with it the steep friction force, is accurate to
the tolerance. psi = ln(phi) neither underflows nor changes sign, and is linear in time while the
film is liquid.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import block, drive, film, friction, noise, scaling, solids
from stickslip.model.drive import Upper
from stickslip.model.laws import FrictionLaw
from stickslip.model.scaling import Scaling, Units
from stickslip.model.state import STATE, Component, State
from stickslip.model.weights import LARGEST_AT_CUSP, film_weight, force_weight, passage_limits
from stickslip.options import HARMONICS
from stickslip.parameters import Parameters


class RelativeMotion(NamedTuple):
    """The relative motion of the blocks, as inline functions."""

    velocity: Callable[..., float]
    """(p, t, v): relative velocity u = V - v [m/s]."""

    acceleration: Callable[..., float]
    """(p, t, x, u, F): rate of the relative velocity [m/s2]: V' minus Eq. 3."""

    acceleration_slopes: Callable[..., tuple[float, float, float]]
    """(p, t, x, u, F_u): derivatives of the acceleration with respect to x, u and t; `F_u` is
    dF/du."""


@cache
def relative_motion(upper: Upper) -> RelativeMotion:
    """Return the relative motion for a motion of the upper block."""
    upper_velocity, upper_acceleration, upper_jerk = upper.velocity, upper.acceleration, upper.jerk

    @inline
    def velocity(p: Parameters, t: float, v: float) -> float:
        return upper_velocity(p, t) - v

    @inline
    def acceleration(p: Parameters, t: float, x: float, u: float, F: float) -> float:
        v = upper_velocity(p, t) - u
        return upper_acceleration(p, t) - block.acceleration(p, x, v, F)

    @inline
    def acceleration_slopes(
        p: Parameters, t: float, x: float, u: float, F_u: float
    ) -> tuple[float, float, float]:
        x_slope, v_slope = block.own_slopes(p, x, upper_velocity(p, t) - u)
        M = p.block_mass
        jerk = upper_jerk(p, t) - v_slope / M * upper_acceleration(p, t)
        return -x_slope / M, -(F_u - v_slope) / M, jerk

    return RelativeMotion(velocity, acceleration, acceleration_slopes)


relative_velocity = relative_motion(drive.UPPER[HARMONICS]).velocity
"""(p, t, v): relative velocity u = V - v of the blocks [m/s] at any point."""


@inline
def film_melting_function(p: Parameters, u: float) -> float:
    """Melting function B [J/m3] (Eq. 15) at relative velocity `u`, in the adiabatic limit."""
    return film.melting_function(p, friction.elastic_strain(p, u))


@inline
def block_power(p: Parameters, V: float, y: State, F: float) -> float:
    """Power [W] that the lower block gains under a friction force F [N]."""
    v = V - y[1]
    return F * v - block.own_loss(p, y[0], v)


@inline
def loss(p: Parameters, V: float, y: State, F: float) -> float:
    """Power [W] of the drive minus the power that the block gains, under a friction force F [N].

    It is F (V - v) plus the loss of the block, which avoids a difference of large numbers.
    """
    return F * y[1] + block.own_loss(p, y[0], V - y[1])


@inline
def starting_state(p: Parameters) -> State:
    """Return the start (x_0, v_0, ln(phi)), with phi_0 raised to the noise level if below it."""
    phi = noise.starting_order_parameter(p)
    return p.initial_displacement, p.initial_velocity, math.log(phi)


@inline
def stress_and_force(p: Parameters, phi: float, eps: float, sigma_v: float) -> tuple[float, float]:
    """Elastic stress [Pa] (Eq. 13) and friction force [N] (Eq. 10) of a strained film.

    `sigma_v` is the viscous stress [Pa].
    """
    sigma_el = film.elastic_stress(p, phi, eps)
    return sigma_el, friction.friction_force(p, sigma_el, sigma_v)


@inline
def viscous_rate(rounded: tuple[float, float, float], u_rate: float, psi_rate: float) -> float:
    """Rate of the viscous stress [Pa/s] along a motion; `rounded` is the result of the law."""
    _, over_u, over_psi = rounded
    # A law without phi skips the second term, which would be 0 times inf for a diverging film.
    return over_u * u_rate + over_psi * psi_rate if over_psi != 0.0 else over_u * u_rate


class Equations(NamedTuple):
    """The equations of motion of a model, as inline functions.

    y is the integrated state, (x, u, psi) or (x, u, psi, eps).
    """

    law: FrictionLaw

    upper: Upper
    """The motion of the upper block."""

    exact: Callable[..., tuple[float, float]]
    """(p, u, phi): elastic stress [Pa] and friction force [N] in the adiabatic limit, with the
    exact law, whose cusp is not rounded."""

    relative_state: Callable[..., State]
    """(p, t, y): (x, V - v, ...) of (x, v, ...) at phase time t [s]; its own inverse."""

    strain: Callable[..., float]
    """(p, y): the elastic strain."""

    strain_amplitude: Callable[..., float]
    """(p, u): amplitude of the elastic strain under a relative velocity of amplitude u at omega."""

    rhs: Callable[..., State]
    """(p, t, y, u_s): rates of y [m/s, m/s2, 1/s, 1/s] at phase time t [s]. With u_s > 0 a cusp of
    the law is rounded for |u| < u_s [m/s]."""

    jacobian: Callable[..., tuple[State, ...]]
    """(p, t, y, u_s): the rows of d(rhs)/dy, then d(rhs)/dt."""

    observables: Callable[..., tuple[float, float]]
    """(p, y, phi, u_s): elastic stress [Pa] and friction force [N] of y, given phi = exp(psi)."""

    observables_and_rates: Callable[..., tuple[float, float, float, float]]
    """(p, t, y, u_s): elastic stress [Pa], friction force [N] and their rates along the motion,
    from Eqs. 10 and 13 with phi' = phi psi'. An extremum is where a rate changes sign."""

    power: Callable[..., float]
    """(p, V, y, F): the power [W] of the drive at the velocity V [m/s] of the upper block and the
    friction force F [N], minus the dissipation in film and block. If the film stores no energy,
    this is the power that the block gains."""

    loss: Callable[..., float]
    """(p, V, y, F): the power F V [W] of the drive minus that which the block gains, computed as
    F (V - v) plus the loss of the block, so that no large numbers cancel."""

    stored_energy: Callable[..., float] | None
    """(p, y): the elastic energy of the film [J]; None if it stores none."""

    error_weight: Callable[..., State]
    """(p, rtol, y, y1, J): the weights [1/m, s/m, 1, 1] of the errors of a step from y to y1 at a
    relative tolerance; J is the result of `jacobian`."""

    step_limits: Callable[..., tuple[float, float]]
    """(p, solid, y0, f0, y1, f1, h): the largest allowed part of a step from y0 to y1, and the
    longest step after it [s]. f0 and f1 are the rates at the ends; a film is solid from the order
    parameter `solid` upwards."""


class StrainModel(NamedTuple):
    """The parts of a model that depend on how the elastic strain is modelled."""

    components: tuple[Component, ...]
    """The state variables, in their order."""

    make_equations: Callable[..., Equations]
    """(law, path, upper): the equations of motion with a friction law; `path` is the noise term of
    psi', `upper` the motion of the upper block."""

    scaling: Scaling
    """The nondimensional form."""

    start: Callable[[Parameters], State]
    """(p), inline: the state (x, v, psi, ...) in which a motion begins."""

    state_units: Callable[[Units], State]
    """(units), inline: the unit of each component."""


@cache
def make_relative_state(upper: Upper) -> Callable[..., State]:
    """Return `Equations.relative_state` of (x, v, psi)."""
    relative_velocity = relative_motion(upper).velocity

    @inline
    def relative_state(p: Parameters, t: float, y: State) -> State:
        return y[0], relative_velocity(p, t, y[1]), y[2]

    return relative_state


relative_state = make_relative_state(drive.UPPER[HARMONICS])
"""(p, t, y): (x, V - v, psi) of (x, v, psi) at phase time t [s] at any point; its own inverse."""


@inline
def _strain(p: Parameters, y: State) -> float:
    return friction.elastic_strain(p, y[1])


def make_exact(law: FrictionLaw) -> Any:
    """Return `Equations.exact` for a law."""
    stress = law.stress

    @inline
    def exact(p: Parameters, u: float, phi: float) -> tuple[float, float]:
        return stress_and_force(p, phi, friction.elastic_strain(p, u), stress(p, u, phi))

    return exact


def make_error_weight(law: FrictionLaw, strain: Callable[..., float]) -> Any:
    """Return `Equations.error_weight` of (x, u, psi) for a law, and a strain function (p, y)."""
    has_cusp = law.has_cusp

    @inline
    def error_weight(
        p: Parameters, rtol: float, y: State, y1: State, J: tuple[State, ...]
    ) -> State:
        V_m = drive.largest_speed(p)
        force = force_weight(p, V_m * (-J[1][1] * p.block_mass))
        if has_cusp(p):  # the slope of a rounded cusp depends on the tolerance
            force = LARGEST_AT_CUSP if force > LARGEST_AT_CUSP else force
        film = film_weight(p, rtol, y[2], strain(p, y), strain(p, y1))
        return 1.0 / drive.largest_displacement(p), (1.0 + force) / V_m, film

    return error_weight


def make_step_limits(strain: Callable[..., float], strain_rate: Callable[..., float]) -> Any:
    """Return `Equations.step_limits` for a strain function (p, y), and its rate (p, f)."""

    @inline
    def step_limits(
        p: Parameters, solid: float, y0: State, f0: State, y1: State, f1: State, h: float
    ) -> tuple[float, float]:
        liquid = exponentials(y0[2])[0] <= solids.MELTED_PART * solid
        begin, end = (strain(p, y0), strain_rate(p, f0)), (strain(p, y1), strain_rate(p, f1))
        return passage_limits(p, liquid, begin, end, h)

    return step_limits


def adiabatic_equations(law: FrictionLaw, path: Callable[..., float], upper: Upper) -> Equations:
    """Return the equations of motion of (x, u, psi); arguments as in `StrainModel`."""
    rounded, relative = law.rounded, relative_motion(upper)
    upper_velocity, upper_acceleration = upper.velocity, upper.acceleration
    relative_acceleration, acceleration_slopes = relative.acceleration, relative.acceleration_slopes

    @inline
    def observables(p: Parameters, y: State, phi: float, u_s: float) -> tuple[float, float]:
        return stress_and_force(p, phi, _strain(p, y), rounded(p, y[1], phi, u_s)[0])

    @inline
    def rhs(p: Parameters, t: float, y: State, u_s: float) -> State:
        x, u, psi = y
        phi, inverse_phi = exponentials(psi)
        _, F = observables(p, y, phi, u_s)
        u_rate = relative_acceleration(p, t, x, u, F)
        force = film.log_force(p, phi, film_melting_function(p, u))
        psi_rate = path(p, inverse_phi) - p.kinetic_coefficient * force
        return upper_velocity(p, t) - u, u_rate, psi_rate

    @inline
    def jacobian(p: Parameters, t: float, y: State, u_s: float) -> tuple[State, ...]:
        x, u, psi = y
        phi, inverse_phi = exponentials(psi)
        eps_u = friction.strain_slope(p)
        mu = film.shear_modulus(p, phi)
        _, sigma_u, sigma_psi = rounded(p, u, phi, u_s)
        F_u = (mu * eps_u + sigma_u) * p.contact_area
        F_psi = (2.0 * mu * (eps_u * u) + sigma_psi) * p.contact_area
        psi_u = -p.kinetic_coefficient * (2.0 * p.elastic_coefficient * (eps_u * eps_u)) * u
        psi_psi = -p.kinetic_coefficient * film.log_force_slope(p, phi)
        psi_psi -= 2.0 * path(p, inverse_phi)
        u_x, u_u, u_t = acceleration_slopes(p, t, x, u, F_u)
        return (
            (0.0, -1.0, 0.0),
            (u_x, u_u, -F_psi / p.block_mass),
            (0.0, psi_u, psi_psi),
            (upper_acceleration(p, t), u_t, 0.0),
        )

    @inline
    def observables_and_rates(
        p: Parameters, t: float, y: State, u_s: float
    ) -> tuple[float, float, float, float]:
        _, u, psi = y
        phi, _ = exponentials(psi)
        sigma_el, F = observables(p, y, phi, u_s)
        _, u_rate, psi_rate = rhs(p, t, y, u_s)
        mu, eps_u = film.shear_modulus(p, phi), friction.strain_slope(p)
        sigma_rate = mu * eps_u * (u_rate + 2.0 * u * psi_rate)
        sigma_v_rate = viscous_rate(rounded(p, u, phi, u_s), u_rate, psi_rate)
        return sigma_el, F, sigma_rate, (sigma_rate + sigma_v_rate) * p.contact_area

    return Equations(
        law=law,
        upper=upper,
        exact=make_exact(law),
        relative_state=make_relative_state(upper),
        strain=_strain,
        strain_amplitude=friction.elastic_strain,
        rhs=rhs,
        jacobian=jacobian,
        observables=observables,
        observables_and_rates=observables_and_rates,
        power=block_power,
        loss=loss,
        stored_energy=None,
        error_weight=make_error_weight(law, _strain),
        # The strain is a multiple of u, and its rate the same multiple of the rate of u.
        step_limits=make_step_limits(_strain, _strain),
    )


@inline
def _state_units(units: Units) -> State:
    return units.length, units.speed, 1.0


FOLLOWING = StrainModel(STATE, adiabatic_equations, scaling.FOLLOWING, starting_state, _state_units)
"""The strain follows the relative velocity instantly, Eq. 24."""
