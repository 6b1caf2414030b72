"""The equations of motion: Eq. 3 with x' = v, and Eq. 26 for ln(phi).

The state is (x, v, psi) with psi = ln(phi): psi neither underflows nor changes sign, and grows
linearly in time while the film is liquid.
"""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials
from stickslip.model import drive, film, friction, noise
from stickslip.parameters import Parameters

State = tuple[float, float, float]


@inline
def relative_velocity(p: Parameters, t: float, v: float) -> float:
    """Relative velocity u = V - v of the blocks [m/s]."""
    return drive.upper_velocity(t, p.drive_amplitude, p.angular_frequency) - v


@inline
def stress_and_force(p: Parameters, u: float, phi: float) -> tuple[float, float]:
    """Elastic stress [Pa] (Eq. 13) and friction force [N] (Eq. 10) at relative velocity `u`."""
    eps = friction.elastic_strain(u, p.strain_relaxation_time, p.film_thickness)
    sigma_el = film.elastic_stress(phi, eps, p.elastic_coefficient)
    sigma_v = friction.viscous_stress(
        u, p.film_thickness, p.viscosity_coefficient, p.rheological_index
    )
    return sigma_el, friction.friction_force(sigma_el, sigma_v, p.contact_area)


@inline
def block_acceleration(p: Parameters, x: float, F: float) -> float:
    """Acceleration of the lower block [m/s2], Eq. 3."""
    return (F - 2.0 * p.spring_stiffness * x) / p.block_mass


@inline
def film_melting_function(p: Parameters, u: float) -> float:
    """Melting function B [J/m3] (Eq. 15) at relative velocity `u`."""
    eps = friction.elastic_strain(u, p.strain_relaxation_time, p.film_thickness)
    return film.melting_function(
        eps, p.temperature, p.thermal_coefficient, p.critical_temperature, p.elastic_coefficient
    )


@inline
def rhs(p: Parameters, t: float, y: State, u_s: float = 0.0) -> State:
    """Time derivative of (x, v, psi) [m/s, m/s2, 1/s] at phase time `t` [s].

    With u_s > 0 the cusp of a pseudoplastic fluid is rounded (friction.rounded_viscous_stress).
    """
    x, v, psi = y
    phi, inverse_phi = exponentials(psi)
    u = relative_velocity(p, t, v)
    eps = friction.elastic_strain(u, p.strain_relaxation_time, p.film_thickness)
    sigma_v, _ = friction.rounded_viscous_stress(
        u, u_s, p.film_thickness, p.viscosity_coefficient, p.rheological_index
    )
    sigma_el = film.elastic_stress(phi, eps, p.elastic_coefficient)
    F = friction.friction_force(sigma_el, sigma_v, p.contact_area)
    force = film.log_force(
        phi, film_melting_function(p, u), p.cubic_coefficient, p.quartic_coefficient
    )
    D_eff = noise.effective_intensity(p.noise_intensity)
    psi_rate = noise.typical_path(inverse_phi, D_eff) - p.kinetic_coefficient * force
    return v, block_acceleration(p, x, F), psi_rate


@inline
def observables_and_rates(
    p: Parameters, t: float, y: State, u_s: float = 0.0
) -> tuple[float, float, float, float]:
    """Elastic stress [Pa] and friction force [N], and their rates along the motion.

    From Eqs. 10 and 13 with phi' = phi psi': where a rate changes sign, there is an extremum.
    """
    _, v, psi = y
    phi, _ = exponentials(psi)
    u = relative_velocity(p, t, v)
    sigma_el, F = stress_and_force(p, u, phi)
    _, v_rate, psi_rate = rhs(p, t, y, u_s)
    V_rate = drive.upper_acceleration(t, p.drive_amplitude, p.angular_frequency)
    mu = film.shear_modulus(phi, p.elastic_coefficient)
    eps_u = p.strain_relaxation_time / p.film_thickness
    slope = friction.viscous_stress_slope(
        u, p.film_thickness, p.viscosity_coefficient, p.rheological_index
    )
    u_rate = V_rate - v_rate
    sigma_rate = mu * eps_u * (u_rate + 2.0 * u * psi_rate)
    return sigma_el, F, sigma_rate, (sigma_rate + slope * u_rate) * p.contact_area


@inline
def jacobian(
    p: Parameters, t: float, y: State, u_s: float = 0.0
) -> tuple[State, State, State, State]:
    """The three rows of d(rhs)/dy, and d(rhs)/dt as a fourth."""
    _, v, psi = y
    phi, inverse_phi = exponentials(psi)
    u = relative_velocity(p, t, v)
    V_rate = drive.upper_acceleration(t, p.drive_amplitude, p.angular_frequency)
    eps_u = p.strain_relaxation_time / p.film_thickness
    mu = film.shear_modulus(phi, p.elastic_coefficient)
    _, slope = friction.rounded_viscous_stress(
        u, u_s, p.film_thickness, p.viscosity_coefficient, p.rheological_index
    )
    F_u = (mu * eps_u + slope) * p.contact_area
    F_psi = 2.0 * mu * (eps_u * u) * p.contact_area
    psi_u = -p.kinetic_coefficient * (2.0 * p.elastic_coefficient * (eps_u * eps_u)) * u
    psi_psi = -p.kinetic_coefficient * film.log_force_slope(
        phi, p.cubic_coefficient, p.quartic_coefficient
    ) - 2.0 * noise.typical_path(inverse_phi, noise.effective_intensity(p.noise_intensity))
    M = p.block_mass
    return (
        (0.0, 1.0, 0.0),
        (-2.0 * p.spring_stiffness / M, -F_u / M, F_psi / M),
        (0.0, -psi_u, psi_psi),
        (0.0, F_u * V_rate / M, psi_u * V_rate),
    )


@inline
def starting_state(p: Parameters) -> State:
    """The start (x_0, v_0, ln(phi)) with phi_0 lifted to the level of the noise."""
    phi = noise.starting_order_parameter(
        p.initial_order_parameter,
        noise.effective_intensity(p.noise_intensity),
        p.temperature,
        p.thermal_coefficient,
        p.critical_temperature,
        p.cubic_coefficient,
        p.quartic_coefficient,
        p.kinetic_coefficient,
    )
    return p.initial_displacement, p.initial_velocity, math.log(phi)
