"""The equations of motion with a relaxing elastic strain, a fourth variable (Eq. 23).

tau eps' = -eps + (V - v) tau/h. The film then stores the elastic energy A h a phi^2 eps^2/2 and can
return part of it to the blocks; in the adiabatic limit (Eq. 24) it loses all of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import block, drive, film, friction
from stickslip.model.drive import Upper
from stickslip.model.laws import FrictionLaw
from stickslip.model.rhs import (
    Equations,
    StrainModel,
    loss,
    make_error_weight,
    make_exact,
    make_step_limits,
    relative_motion,
    relative_velocity,
    starting_state,
    stress_and_force,
    viscous_rate,
)
from stickslip.model.scaling import Scaling, Units, make_units
from stickslip.model.state import STATE, Component, State
from stickslip.model.weights import force_weight
from stickslip.parameters import Parameters

STRAIN = Component("elastic_strain", "strain", mirror=-1.0, weight=1.0, floor=-math.inf, follows=1)
"""The elastic strain, the component after (x, v, psi)."""


@inline
def _units_of(p: Parameters) -> Units:
    """Return the units: as `scaling.units_of`, but strain and slope are 1 at the drive's speed."""
    time = 1.0 / p.angular_frequency
    strain = p.drive_amplitude / time / p.film_thickness * p.strain_relaxation_time
    thickness = p.film_thickness / (p.strain_relaxation_time / time)
    return make_units(p, time, p.drive_amplitude, thickness, strain)


@inline
def _state_units(units: Units) -> State:
    return units.length, units.speed, 1.0, units.strain


@inline
def strain_relaxation(p: Parameters, u: float, eps: float) -> float:
    """Rate of the elastic strain [1/s], Eq. 23."""
    return (friction.elastic_strain(p, u) - eps) / p.strain_relaxation_time


@inline
def starting_state_with_strain(p: Parameters) -> State:
    """Return the start (x_0, v_0, ln(phi), eps), with the strain of the adiabatic limit."""
    x, v, psi = starting_state(p)
    return x, v, psi, friction.elastic_strain(p, relative_velocity(p, 0.0, v))


def _make_relative_state(upper: Upper) -> Callable[..., State]:
    relative_velocity = relative_motion(upper).velocity

    @inline
    def relative_state(p: Parameters, t: float, y: State) -> State:
        return y[0], relative_velocity(p, t, y[1]), y[2], y[3]

    return relative_state


@inline
def _strain(p: Parameters, y: State) -> float:
    return y[3]


@inline
def _strain_amplitude(p: Parameters, u: float) -> float:
    lag = p.angular_frequency * p.strain_relaxation_time
    return friction.elastic_strain(p, u) / math.sqrt(1.0 + lag * lag)


def _make_psi_rate(path: Callable[..., float]) -> Any:
    """Return the rate of ln(phi) [1/s] as a function (p, psi, eps); `path` as in `StrainModel`."""

    @inline
    def psi_rate(p: Parameters, psi: float, eps: float) -> float:
        phi, inverse_phi = exponentials(psi)
        force = film.log_force(p, phi, film.melting_function(p, eps))
        return path(p, inverse_phi) - p.kinetic_coefficient * force

    return psi_rate


@inline
def stored_energy(p: Parameters, y: State) -> float:
    """Elastic energy of the film [J]."""
    phi, _ = exponentials(y[2])
    volume = p.contact_area * p.film_thickness
    return 0.5 * film.elastic_stress(p, phi, y[3]) * y[3] * volume


