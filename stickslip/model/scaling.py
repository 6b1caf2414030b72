"""The model in its own units: time 1/omega, length |X_m|, mass M, and the film's in 1/delta.

The equations keep their form under scalings of their units (docs/equations.md). Together these turn
X_m, omega, M, h and delta into 1, which leaves ten parameters, no division by a parameter, and a
state whose components are the ones that tolerances refer to. A drive with X_m < 0 is the mirror
image of its positive twin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from stickslip.compiled.decorators import inline
from stickslip.parameters import Parameters, ParameterValues


class Units(NamedTuple):
    """What one unit of the reduced model is; length, speed, stress, force change sign with X_m."""

    length: float
    speed: float
    stress: float
    force: float


class Reduced(NamedTuple):
    """The parameters that are left, with the symbols of those that they stand for."""

    heating: float
    """2 alpha (T - T_c)"""
    k: float
    K: float
    tau: float
    A: float
    a: float
    b: float
    c: float
    D: float
    gamma: float


@inline
def units_of(p: Parameters) -> Units:
    """Units of length [m], speed [m/s], stress [Pa] and force [N] for the parameters `p`."""
    X_m, omega = p.drive_amplitude, p.angular_frequency
    sign = math.copysign(1.0, X_m)
    return Units(
        X_m,
        X_m * omega,
        sign * (omega / p.kinetic_coefficient),
        p.block_mass * (omega * omega) * X_m,
    )


@inline
def reduced(p: Parameters) -> Reduced:
    """The parameters `p` in the units of `units_of`."""
    omega = p.angular_frequency
    rate = abs(p.drive_amplitude) / p.film_thickness * omega
    energy = p.kinetic_coefficient / omega
    inertia = p.block_mass * (omega * omega)
    return Reduced(
        heating=2.0 * (p.thermal_coefficient * energy) * (p.temperature - p.critical_temperature),
        k=p.viscosity_coefficient * energy * rate ** (p.rheological_index + 1.0),
        K=p.spring_stiffness / inertia,
        tau=p.strain_relaxation_time * rate,
        A=p.contact_area / abs(p.drive_amplitude) / inertia / energy,
        a=p.elastic_coefficient * energy,
        b=p.cubic_coefficient * energy,
        c=p.quartic_coefficient * energy,
        D=p.noise_intensity / omega,
        gamma=p.rheological_index,
    )


@inline
def with_gamma(q: Reduced, gamma: float) -> ParameterValues:
    """Reduced parameters as the model's functions take them.

    The ones are literal, so that in a function with a literal `gamma` the compiler removes what
    they make superfluous: divisions, branches and the general power.
    """
    return ParameterValues(
        q.heating, q.k, q.K, gamma, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0,
        1.0, q.tau, q.A, 1.0, 0.5, 0.0, q.a, q.b, q.c, q.D,
    )  # fmt: skip
