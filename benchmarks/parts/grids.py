"""Large grids over the parameters of the paper."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

FLUIDS = ["-2/3", 0, "2/3"]

# Of the large sweeps: a point settles within some ten to a hundred periods or not at all, and the
# few that never do (gamma = -2/3 at small k) would take most of the time of the others together.
MOST_PERIODS = 500


def grid_config(shape: tuple[int, ...], fluids: list[Any], **others: Any) -> dict[str, Any]:
    """The config of a grid over T, k, K, omega and fluids, over the ranges of the cube."""
    ranges = {
        "temperature": ("linspace", 150, 320),
        "viscosity_coefficient": ("geomspace", 1e4, 2e5),
        "spring_stiffness": ("geomspace", 500, 1e4),
        "angular_frequency": ("geomspace", 5, 60),
    }
    axes: dict[str, Any] = {
        name: {kind: [low, high], "num": count}
        for (name, (kind, low, high)), count in zip(ranges.items(), shape, strict=False)
    }
    budget = {"stationary": {"max_periods": MOST_PERIODS}}
    return {"sweep": axes | {"rheological_index": fluids}} | budget | others


def written(path: Path, config: dict[str, Any]) -> Path:
    """A config as a file."""
    path.write_text(json.dumps(config))  # JSON is YAML
    return path
