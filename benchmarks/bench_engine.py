"""The sweep engine on large grids: points per second, its own share of the time, memory, files.

Overhead is what the cores did not spend in the kernels, from the first block to the finished file:
wall time times workers minus the seconds in compiled calls, over wall time times workers.
"""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path
from typing import Any

from command import MIB, run_command
from common import arguments, finish, quantile

WORKERS = 2

# As cheap as points get: a Newtonian liquid, which never solidifies.
LIQUID = {
    "temperature": {"linspace": [300, 350]},
    "viscosity_coefficient": {"geomspace": [1e4, 1e6]},
    "spring_stiffness": {"linspace": [500, 5000]},
}
# What a figure of the paper is made of: stick-slip of three lubricants.
STICK_SLIP = {
    "temperature": {"linspace": [150, 280]},
    "viscosity_coefficient": {"geomspace": [3e4, 2e5]},
    "spring_stiffness": {"geomspace": [1000, 1e4]},
}
FLUIDS = {"liquid": [0], "stick-slip": ["-2/3", 0, "2/3"]}
RTOL = 1e-4
MOST_PERIODS = 500


def main() -> None:
    quick = arguments(__doc__).quick
    sizes = [(4, 5, 5), (10, 10, 10)] if quick else [(10, 100, 100), (100, 100, 100)]
    runs = 1 if quick else 3
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        liquid = [_swept(where, "liquid", LIQUID, shape, runs) for shape in sizes]
        shape = (4, 4, 4) if quick else (40, 40, 40)
        slip = _swept(where, "stick-slip", STICK_SLIP, shape, runs)
        huge = _huge(where, (10, 10, 10, 3) if quick else (100, 100, 100, 10), quick=quick)
    results = {"workers": WORKERS, "rtol": RTOL, "sweeps": [*liquid, slip], "huge": huge}
    finish("engine", results, quick=quick)


def _swept(
    where: Path, scene: str, axes: dict[str, Any], shape: tuple[int, ...], runs: int
) -> dict[str, Any]:
    """Medians of a sweep through the command line."""
    config, path = _config(where, axes, shape, FLUIDS[scene]), where / "a.nc"
    rows = [_once(config, path) for _ in range(runs + 1)][1:]  # the first warms up
    row = {name: quantile([row[name] for row in rows], 50) for name in rows[0]}
    result = {"scene": scene, "points": math.prod(shape) * len(FLUIDS[scene]), "runs": runs} | row
    print(result)
    return result


def _once(config: Path, path: Path) -> dict[str, float]:
    words = ("sweep", config, "-o", path, "--workers", str(WORKERS), "--overwrite", "--no-progress")
    took = run_command(*words)
    timing = json.loads(path.with_name(path.name + ".timing.json").read_text())
    cores = timing["seconds"] * WORKERS
    own = cores - timing["kernel_seconds"]
    return {
        "command_seconds": took["seconds"],
        "seconds": timing["seconds"],
        "points_per_second": timing["points_per_second"],
        "kernel_us_per_point": 1e6 * timing["kernel_seconds"] / timing["points"],
        "overhead_us_per_point": 1e6 * own / timing["points"],
        "overhead_part": own / cores,
        "peak_mib": took["peak_mib"],
        "file_mib": path.stat().st_size / MIB,
    }


def _huge(where: Path, shape: tuple[int, ...], *, quick: bool) -> dict[str, Any]:
    """A grid that is planned, run in part, resumed and exported."""
    axes = LIQUID | {"angular_frequency": {"linspace": [5, 50]}}
    config, path = _config(where, axes, shape, FLUIDS["liquid"]), where / "huge.nc"
    part = ("sweep", config, "-o", path, "--max-runtime", "1s" if quick else "20s")
    steps = {
        "plan": ("plan", config, "-o", path),
        "part": part,
        "resumed": part,
        "status": ("status", path, "--json"),
        "export": ("sweep", config, "-o", path, "--partial"),
    }
    result: dict[str, Any] = {"points": math.prod(shape)}
    for step, words in steps.items():
        took = run_command(*words, stopped=True)
        result[step] = {name: took[name] for name in ("seconds", "peak_mib", "code")}
        if step == "status":
            result["done"] = json.loads(took["said"])["done"]
    result["file_mib"] = path.stat().st_size / MIB
    print(result)
    return result


def _config(where: Path, axes: dict[str, Any], shape: tuple[int, ...], fluids: list[Any]) -> Path:
    named = {
        name: form | {"num": count} for (name, form), count in zip(axes.items(), shape, strict=True)
    }
    path = where / "engine.yaml"
    settings = {
        "sweep": named | {"rheological_index": fluids},
        "integrator": {"rtol": RTOL},
        "stationary": {"rtol": RTOL, "max_periods": MOST_PERIODS},
    }
    path.write_text(json.dumps(settings))  # JSON is YAML
    return path


if __name__ == "__main__":
    main()
