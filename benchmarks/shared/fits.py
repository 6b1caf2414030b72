"""Random measurements to be fitted: of known parameters with noise, and of none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shared.points import log_uniform
from stickslip import stationary_orbits
from stickslip.variables import PARAMETERS

PAIRS = (
    ("viscosity_coefficient", "rheological_index"),
    ("viscosity_coefficient", "spring_stiffness"),
    ("rheological_index", "spring_stiffness"),
    ("viscosity_coefficient", "critical_temperature"),
    ("rheological_index", "film_thickness"),
)
VARIED = ("temperature", "angular_frequency", "spring_stiffness")
FORCE, STRESS = "friction_force_amplitude", "elastic_stress_amplitude"
NOISES = (0.01, 0.05)
MOST_PERIODS, MOST_STEPS = 60, 30_000
"""A set is cheap if the orbits of its data are found within so many periods and steps."""

FOUR = ("viscosity_coefficient", "rheological_index", "critical_temperature", "contact_area")
FOUR_T = np.linspace(150.0, 310.0, 14)
FOUR_NOISE = 0.02
FLOOR = 0.5
"""Part of the largest value of a variable that its errors are no smaller than a part of."""

SEED = 2026
Floats = NDArray[np.float64]


class Set(NamedTuple):
    """Synthetic measurements by column, the parameters that are free, their truth and a start.

    `exact` are the same without noise; `crosses` tells whether their motions are of several kinds.
    """

    free: tuple[str, ...]
    true: dict[str, float]
    start: dict[str, float]
    data: dict[str, Floats]
    exact: dict[str, Floats] | None = None
    crosses: bool = False


def sets(count: int) -> Iterator[Set]:
    """Yield cheap random sets; the data of every fourth have motions of different kinds."""
    rng, found = np.random.default_rng(SEED), 0
    while found < count:
        candidate = _candidate(rng, found)
        if candidate is not None and candidate.crosses == (found % 4 == 3):
            found += 1
            yield candidate


def _candidate(rng: np.random.Generator, number: int) -> Set | None:
    free = PAIRS[rng.integers(len(PAIRS))]
    name = rng.choice([name for name in VARIED if name not in free])
    values = {
        "temperature": rng.uniform(160.0, 310.0),
        "viscosity_coefficient": log_uniform(rng, 1e4, 3e5),
        "spring_stiffness": log_uniform(rng, 1e3, 1e4),
        "rheological_index": rng.uniform(-0.75, 0.5),
        "angular_frequency": log_uniform(rng, 5.0, 30.0),
        "critical_temperature": rng.uniform(280.0, 300.0),
        "film_thickness": log_uniform(rng, 0.7e-9, 1.5e-9),
    }
    width = rng.uniform(1.2, 1.6)
    varied = {str(name): values.pop(name) * np.linspace(1 / width, width, rng.integers(8, 15))}
    ds = stationary_orbits(values | varied, max_periods=MOST_PERIODS, max_steps=MOST_STEPS)
    force = ds[FORCE].values
    if (ds.status != 0).any() or np.ptp(force) < 0.02 * force.max():
        return None
    kinds = np.stack([ds[kind].values for kind in ("regime", "melting_count", "orbit_periods")])
    start = values | {each: _moved(rng, each, values[each]) for each in free}
    noise = NOISES[number % 2]
    own = noise * np.random.default_rng([SEED, number]).standard_normal(len(force))
    data = varied | {FORCE: force * (1.0 + own)}
    if number % 2:  # errors are given for one of the noises
        data[f"{FORCE}_error"] = noise * force
    crosses = bool((np.ptp(kinds, axis=1) > 0).any())
    return Set(free, values, start, data, varied | {FORCE: force}, crosses)


def _moved(rng: np.random.Generator, name: str, value: float) -> float:
    """Return a start for a parameter: off by a factor of up to 3, or by 0.3."""
    if PARAMETERS[name].measured_in is not None:
        return float(max(value + rng.uniform(-0.3, 0.3), -0.9))
    wide = 1.05 if PARAMETERS[name].units == "K" else 3.0
    return value * log_uniform(rng, 1 / wide, wide)


def four_set(number: int) -> Set:
    """Return measurements with four free parameters; orbits are found early."""
    rng = np.random.default_rng([SEED, 4, number])
    while True:
        true = {
            "viscosity_coefficient": log_uniform(rng, 2e4, 2e5),
            "rheological_index": rng.uniform(-0.75, -0.3),
            "critical_temperature": rng.uniform(280.0, 300.0),
            "contact_area": log_uniform(rng, 4e-10, 9e-10),
        }
        ds = stationary_orbits({"T": FOUR_T} | true, max_periods=MOST_PERIODS, max_steps=MOST_STEPS)
        if (ds.status == 0).all():
            break
    start = {
        "viscosity_coefficient": true["viscosity_coefficient"] * log_uniform(rng, 1 / 3, 3.0),
        "rheological_index": max(true["rheological_index"] + rng.uniform(-0.3, 0.3), -0.9),
        "critical_temperature": true["critical_temperature"] * rng.uniform(0.98, 1.02),
        "contact_area": true["contact_area"] * log_uniform(rng, 0.7, 1.4),
    }
    data = {"T": FOUR_T}
    for name in (FORCE, STRESS):
        exact = ds[name].values
        error = FOUR_NOISE * np.maximum(exact, FLOOR * exact.max())
        data |= {name: exact + error * rng.standard_normal(len(exact)), f"{name}_error": error}
    return Set(FOUR, true, start, data)
