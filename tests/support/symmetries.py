"""The exact symmetries of the model, with powers of two as factors, so that nothing is rounded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip import Parameters
from stickslip.variables import RESULT_COLUMNS


class Symmetry(NamedTuple):
    """Factors of parameters, and the factors of stress, force and motion that follow."""

    factors: dict[str, float]
    stress: float
    force: float
    motion: float


SYMMETRIES = {
    "mirror": Symmetry(
        {"drive_amplitude": -1.0, "initial_displacement": -1.0, "initial_velocity": -1.0},
        stress=-1.0,
        force=-1.0,
        motion=-1.0,
    ),
    "length": Symmetry(
        {
            "drive_amplitude": 2.0,
            "initial_displacement": 2.0,
            "initial_velocity": 2.0,
            "film_thickness": 2.0,
            "contact_area": 2.0,
        },
        stress=1.0,
        force=2.0,
        motion=2.0,
    ),
    "mass": Symmetry(
        {"block_mass": 2.0, "spring_stiffness": 2.0, "contact_area": 2.0},
        stress=1.0,
        force=2.0,
        motion=1.0,
    ),
    "stress": Symmetry(
        {
            "thermal_coefficient": 2.0,
            "elastic_coefficient": 2.0,
            "cubic_coefficient": 2.0,
            "quartic_coefficient": 2.0,
            "quintic_coefficient": 2.0,
            "sextic_coefficient": 2.0,
            "viscosity_coefficient": 2.0,
            "contact_area": 0.5,
            "kinetic_coefficient": 0.5,
        },
        stress=2.0,
        force=1.0,
        motion=1.0,
    ),
}


def transformed(p: Parameters, symmetry: Symmetry) -> Parameters:
    return p._replace(
        **{name: factor * getattr(p, name) for name, factor in symmetry.factors.items()}
    )


def expected(row: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    """Return the result row of the transformed point."""
    named = dict(zip(RESULT_COLUMNS, row.tolist(), strict=True))
    for name, factor in (("elastic_stress", symmetry.stress), ("friction_force", symmetry.force)):
        high, low = factor * named[f"{name}_max"], factor * named[f"{name}_min"]
        named[f"{name}_max"], named[f"{name}_min"] = (high, low) if factor > 0 else (low, high)
        for amplitude in (f"{name}_amplitude", f"{name}_amplitude_spread"):
            named[amplitude] *= abs(factor)
    for energy in ("dissipated_energy", "dissipated_energy_error"):
        named[energy] *= symmetry.force * symmetry.motion
    for phase in ("in_phase", "out_of_phase"):  # the drive changes sign with the force
        for name in (f"friction_force_{phase}", f"friction_force_{phase}_error"):
            named[name] *= abs(symmetry.force)
    for name in ("friction_force_rms", "friction_force_mean_abs"):
        named[name] *= abs(symmetry.force)
    return np.array(list(named.values()))
