"""Random parameters around the paper's."""

from __future__ import annotations

import numpy as np

from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS, STARTING

# These stay as in the paper.
_KEPT = {*STARTING, "quintic_coefficient", "sextic_coefficient"}


def random_parameters(rng: np.random.Generator, gamma: float) -> Parameters:
    """Return parameters of a fluid with this rheological index, within a decade of the paper's.

    Parameters that are not named here are random too, so that no test misses a new one.
    """

    def around(value: float) -> float:
        return value * 10.0 ** rng.uniform(-1, 1)

    drawn = {
        "temperature": rng.uniform(100.0, 350.0),
        "viscosity_coefficient": around(5e4),
        "spring_stiffness": around(3e3),
        "rheological_index": gamma,
        "angular_frequency": around(10.0),
        "drive_amplitude": around(0.8e-6) * rng.choice([-1.0, 1.0]),
        "block_mass": around(0.4),
        "film_thickness": around(1e-9),
        "strain_relaxation_time": around(1e-8),
        "contact_area": around(0.6e-9),
        "kinetic_coefficient": around(100.0),
        "thermal_coefficient": around(0.95),
        "critical_temperature": rng.uniform(200.0, 350.0),
        "elastic_coefficient": around(4e12),
        "cubic_coefficient": around(230.0),
        "quartic_coefficient": around(850.0),
        "noise_intensity": 10.0 ** rng.uniform(-24, -12),
        "third_harmonic": rng.uniform(-0.5, 0.5),
        "fifth_harmonic": rng.uniform(-0.5, 0.5),
    }
    others = [name for name in PARAMETERS if name not in _KEPT | drawn.keys()]
    unnamed = {name: around(PARAMETERS[name].default or 1.0) for name in others}
    return Parameters(**drawn, **{n: min(x, PARAMETERS[n].upper) for n, x in unnamed.items()})
