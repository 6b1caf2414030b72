"""Large grids over the parameters of the paper, and sweeps of them through the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

WORKERS = 2
SWEEP = ("--workers", str(WORKERS), "--overwrite", "--no-progress")
FLUIDS = ["-2/3", 0, "2/3"]

# Of large sweeps: a point settles within some ten to a hundred periods or not at all, and the few
# that never do (gamma = -2/3 at small k) would take most of the time of the others together.
MOST_PERIODS = 500

CUBE = {
    "temperature": {"linspace": [150, 320]},
    "viscosity_coefficient": {"geomspace": [1e4, 2e5]},
    "spring_stiffness": {"geomspace": [500, 1e4]},
    "angular_frequency": {"geomspace": [5, 60]},
}
# As cheap as points get: a Newtonian liquid, which never solidifies.
LIQUID = {
    "temperature": {"linspace": [300, 350]},
    "viscosity_coefficient": {"geomspace": [1e4, 1e6]},
    "spring_stiffness": {"linspace": [500, 5000]},
    "angular_frequency": {"linspace": [5, 50]},
}
# What a figure of the paper is made of.
STICK_SLIP = {
    "temperature": {"linspace": [150, 280]},
    "viscosity_coefficient": {"geomspace": [3e4, 2e5]},
    "spring_stiffness": {"geomspace": [1000, 1e4]},
}


def grid_config(
    axes: dict[str, Any],
    shape: tuple[int, ...],
    fluids: list[Any],
    rtol: float = 1e-6,
    stationary_rtol: float = 1e-6,
) -> dict[str, Any]:
    """Return the config of a grid over fluids and the first axes, so many values each."""
    sizes = {name: axes[name] | {"num": n} for name, n in zip(axes, shape, strict=False)}
    return {
        "sweep": sizes | {"rheological_index": fluids},
        "integrator": {"rtol": rtol},
        "stationary": {"rtol": stationary_rtol, "max_periods": MOST_PERIODS},
    }


def write_config(path: Path, config: dict[str, Any]) -> Path:
    """Write a config to a file, and return its path."""
    path.write_text(json.dumps(config))  # JSON is YAML
    return path
