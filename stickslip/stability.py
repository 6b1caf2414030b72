"""Is a fixed step stable? The fastest rates of a point, before anything is computed.

An explicit step beyond 2/(fastest rate) need not overflow: it gives finite, plausible and wrong
amplitudes. So the rates are bounded from the parameters alone, with the speed of a free slip
instead of the drive's, and an unstable step is refused. The infinite viscous slope of a
pseudoplastic fluid at V = v is left out: its chatter stays of the order of the step.
"""

from __future__ import annotations

from decimal import ROUND_FLOOR, Context

import numpy as np

from stickslip.parameters import ParameterValues

REFUSE_ABOVE = 2.0
"""Step times fastest rate from which an explicit step is unstable."""

ACCURATE_PART = 0.25
"""Part of the largest stable step from which a fixed step is stable but inaccurate."""

# An explicit scheme follows the drive with an error of omega dt: at least this many steps a radian.
_STEPS_PER_RADIAN = 20.0

_STRAINS = 200  # the static maximum of the stress is flat: 200 strains give it to 1e-4


def fastest_rate(points: np.ndarray) -> np.ndarray:
    """Upper bound of the fastest rate [1/s] of each row of parameters, shape (n, 20) -> (n,).

    The rates are those of Eqs. 3 and 26: elastic plus viscous friction on v, the order parameter
    in the slip and in the solid, and the springs; the drive's is scaled so that a step it allows
    also resolves it.
    """
    p = ParameterValues(*np.atleast_2d(points).T)
    phi = _largest_order_parameter(p)
    slip = _slip_speed(p)
    strain = slip * p.strain_relaxation_time / p.film_thickness
    elastic = p.elastic_coefficient * phi**2 * p.strain_relaxation_time / p.film_thickness
    gamma = np.maximum(p.rheological_index, 0.0)
    viscous = np.where(
        p.rheological_index >= 0.0,
        p.viscosity_coefficient
        * (gamma + 1.0)
        / p.film_thickness
        * (slip / p.film_thickness) ** gamma,
        0.0,
    )
    friction = (elastic + viscous) * p.contact_area / p.block_mass
    heating = 2.0 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    melting = p.kinetic_coefficient * np.abs(p.elastic_coefficient * strain**2 + heating)
    solid = p.kinetic_coefficient * np.abs(
        heating - 2.0 * p.cubic_coefficient * phi + 3.0 * p.quartic_coefficient * phi**2
    )
    springs = np.sqrt(2.0 * p.spring_stiffness / p.block_mass)
    drive = REFUSE_ABOVE * _STEPS_PER_RADIAN * p.angular_frequency
    return np.max([friction, melting, solid, springs, drive], axis=0)


def largest_stable_step(points: np.ndarray) -> np.ndarray:
    """Largest fixed step [s] that is not refused, for each row of parameters."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        steps = REFUSE_ABOVE / fastest_rate(points)
    return np.nan_to_num(steps, nan=0.0)  # a rate beyond all numbers allows no step


def step_as_text(step: float) -> str:
    """Two digits of a largest step, rounded down: typed in, it is allowed."""
    return f"{Context(prec=2, rounding=ROUND_FLOOR).create_decimal_from_float(step):g}"


def _largest_order_parameter(p: ParameterValues, strain: np.ndarray | float = 0.0) -> np.ndarray:
    """The stable order parameter of Eq. 16, b/2c where there is none."""
    half = 0.5 * p.cubic_coefficient / p.quartic_coefficient
    B = p.elastic_coefficient * np.square(strain) + 2.0 * p.thermal_coefficient * (
        p.temperature - p.critical_temperature
    )
    return np.asarray(half + np.sqrt(np.maximum(half**2 - B / p.quartic_coefficient, 0.0)))


def _slip_speed(p: ParameterValues) -> np.ndarray:
    """Relative speed [m/s] of a slip: the drive's, and that of springs let go by a stick."""
    stick = _strength(p) * p.contact_area
    with np.errstate(divide="ignore", invalid="ignore"):
        release = np.sqrt(2.0 * p.spring_stiffness / p.block_mass) * stick
        release = np.where(p.spring_stiffness > 0.0, release / (2.0 * p.spring_stiffness), 0.0)
    # Springs cannot store more than the amplitude (and the start) puts into them.
    reach = np.maximum(np.abs(p.drive_amplitude), np.abs(p.initial_displacement))
    release = np.minimum(release, np.sqrt(2.0 * p.spring_stiffness / p.block_mass) * 2.0 * reach)
    drive = np.abs(p.drive_amplitude) * p.angular_frequency
    return np.asarray(drive + release + np.abs(p.initial_velocity))


def static_strength(points: np.ndarray, strains: int = _STRAINS) -> np.ndarray:
    """Largest static elastic stress a phi_plus^2 eps [Pa] of a solid film, for each row (n, 20).

    Looked for over so many strains: fewer give less, never more, than the maximum.
    """
    return _strength(ParameterValues(*np.atleast_2d(points).T), strains)


def _strength(p: ParameterValues, strains: int = _STRAINS) -> np.ndarray:
    B = p.cubic_coefficient**2 / (4.0 * p.quartic_coefficient) + 2.0 * p.thermal_coefficient * (
        p.critical_temperature - p.temperature
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        limit = np.where(
            p.elastic_coefficient > 0.0, np.sqrt(np.maximum(B, 0.0) / p.elastic_coefficient), 0.0
        )
    fractions = np.linspace(0.0, 1.0, strains)[:, None]
    strain = fractions * limit
    stress = p.elastic_coefficient * _largest_order_parameter(p, strain) ** 2 * strain
    return np.asarray(stress.max(axis=0))