def relaxing_equations(law: FrictionLaw, path: Callable[..., float], upper: Upper) -> Equations:
    """Return the equations of motion of (x, u, psi, eps); arguments as in `StrainModel`."""
    rounded, rate_of_psi = law.rounded, _make_psi_rate(path)
    weight_of_others, relative = make_error_weight(law, _strain), relative_motion(upper)
    upper_velocity, upper_acceleration = upper.velocity, upper.acceleration
    relative_acceleration, acceleration_slopes = relative.acceleration, relative.acceleration_slopes

    @inline
    def power(p: Parameters, V: float, y: State, F: float) -> float:
        x, u, psi, eps = y
        elastic = film.elastic_stress(p, exponentials(psi)[0], eps) * p.contact_area
        # The stored energy is lost when the strain relaxes and when the strained film melts.
        lost = 1.0 / p.strain_relaxation_time - rate_of_psi(p, psi, eps)
        gained = F * V - (F - elastic) * u - block.own_loss(p, x, V - u)
        return gained - 2.0 * stored_energy(p, y) * lost

    @inline
    def observables(p: Parameters, y: State, phi: float, u_s: float) -> tuple[float, float]:
        return stress_and_force(p, phi, y[3], rounded(p, y[1], phi, u_s)[0])

    @inline
    def rhs(p: Parameters, t: float, y: State, u_s: float) -> State:
        x, u, psi, eps = y
        _, F = observables(p, y, exponentials(psi)[0], u_s)
        u_rate = relative_acceleration(p, t, x, u, F)
        x_rate = upper_velocity(p, t) - u
        return x_rate, u_rate, rate_of_psi(p, psi, eps), strain_relaxation(p, u, eps)

    @inline
    def jacobian(p: Parameters, t: float, y: State, u_s: float) -> tuple[State, ...]:
        x, u, psi, eps = y
        phi, inverse_phi = exponentials(psi)
        mu, M = film.shear_modulus(p, phi), p.block_mass
        _, sigma_u, sigma_psi = rounded(p, u, phi, u_s)
        F_u, F_eps = sigma_u * p.contact_area, mu * p.contact_area
        F_psi = (2.0 * mu * eps + sigma_psi) * p.contact_area
        psi_eps = -p.kinetic_coefficient * (2.0 * p.elastic_coefficient * eps)
        psi_psi = -p.kinetic_coefficient * film.log_force_slope(p, phi)
        psi_psi -= 2.0 * path(p, inverse_phi)
        relaxing = 1.0 / p.strain_relaxation_time
        u_x, u_u, u_t = acceleration_slopes(p, t, x, u, F_u)
        return (
            (0.0, -1.0, 0.0, 0.0),
            (u_x, u_u, -F_psi / M, -F_eps / M),
            (0.0, 0.0, psi_psi, psi_eps),
            (0.0, friction.strain_slope(p) * relaxing, 0.0, -relaxing),
            (upper_acceleration(p, t), u_t, 0.0, 0.0),
        )

    @inline
    def observables_and_rates(
        p: Parameters, t: float, y: State, u_s: float
    ) -> tuple[float, float, float, float]:
        _, u, psi, eps = y
        phi, _ = exponentials(psi)
        sigma_el, F = observables(p, y, phi, u_s)
        _, u_rate, psi_rate, eps_rate = rhs(p, t, y, u_s)
        sigma_rate = film.shear_modulus(p, phi) * (eps_rate + 2.0 * eps * psi_rate)
        sigma_v_rate = viscous_rate(rounded(p, u, phi, u_s), u_rate, psi_rate)
        return sigma_el, F, sigma_rate, (sigma_rate + sigma_v_rate) * p.contact_area

    @inline
    def error_weight(
        p: Parameters, rtol: float, y: State, y1: State, J: tuple[State, ...]
    ) -> State:
        x_weight, u_weight, psi_weight = weight_of_others(p, rtol, y, y1, J)
        # An error of the strain counts like one of the velocity to which it relaxes, both directly
        # and through the force.
        strain = drive.largest_speed(p) * friction.strain_slope(p)
        force = force_weight(p, strain * (-J[1][3] * p.block_mass))
        return x_weight, u_weight, psi_weight, (1.0 + force) / strain

    return Equations(
        law=law,
        upper=upper,
        exact=make_exact(law),
        relative_state=_make_relative_state(upper),
        strain=_strain,
        strain_amplitude=_strain_amplitude,
        rhs=rhs,
        jacobian=jacobian,
        observables=observables,
        observables_and_rates=observables_and_rates,
        power=power,
        loss=loss,
        stored_energy=stored_energy,
        error_weight=error_weight,
        step_limits=make_step_limits(_strain, _strain),
    )


RELAXING = StrainModel(
    (*STATE, STRAIN),
    relaxing_equations,
    Scaling(_units_of, literals=()),
    starting_state_with_strain,
    _state_units,
)
"""The strain as an independent variable, Eq. 23."""
