"""What the sweep engine adds to the kernels on large grids, in time, memory and bytes.

Its share is what the cores did not spend in compiled calls, from the first block to the finished
file.
"""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path
from typing import Any

from shared.commands import MIB, run_command
from shared.grids import FLUIDS, LIQUID, STICK_SLIP, SWEEP, WORKERS, grid_config, write_config
from shared.measuring import measure
from shared.points import quantile

RTOL = (1e-4, 1e-4)  # of the integration, and of stationarity


def grids(quick: bool) -> dict[str, Any]:
    """Measure large grids of a liquid and of stick-slip."""
    sizes = [(4, 5, 5), (10, 10, 10)] if quick else [(10, 100, 100), (100, 100, 100)]
    runs, shape = (1, (4, 4, 4)) if quick else (3, (40, 40, 40))
    scenes = [("liquid", grid_config(LIQUID, size, [0], *RTOL)) for size in sizes]
    scenes.append(("stick-slip", grid_config(STICK_SLIP, shape, FLUIDS, *RTOL)))
    with tempfile.TemporaryDirectory() as folder:
        return {"sweeps": [_swept(Path(folder), *scene, runs) for scene in scenes]}


def _swept(where: Path, scene: str, config: dict[str, Any], runs: int) -> dict[str, Any]:
    """Return medians of a sweep through the command line; the first run warms up."""
    file, path = write_config(where / "engine.yaml", config), where / "a.nc"
    rows = [_once(file, path) for _ in range(runs + 1)][1:]
    return {"scene": scene} | {name: quantile([row[name] for row in rows], 50) for name in rows[0]}


def _once(config: Path, path: Path) -> dict[str, float]:
    took = run_command("sweep", config, "-o", path, *SWEEP)
    timing = json.loads(path.with_name(path.name + ".timing.json").read_text())
    cores, points = timing["seconds"] * WORKERS, timing["points"]
    own = cores - timing["kernel_seconds"]
    return {
        "points": points,
        "command_seconds": took["seconds"],
        "points_per_second": timing["points_per_second"],
        "kernel_us_per_point": 1e6 * timing["kernel_seconds"] / points,
        "overhead_us_per_point": 1e6 * own / points,
        "overhead_part": own / cores,
        "peak_mib": took["peak_mib"],
        "file_mib": path.stat().st_size / MIB,
    }


def huge(quick: bool) -> dict[str, Any]:
    """Measure a grid that is planned, run in part, resumed and exported."""
    shape = (10, 10, 10, 3) if quick else (100, 100, 100, 10)
    result: dict[str, Any] = {"points": math.prod(shape)}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "huge.nc"
        config = write_config(path.with_suffix(".yaml"), grid_config(LIQUID, shape, [0], *RTOL))
        part = ("sweep", config, "-o", path, "--max-runtime", "1s" if quick else "20s")
        steps = {
            "plan": ("plan", config, "-o", path),
            "part": part,
            "resumed": part,
            "export": ("sweep", config, "-o", path, "--partial"),
        }
        for step, words in steps.items():
            took = run_command(*words, stopped=True)
            result[step] = {name: took[name] for name in ("seconds", "peak_mib")}
    return result


if __name__ == "__main__":
    measure("engine", __doc__, {"grids": grids, "huge": huge})
