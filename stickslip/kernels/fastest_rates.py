"""Upper bounds of the rates of a point, which limit an explicit fixed step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit, kernel, kernel_factory, named_kernel
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.model import block, drive, film, friction, solids
from stickslip.model.laws import friction_law
from stickslip.options import DEFAULTS
from stickslip.parameters import Parameters

REFUSE_ABOVE = 2.0
"""An explicit step is unstable if its product with the fastest rate is above this."""

# An explicit scheme follows the drive with an error of omega dt, so it takes this many steps.
_STEPS_PER_RADIAN = 20.0

# Bisections for the speed at which friction balances the drive, to 1e-18 of the largest speed.
_BISECTIONS = 60

STRAINS = 200
"""Strains at which the static stress is evaluated, which gives its flat maximum to 1e-4."""


@jit
def _static_strength(p: Parameters, strains: int) -> float:
    """Largest static elastic stress a phi_plus^2 eps [Pa] of a solid film (Eqs. 13, 16, 19)."""
    limit, largest = solids.melting_strain(p), 0.0
    for i in range(strains):
        eps = limit * i / (strains - 1)
        phi = solids.solid_order_parameter(p, film.melting_function(p, eps))
        largest = max(largest, film.elastic_stress(p, phi, eps))
    return largest


@inline
def _reach(p: Parameters) -> float:
    """Upper bound of the displacement [m], as springs store only what drive and start put in."""
    return 2.0 * max(drive.largest_displacement(p), abs(p.initial_displacement))


@jit
def _slip_speed(p: Parameters) -> float:
    """Upper bound of the relative speed of a slip [m/s], the drive's speed plus the springs'.

    The springs are released at the end of a stick, or at the start.
    """
    own, stretched = math.sqrt(2.0 * p.spring_stiffness / p.block_mass), _reach(p)
    if p.spring_stiffness > 0.0:
        stick = _static_strength(p, STRAINS) * p.contact_area
        stretched = min(stretched, stick / (2.0 * p.spring_stiffness))
    stretched = max(stretched, abs(p.initial_displacement))
    return drive.largest_speed(p) + own * stretched + abs(p.initial_velocity)


@inline
def _driving_force(p: Parameters) -> float:
    """Largest force [N] that can accelerate the relative motion, of the drive and the springs."""
    reach = _reach(p)
    if p.spring_stiffness > 0.0:
        reach += abs(p.initial_velocity) * math.sqrt(p.block_mass / (2.0 * p.spring_stiffness))
    return p.block_mass * drive.largest_acceleration(p) + 2.0 * p.spring_stiffness * reach


def _make_limited_speed(stress: Any) -> Any:
    """Return the function (p, fastest) of the largest speed up to `fastest` that friction allows.

    At higher speeds [m/s] the viscous friction exceeds any force that could accelerate the motion,
    as when a viscous film locks the block. The friction of a liquid film, which is the smallest, is
    used.
    """

    @jit
    def limited_speed(p: Parameters, fastest: float) -> float:
        force, slow, fast = _driving_force(p), 0.0, fastest
        if p.contact_area * stress(p, fast, 0.0) <= force:
            return fast
        for _ in range(_BISECTIONS):
            middle = 0.5 * (slow + fast)
            if p.contact_area * stress(p, middle, 0.0) <= force:
                slow = middle
            else:
                fast = middle
        return max(fast, abs(p.initial_velocity))

    return limited_speed


@inline
def _film_rate(p: Parameters, phi: float, slip: float) -> float:
    """Fastest rate of the order parameter [1/s], either of melting in a slip or in the solid."""
    B = film.melting_function(p, friction.elastic_strain(p, slip))
    heating = film.heating(p)
    solid = film.log_force(p, phi, heating) + film.log_force_slope(p, phi)
    return p.kinetic_coefficient * max(abs(B), abs(solid))


@kernel_factory
def rates_kernel(law_name: str) -> Any:
    """Return the kernel (points, rates) that bounds the fastest rate of points.

    `points` (n, parameters); `rates` (n,) [1/s] is output. The rates come from Eqs. 3 and 26:
    elastic plus viscous friction on v, the order parameter in a slip and in the solid, and the
    springs. The rate of the drive is scaled so that the step also resolves the drive.
    """
    law = friction_law(law_name)
    stable_slope, limited_speed = law.stable_slope, _make_limited_speed(law.stress)

    def fastest_rates(points: np.ndarray, rates: np.ndarray) -> None:
        for i in range(points.shape[0]):
            p = parameters_of(points[i])
            phi, slip = solids.largest_order_parameter(p), limited_speed(p, _slip_speed(p))
            slope = film.shear_modulus(p, phi) * friction.strain_slope(p)
            slope += stable_slope(p, slip, phi)
            stiffness, damping = block.own_slopes(p, 0.0, 0.0)
            of_velocity = (slope * p.contact_area - damping) / p.block_mass
            springs = math.sqrt(-stiffness / p.block_mass)
            highest = drive.highest_harmonic(p) * p.angular_frequency
            of_drive = REFUSE_ABOVE * _STEPS_PER_RADIAN * highest
            rates[i] = max(of_velocity, _film_rate(p, phi, slip), springs, of_drive)

    return named_kernel(f"fastest_rates[{law_name}]", fastest_rates)


@kernel
def _write_static_strengths(points: np.ndarray, strains: int, strengths: np.ndarray) -> None:
    for i in range(points.shape[0]):
        strengths[i] = _static_strength(parameters_of(points[i]), strains)


def static_strength(points: np.ndarray, strains: int = STRAINS) -> np.ndarray:
    """Return the largest static elastic stress a phi_plus^2 eps [Pa] of solid films, (n,).

    `points` (n, parameters). This is the maximum over `strains` values of the strain; fewer values
    never give more.
    """
    points = np.ascontiguousarray(np.atleast_2d(points), dtype=float)
    strengths = np.empty(len(points))
    _write_static_strengths(points, strains, strengths)
    return strengths


def fastest_rate(points: np.ndarray, law: str) -> np.ndarray:
    """Return an upper bound of the fastest rate [1/s] of each point, (n, parameters) -> (n,)."""
    points = np.ascontiguousarray(np.atleast_2d(points), dtype=float)
    rates = np.empty(len(points))
    rates_kernel(law)(points, rates)
    return rates


def largest_stable_step(points: np.ndarray, law: str = DEFAULTS.friction) -> np.ndarray:
    """Return the largest accepted fixed step [s] of each point (n, parameters)."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        steps = REFUSE_ABOVE / fastest_rate(points, law)
    return np.nan_to_num(steps, nan=0.0)  # a rate that overflows allows no step
