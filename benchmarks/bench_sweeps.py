"""Sweeps through the whole package: figures, scaling, overhead, memory, start-up.

A few minutes on two idle cores.
"""

from __future__ import annotations

import math
import os
import statistics
import tempfile
from pathlib import Path
from typing import Any

from bench_figures import FIGURES
from command import median_of_commands, run_command
from common import (
    arguments,
    finish,
    median_seconds,
    medians_in_turn,
    timed,
)
from parts.grids import FLUIDS, grid_config, written
from parts.startup import start_up

from stickslip.orbit import compute_orbits
from sweeps import run
from sweeps.config.load import Config
from sweeps.config.paper import shipped_config
from sweeps.engine.executors.worker import Block
from sweeps.engine.in_memory import compute
from sweeps.engine.settings import options_of, read_config
from sweeps.figures import draw, save
from sweeps.files.attributes import result_dataset
from sweeps.grid import Grid

WORKERS, RUNS = 2, 5

MEMORY_SIZES = {"1e3": (10, 10, 10), "1e5": (50, 50, 40)}
MEMORY_FLUID = 0  # the cheapest: it is not the time that counts


def main() -> None:
    quick = arguments(__doc__).quick
    results: dict[str, Any] = {"workers": WORKERS, "cores": os.cpu_count()}
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        results["figures"] = _figures(where, runs=1 if quick else RUNS)
        results["scaling"] = _scaling((4, 2, 2, 2) if quick else (16, 8, 8, 8), quick=quick)
        results["overhead"] = _overhead((6, 4, 2, 2) if quick else (12, 8, 6, 4), quick=quick)
        sizes = {"1e1": (3, 2, 2)} if quick else MEMORY_SIZES
        results["memory"] = {name: _memory(where, shape) for name, shape in sizes.items()}
        results["start"] = start_up(where, runs=1 if quick else RUNS, cold=not quick)
        finish("sweeps", results, quick=quick)


# --- a: figures -----------------------------------------------------------------------------------


def _figures(where: Path, runs: int) -> dict[str, Any]:
    """Figs. 7, 8 and 9 from scratch by one command; their computations and pictures alone."""
    words = ("figure", "7", "8", "9", "-o", where / "figures", "--workers", str(WORKERS))
    run_command(*words)
    configs = [read_config(shipped_config(name)) for name in FIGURES]

    def computations() -> None:
        for config in configs:
            run(config, workers=WORKERS)

    computations()
    datasets = [run(config, workers=WORKERS) for config in configs]

    def pictures() -> None:
        for ds in datasets:
            save(draw(ds), where / "picture")

    result = {
        "command_seconds": median_of_commands(runs, *words),
        "computations_seconds": median_seconds(computations, runs),
        "pictures_seconds": median_seconds(pictures, runs),
        "points": sum(Grid.from_config(config).size for config in configs),
        "runs": runs,
    }
    print("figures:", result)
    return result


# --- b, d: scaling and overhead -------------------------------------------------------------------


def _scaling(shape: tuple[int, ...], *, quick: bool) -> dict[str, Any]:
    """The same large sweep on one worker and on two."""
    config = read_config(grid_config(shape, FLUIDS))
    runs = 1 if quick else 3
    one, two = medians_in_turn(
        [lambda: run(config, workers=1), lambda: run(config, workers=2)], runs
    )
    points = Grid.from_config(config).size
    result = {
        "points": points,
        "one_worker_seconds": one,
        "two_workers_seconds": two,
        "times_faster": one / two,
        "points_per_second": {"1": points / one, "2": points / two},
        "runs": runs,
    }
    print("scaling:", result)
    return result


def _overhead(shape: tuple[int, ...], *, quick: bool) -> dict[str, Any]:
    """What the engine adds to a point: against the kernels in its blocks, and in a single call."""
    config = read_config(grid_config(shape, FLUIDS))
    grid, options = Grid.from_config(config), options_of(config)
    points = grid.points(0, grid.size)
    runs = 1 if quick else RUNS
    rows: dict[str, Any] = {"points": grid.size}
    direct, one = medians_in_turn(
        [lambda: compute_orbits(points, options), lambda: run(config, workers=1)], runs
    )
    rows["one_call_us_per_point"] = 1e6 * direct / grid.size
    rows["with_cutting_us_per_point"] = 1e6 * (one - direct) / grid.size
    for workers in (1, WORKERS):
        handing = statistics.median(_handing_out(config, workers) for _ in range(runs))
        rows[f"handing_out_us_per_point_{workers}_workers"] = 1e6 * handing / grid.size
    results = compute(config, workers=WORKERS)
    labelling = median_seconds(lambda: result_dataset(config, grid, results), runs)
    rows["dataset_us_per_point"] = 1e6 * labelling / grid.size
    print("overhead:", rows)
    return rows


def _handing_out(config: Config, workers: int) -> float:
    """Seconds of all cores together that went not into blocks."""
    blocks: list[Block] = []
    _, seconds = timed(lambda: compute(config, workers=workers, on_block=blocks.append))
    return seconds * workers - sum(block.seconds for block in blocks)


# --- c: memory ------------------------------------------------------------------------------------


def _memory(where: Path, shape: tuple[int, ...]) -> dict[str, Any]:
    """Peak memory of a sweep through the command line."""
    config = written(where / "memory.yaml", grid_config(shape, [MEMORY_FLUID]))
    path = where / "memory.nc"
    words = ("sweep", config, "-o", path, "--workers", str(WORKERS), "--no-progress")
    took = run_command(*words, "--overwrite")
    result = {
        "points": math.prod(shape),
        "peak_mib": took["peak_mib"],
        "seconds": took["seconds"],
        "file_bytes_per_point": path.stat().st_size / math.prod(shape),
    }
    print("memory:", result)
    return result


if __name__ == "__main__":
    main()
