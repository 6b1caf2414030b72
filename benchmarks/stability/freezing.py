"""Films that freeze late, or within a short passage of the strain through zero.

Late: started off rest near resonance, a weakly damped block turns round its limit for hundreds of
periods, and now and then hardly moves against the drive: then its film freezes, or never. Short: a
fast drive leaves a liquid film the strains at which it freezes for a ten-thousandth of a period.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import (
    column,
    description,
    good,
    log_uniform,
    orbits,
    worse_errors,
)

from stickslip.options import Options
from stickslip.parameters import Parameters, ParameterValues
from stickslip.regime import Regime

_SEED_LATE, _SEED_REST, _SEED_SHORT = 4911, 4912, 4913
_INDICES = (-2 / 3, -1 / 3, 0.0, 2 / 3)
_SAME = 1e-3  # between orbits that are the same
_OF_THE_WAY = 0.05  # from the way, a growth in which a film may freeze or not
_TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
_FINE, _FINEST = 1e-8, 1e-10
_PLAIN_PERIODS = 8000


def run(quick: bool) -> dict[str, Any]:
    """Count searches that end elsewhere than plain iteration, and films that tolerances change."""
    return {
        "late": _late(_near_resonance(20 if quick else 600, _SEED_LATE, at_rest=False)),
        "rest": _late(_near_resonance(10 if quick else 400, _SEED_REST, at_rest=True)),
        "short": _short(short_passages(20 if quick else 500, _SEED_SHORT)),
    }


def _index(rng: np.random.Generator, i: int, low: float, high: float) -> float:
    """Return every other rheological index from the fluids with kernels of their own."""
    return _INDICES[i // 2 % len(_INDICES)] if i % 2 else float(rng.uniform(low, high))


def _viscosity(part: float, p: Parameters) -> float:
    """Return the k whose force at the speed of the drive is this part of the full force."""
    inertia = p.block_mass * p.angular_frequency**2
    force = part * max(2.0 * p.spring_stiffness, inertia) * p.drive_amplitude
    rate = p.drive_amplitude * p.angular_frequency / p.film_thickness
    return force / p.contact_area / rate ** (p.rheological_index + 1.0)


def _with_passage(p: Parameters, ratio: float, growth: float) -> Parameters:
    """Return a film whose strain at the drive's speed is `ratio` solidification strains.

    ln(phi) grows by `growth` in a passage of that strain through zero.
    """
    heating = 2.0 * p.thermal_coefficient * (p.critical_temperature - p.temperature)
    critical, speed = (
        np.sqrt(heating / p.elastic_coefficient),
        p.drive_amplitude * p.angular_frequency,
    )
    relaxation = ratio * critical * p.film_thickness / speed
    delta = 0.75 * growth * ratio * p.angular_frequency / heating
    return p._replace(strain_relaxation_time=relaxation, kinetic_coefficient=delta)


def _near_resonance(count: int, seed: int, *, at_rest: bool) -> np.ndarray:
    """Return films with a weak viscosity and 2K near M omega^2, (count, parameters)."""
    rng, rows = np.random.default_rng(seed), []
    for i in range(count):
        omega, mass = log_uniform(rng, 5.0, 100.0), log_uniform(rng, 0.1, 3.0)
        amplitude, ratio = log_uniform(rng, 1e-7, 3e-6), log_uniform(rng, 1.0, 30.0)
        p = Parameters(
            temperature=rng.uniform(150.0, 285.0),
            rheological_index=_index(rng, i, -0.9, 0.9),
            angular_frequency=omega,
            block_mass=mass,
            spring_stiffness=0.5 * mass * omega**2 * (1.0 + rng.uniform(-0.1, 0.1)),
            drive_amplitude=amplitude,
            contact_area=log_uniform(rng, 1e-10, 2e-9),
            noise_intensity=log_uniform(rng, 1e-20, 1e-17),
            initial_displacement=0.0 if at_rest else rng.uniform(-3.0, 3.0) * amplitude,
            initial_velocity=0.0 if at_rest else rng.uniform(-2.0, 2.0) * amplitude * omega,
        )
        at_rest_for_half = log_uniform(rng, 20.0, 630.0)  # growth of ln(phi)
        p = _with_passage(p, ratio, 4.0 / 3.0 * at_rest_for_half / np.pi / ratio)
        rows.append(p._replace(viscosity_coefficient=_viscosity(log_uniform(rng, 1e-3, 0.1), p)))
    return np.array(rows)


def short_passages(count: int, seed: int) -> np.ndarray:
    """Return films that can freeze in a short passage of the strain, (count, parameters)."""
    rng, rows = np.random.default_rng(seed), []
    for i in range(count):
        p = Parameters(
            temperature=rng.uniform(1.0, 285.0),
            rheological_index=_index(rng, i, -0.9, 1.2),
            angular_frequency=log_uniform(rng, 3.0, 100.0),
            block_mass=log_uniform(rng, 0.1, 1.0),
            spring_stiffness=log_uniform(rng, 200.0, 1e4),
            drive_amplitude=log_uniform(rng, 5e-8, 2e-6),
            film_thickness=log_uniform(rng, 3e-10, 3e-9),
            contact_area=log_uniform(rng, 5e-12, 1e-9),
            noise_intensity=log_uniform(rng, 1e-24, 1e-13),
        )
        p = _with_passage(p, log_uniform(rng, 10.0, 1e5), log_uniform(rng, 8.0, 200.0))
        rows.append(p._replace(viscosity_coefficient=_viscosity(log_uniform(rng, 1e-3, 2.0), p)))
    return np.array(rows)


def _differ(points: np.ndarray, found: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return which points, ok in both, have another regime or other amplitudes, (n,)."""
    ok = good(found) & good(other)
    same = worse_errors(points, _amplitudes(found), _amplitudes(other)) <= _SAME
    return ok & ~(same & (column(found, "regime") == column(other, "regime")))


