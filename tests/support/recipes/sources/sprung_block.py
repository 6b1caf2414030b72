"""An upper block on a spring, with two more state variables.

M_2 X_2'' = K_2 (X - X_2) - F(V_2 - v, phi), with the drive X at the far end of the spring. The
relative velocity is V_2 - v. The states are (x, v, psi, X - X_2, V_2); the strain follows at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import block, drive, film, friction
from stickslip.model.drive import Upper
from stickslip.model.laws import FrictionLaw
from stickslip.model.rhs import (
    FOLLOWING,
    Equations,
    StrainModel,
    film_melting_function,
    make_error_weight,
    make_exact,
    make_step_limits,
    starting_state,
    stress_and_force,
    viscous_rate,
)
from stickslip.model.scaling import Units
from stickslip.model.state import STATE, Component, State
from stickslip.model.weights import force_weight
from stickslip.parameters import Parameters

STRETCH = Component("spring_stretch", "X - X_2", mirror=-1.0, weight=1.0, floor=-math.inf)
SPEED = Component("upper_block_velocity", "V_2", mirror=-1.0, weight=1.0, floor=-math.inf)


@inline
def _relative_state(p: Parameters, t: float, y: State) -> State:
    return y[0], y[4] - y[1], y[2], y[3], y[4]


@inline
def _start(p: Parameters) -> State:
    x, v, psi = starting_state(p)
    return x, v, psi, 0.0, drive.upper_velocity(p, 0.0)


@inline
def _state_units(units: Units) -> State:
    return units.length, units.speed, 1.0, units.length, units.speed


@inline
def _strain(p: Parameters, y: State) -> float:
    return friction.elastic_strain(p, y[1])


@inline
def _power(p: Parameters, V: float, y: State, F: float) -> float:
    v = y[4] - y[1]
    return F * v - block.own_loss(p, y[0], v)


@inline
def _loss(p: Parameters, V: float, y: State, F: float) -> float:
    v = y[4] - y[1]
    return F * (V - v) + block.own_loss(p, y[0], v)


def sprung_equations(law: FrictionLaw, path: Callable[..., float], upper: Upper) -> Equations:
    rounded, weight_of_others = law.rounded, make_error_weight(law, _strain)
    upper_velocity, upper_acceleration = upper.velocity, upper.acceleration

    @inline
    def observables(p: Parameters, y: State, phi: float, u_s: float) -> tuple[float, float]:
        return stress_and_force(p, phi, _strain(p, y), rounded(p, y[1], phi, u_s)[0])

    @inline
    def rhs(p: Parameters, t: float, y: State, u_s: float) -> State:
        x, u, psi, stretch, w = y
        phi, inverse_phi = exponentials(psi)
        _, F = observables(p, y, phi, u_s)
        w_rate = (p.upper_stiffness * stretch - F) / p.upper_mass
        u_rate = w_rate - block.acceleration(p, x, w - u, F)
        force = film.log_force(p, phi, film_melting_function(p, u))
        psi_rate = path(p, inverse_phi) - p.kinetic_coefficient * force
        return w - u, u_rate, psi_rate, upper_velocity(p, t) - w, w_rate

    @inline
    def jacobian(p: Parameters, t: float, y: State, u_s: float) -> tuple[State, ...]:
        x, u, psi, _, w = y
        M, M_2, K_2 = p.block_mass, p.upper_mass, p.upper_stiffness
        phi, inverse_phi = exponentials(psi)
        eps_u, mu = friction.strain_slope(p), film.shear_modulus(p, phi)
        _, sigma_u, sigma_psi = rounded(p, u, phi, u_s)
        F_u = (mu * eps_u + sigma_u) * p.contact_area
        F_psi = (2.0 * mu * (eps_u * u) + sigma_psi) * p.contact_area
        psi_u = -p.kinetic_coefficient * (2.0 * p.elastic_coefficient * (eps_u * eps_u)) * u
        psi_psi = -p.kinetic_coefficient * film.log_force_slope(p, phi)
        psi_psi -= 2.0 * path(p, inverse_phi)
        over_x, over_v = block.own_slopes(p, x, w - u)
        u_u = -F_u / M_2 - (F_u - over_v) / M
        return (
            (0.0, -1.0, 0.0, 0.0, 1.0),
            (-over_x / M, u_u, -F_psi / M_2 - F_psi / M, K_2 / M_2, -over_v / M),
            (0.0, psi_u, psi_psi, 0.0, 0.0),
            (0.0, 0.0, 0.0, 0.0, -1.0),
            (0.0, -F_u / M_2, -F_psi / M_2, K_2 / M_2, 0.0),
            (0.0, 0.0, 0.0, upper_acceleration(p, t), 0.0),
        )

    @inline
    def observables_and_rates(
        p: Parameters, t: float, y: State, u_s: float
    ) -> tuple[float, float, float, float]:
        u, phi, eps_u = y[1], exponentials(y[2])[0], friction.strain_slope(p)
        sigma_el, F = observables(p, y, phi, u_s)
        _, u_rate, psi_rate, _, _ = rhs(p, t, y, u_s)
        sigma_rate = film.shear_modulus(p, phi) * eps_u * (u_rate + 2.0 * u * psi_rate)
        sigma_v_rate = viscous_rate(rounded(p, u, phi, u_s), u_rate, psi_rate)
        return sigma_el, F, sigma_rate, (sigma_rate + sigma_v_rate) * p.contact_area

    @inline
    def error_weight(
        p: Parameters, rtol: float, y: State, y1: State, J: tuple[State, ...]
    ) -> State:
        x_weight, u_weight, psi_weight = weight_of_others(p, rtol, y, y1, J)
        stretch_weight = x_weight + force_weight(p, p.upper_stiffness)
        return x_weight, u_weight, psi_weight, stretch_weight, 1.0 / drive.largest_speed(p)

    return Equations(
        law=law,
        upper=upper,
        exact=make_exact(law),
        relative_state=_relative_state,
        strain=_strain,
        strain_amplitude=friction.elastic_strain,
        rhs=rhs,
        jacobian=jacobian,
        observables=observables,
        observables_and_rates=observables_and_rates,
        power=_power,
        loss=_loss,
        stored_energy=None,
        error_weight=error_weight,
        step_limits=make_step_limits(_strain, _strain),
    )


SPRUNG = StrainModel(
    (*STATE, STRETCH, SPEED), sprung_equations, FOLLOWING.scaling, _start, _state_units
)
