"""Films that freeze late, or within a short passage of the strain through zero.

Late: started off rest near resonance, a weakly damped block turns round its limit for hundreds of
periods, and now and then hardly moves against the drive: then its film freezes, or never. Short: a
fast drive leaves a liquid film the strains at which it freezes for a ten-thousandth of a period.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from shared.points import Orbits, descriptions, drawn, log_uniform, orbits

from stickslip.parameters import Parameters, ParameterValues
from stickslip.regime import Regime

_INDICES = (-2 / 3, -1 / 3, 0.0, 2 / 3)
_SAME = 1e-3  # between orbits that are the same
_OF_THE_WAY = 0.05  # from the way, a growth in which a film may freeze or not
_TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
_FINE, _FINEST = 1e-8, 1e-10
_PLAIN_PERIODS = 8000


def run(quick: bool) -> dict[str, Any]:
    """Count searches that end elsewhere than plain iteration, and films that tolerances change."""
    late = drawn(20 if quick else 600, 4911, partial(_near_resonance, at_rest=False))
    rest = drawn(10 if quick else 400, 4912, partial(_near_resonance, at_rest=True))
    short = drawn(20 if quick else 500, 4913, _short_passage)
    return {"late": _late(late), "rest": _late(rest), "short": _short(short)}


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
    critical = np.sqrt(heating / p.elastic_coefficient)
    speed = p.drive_amplitude * p.angular_frequency
    relaxation = ratio * critical * p.film_thickness / speed
    delta = 0.75 * growth * ratio * p.angular_frequency / heating
    return p._replace(strain_relaxation_time=relaxation, kinetic_coefficient=delta)


def _near_resonance(rng: np.random.Generator, i: int, *, at_rest: bool) -> Parameters:
    """Return a film with a weak viscosity and 2K near M omega^2."""
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
    return p._replace(viscosity_coefficient=_viscosity(log_uniform(rng, 1e-3, 0.1), p))


def _short_passage(rng: np.random.Generator, i: int) -> Parameters:
    """Return a film that can freeze in a short passage of the strain."""
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
    return p._replace(viscosity_coefficient=_viscosity(log_uniform(rng, 1e-3, 2.0), p))


def _differ(found: Orbits, other: Orbits) -> np.ndarray:
    """Return which points, ok in both, have another regime or other amplitudes, (n,)."""
    same = (found.errors(other) <= _SAME) & (found.regime == other.regime)
    return found.ok & other.ok & ~same


def _late(points: np.ndarray) -> dict[str, Any]:
    """Compare the search with plain iteration where that ends alike at two tolerances."""
    found = orbits(points)
    plain, fine = (
        orbits(points, rtol=rtol, accelerate=False, max_periods=_PLAIN_PERIODS)
        for rtol in (1e-6, _FINE)
    )
    compared = found.ok & plain.ok & fine.ok & ~_differ(plain, fine)
    return {
        "points": len(points),
        "compared": int(compared.sum()),
        "undecided": int(_differ(plain, fine).sum()),
        "frozen": int((compared & (plain.regime != Regime.LIQUID)).sum()),
        "wrong": descriptions(points, compared & _differ(found, plain)),
        "periods": float(found.periods_integrated[compared].mean()),
        "periods_plain": float(plain.periods_integrated[compared].mean()),
    }


def _short(points: np.ndarray) -> dict[str, Any]:
    """Count films that another tolerance freezes or not, where two fine ones agree."""
    fine, finest = (orbits(points, rtol=rtol, stationary_rtol=1e-8) for rtol in (_FINE, _FINEST))
    agreed = fine.ok & finest.ok & ~_differ(fine, finest)
    near, rows = np.abs(_growth_over_way(points) - 1.0) <= _OF_THE_WAY, []
    for rtol in _TOLERANCES:
        found = orbits(points, rtol=rtol)
        compared = agreed & found.ok
        missed = compared & ((found.regime == Regime.LIQUID) != (fine.regime == Regime.LIQUID))
        counts = {
            "compared": compared,
            "missed": missed & ~near,
            "missed_near": missed & near,
            "other_orbit": agreed & _differ(found, fine),
        }
        rows.append({"rtol": rtol} | {name: int(of.sum()) for name, of in counts.items()})
    return {"points": len(points), "steps": rows}


def _growth_over_way(points: np.ndarray) -> np.ndarray:
    """Return by how much ln(phi) grows in a passage, over its way from the noise to b/2c, (n,)."""
    p = ParameterValues(*points.T)
    heating = 2.0 * p.thermal_coefficient * (p.critical_temperature - p.temperature)
    rate = p.drive_amplitude * p.angular_frequency**2 * p.strain_relaxation_time / p.film_thickness
    critical = np.sqrt(heating / p.elastic_coefficient)
    level = np.sqrt(0.2807297 * p.noise_intensity / (heating * p.kinetic_coefficient))
    way = np.log(0.5 * p.cubic_coefficient / p.quartic_coefficient / level)
    return np.asarray(4 / 3 * p.kinetic_coefficient * heating * critical / rate / way)