def _amplitudes(results: np.ndarray) -> np.ndarray:
    names = ("elastic_stress_amplitude", "friction_force_amplitude")
    return np.column_stack([column(results, name) for name in names])


def _late(points: np.ndarray) -> dict[str, Any]:
    """Compare the search with plain iteration where that ends alike at two tolerances."""
    found = orbits(points, Options())
    plain, fine = (
        orbits(points, Options(rtol=rtol, accelerate=False, max_periods=_PLAIN_PERIODS))
        for rtol in (1e-6, _FINE)
    )
    compared = good(found) & good(plain) & good(fine) & ~_differ(points, plain, fine)
    wrong = compared & _differ(points, found, plain)
    return {
        "points": len(points),
        "compared": int(compared.sum()),
        "undecided": int(_differ(points, plain, fine).sum()),
        "frozen": int((compared & (column(plain, "regime") != Regime.LIQUID)).sum()),
        "wrong": [description(points[i]) for i in np.flatnonzero(wrong)],
        "periods": float(column(found, "periods_integrated")[compared].mean()),
        "periods_plain": float(column(plain, "periods_integrated")[compared].mean()),
    }


def _short(points: np.ndarray) -> dict[str, Any]:
    """Count films that another tolerance freezes or not, where two fine ones agree."""
    fine, finest = (
        orbits(points, Options(rtol=rtol, stationary_rtol=1e-8)) for rtol in (_FINE, _FINEST)
    )
    compared = good(fine) & good(finest) & ~_differ(points, fine, finest)
    near = np.abs(growths(points) / ways(points) - 1.0) <= _OF_THE_WAY
    rows = []
    for rtol in _TOLERANCES:
        found = orbits(points, Options(rtol=rtol))
        liquid, truly = (column(r, "regime") == Regime.LIQUID for r in (found, fine))
        missed = compared & good(found) & (liquid != truly)
        rows.append(
            {
                "rtol": rtol,
                "compared": int((compared & good(found)).sum()),
                "missed": int((missed & ~near).sum()),
                "missed_near": int((missed & near).sum()),
                "other_orbit": int((compared & _differ(points, found, fine)).sum()),
            }
        )
    return {"points": len(points), "steps": rows}


def growths(points: np.ndarray) -> np.ndarray:
    """Return the growth of ln(phi) in a passage at the rate of the drive, (n,)."""
    p = ParameterValues(*points.T)
    heating = 2.0 * p.thermal_coefficient * (p.critical_temperature - p.temperature)
    rate = p.drive_amplitude * p.angular_frequency**2 * p.strain_relaxation_time / p.film_thickness
    return np.asarray(
        4 / 3 * p.kinetic_coefficient * heating * np.sqrt(heating / p.elastic_coefficient) / rate
    )


def ways(points: np.ndarray) -> np.ndarray:
    """Return the growth of ln(phi) from the level of the noise at rest to b/2c, (n,)."""
    p = ParameterValues(*points.T)
    heating = 2.0 * p.thermal_coefficient * (p.critical_temperature - p.temperature)
    level = np.sqrt(0.2807297 * p.noise_intensity / (heating * p.kinetic_coefficient))
    return np.asarray(np.log(0.5 * p.cubic_coefficient / p.quartic_coefficient / level))
