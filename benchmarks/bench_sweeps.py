"""Sweeps through the whole package: figures, scaling, a large cube, overhead, memory, start-up.

`--full` also runs the cube of a million points, once, through the command line; its numbers go to
`results/cube.json`. Everything else runs in a few minutes on two idle cores.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from bench_figures import FIGURES
from command import MIB, median_of_commands, run_command
from common import (
    amplitude_errors,
    arguments,
    column,
    finish,
    good,
    median_seconds,
    medians_in_turn,
    quantile,
    timed,
)
from parts.startup import start_up

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.status import Status
from sweeps import run
from sweeps.config.paper import shipped_config
from sweeps.config.schema import Execution
from sweeps.engine.executors.worker import Block
from sweeps.engine.in_memory import compute, read_config
from sweeps.engine.options import options_of
from sweeps.figures import draw, save
from sweeps.files.attributes import result_dataset
from sweeps.grid import Grid

WORKERS, RUNS = 2, 5

FLUIDS = ["-2/3", 0, "2/3"]

# Of the large sweeps: a point settles within some ten to a hundred periods or not at all, and the
# few that never do (gamma = -2/3 at small k) would take most of the time of the others together.
MOST_PERIODS = 500
CUBE_SEED, CUBE_SAMPLE, CUBE_ERROR = 17, 300, 1e-4
CUBE_LADDER = (1e-3, 1e-4, 1e-5)
CUBE_REFERENCE = Options(rtol=1e-9, stationary_rtol=1e-9, max_periods=MOST_PERIODS)
MEMORY_SIZES = {"1e3": (10, 10, 10), "1e5": (50, 50, 40)}
MEMORY_FLUID = 0  # the cheapest: it is not the time that counts


def main() -> None:
    options = arguments(__doc__, full="the cube of a million points")
    quick = options.quick
    results: dict[str, Any] = {"workers": WORKERS, "cores": os.cpu_count()}
    with tempfile.TemporaryDirectory() as folder:
        where = Path(folder)
        results["figures"] = _figures(where, runs=1 if quick else RUNS)
        results["scaling"] = _scaling((4, 2, 2, 2) if quick else (16, 8, 8, 8), quick=quick)
        results["overhead"] = _overhead((6, 4, 2, 2) if quick else (12, 8, 6, 4), quick=quick)
        results["cube_sample"] = _cube_sample(20 if quick else CUBE_SAMPLE)
        sizes = {"1e1": (3, 2, 2)} if quick else MEMORY_SIZES
        results["memory"] = {name: _memory(where, shape) for name, shape in sizes.items()}
        results["start"] = start_up(where, runs=1 if quick else RUNS, cold=not quick)
        finish("sweeps", results, quick=quick)
        if options.full:
            cube = _cube(where, results["cube_sample"]["chosen"])
            finish("cube", cube, quick=quick)


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


def _sweep(shape: tuple[int, ...], fluids: list[Any], **others: Any) -> dict[str, Any]:
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


def _scaling(shape: tuple[int, ...], *, quick: bool) -> dict[str, Any]:
    """The same large sweep on one worker and on two."""
    config = read_config(_sweep(shape, FLUIDS))
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
    config = read_config(_sweep(shape, FLUIDS))
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
        handing = statistics.median(_handing_out(grid, options, workers) for _ in range(runs))
        rows[f"handing_out_us_per_point_{workers}_workers"] = 1e6 * handing / grid.size
    results = compute(grid, options, execution=Execution(workers=WORKERS))
    labelling = median_seconds(lambda: result_dataset(config, grid, results), runs)
    rows["dataset_us_per_point"] = 1e6 * labelling / grid.size
    print("overhead:", rows)
    return rows


def _handing_out(grid: Grid, options: Options, workers: int) -> float:
    """Seconds of all cores together that went not into blocks."""
    blocks: list[Block] = []
    execution = Execution(workers=workers)
    _, seconds = timed(lambda: compute(grid, options, execution=execution, on_block=blocks.append))
    return seconds * workers - sum(block.seconds for block in blocks)


# --- c: the cube ----------------------------------------------------------------------------------


def _cube_config(**others: Any) -> dict[str, Any]:
    return _sweep((24, 24, 24, 24), FLUIDS, **others)


def _cube_sample(count: int) -> dict[str, Any]:
    """The cheapest tolerance that is accurate enough on random points of the cube."""
    grid = Grid.from_config(read_config(_cube_config()))
    chosen = np.random.default_rng(CUBE_SEED).choice(grid.size, size=count, replace=False)
    points = np.concatenate([grid.points(i, i + 1) for i in np.sort(chosen)])
    exact = compute_orbits(points, CUBE_REFERENCE)[0]
    rows = []
    for rtol in CUBE_LADDER:
        options = Options(rtol=rtol, max_periods=MOST_PERIODS)
        results, seconds = timed(lambda chosen=options: compute_orbits(points, chosen)[0])
        both = good(results) & good(exact)
        errors = amplitude_errors(points, results, exact)[both].max(axis=1)
        row = {
            "rtol": rtol,
            "error_median": quantile(errors, 50),
            "error_95": quantile(errors, 95),
            "error_max": float(errors.max()),
            "statuses": _statuses(column(results, "status")),
            "seconds": seconds,
            "cube_on_one_core_seconds": seconds / count * grid.size,
        }
        rows.append(row)
        print("cube sample:", row)
    enough = [row["rtol"] for row in rows if row["error_95"] <= CUBE_ERROR]
    failing = {row["rtol"]: count - row["statuses"].get("ok", 0) for row in rows}
    least = min(failing.values())
    flawless = [row for row in rows if row["rtol"] in enough and failing[row["rtol"]] == least]
    cheapest = min(flawless or rows[-1:], key=lambda row: row["seconds"])
    return {
        "points": count,
        "seed": CUBE_SEED,
        "rows": rows,
        "accurate_enough": enough,
        "chosen": cheapest["rtol"],
    }


def _statuses(values: np.ndarray) -> dict[str, int]:
    """How many points have each status, by its name."""
    counted = Counter(np.asarray(values).ravel().astype(int).tolist())
    return {Status(value).name.lower(): count for value, count in sorted(counted.items())}


def _cube(where: Path, rtol: float) -> dict[str, Any]:
    """A million points, once, as a user would compute them."""
    import xarray as xr

    path = where / "cube.nc"
    config = _written(where / "cube.yaml", _cube_config(integrator={"rtol": rtol}))
    took = run_command("sweep", config, "-o", path, "--workers", str(WORKERS), "--no-progress")
    with xr.open_dataset(path) as ds:
        points, statuses = int(ds.status.size), _statuses(ds.status.values)
        stated, status = ds.amplitude_error.values, ds.status.values
    ok, aperiodic = stated[status == Status.OK], stated[status == Status.APERIODIC]
    return {
        "rtol": rtol,
        "max_periods": MOST_PERIODS,
        "workers": WORKERS,
        "points": points,
        "seconds": took["seconds"],
        "cpu_seconds": took["cpu"],
        "points_per_second": points / took["seconds"],
        "peak_mib": took["peak_mib"],
        "file_mib": path.stat().st_size / MIB,
        "statuses": statuses,
        "stated_error_median": quantile(ok, 50),
        "stated_error_95": quantile(ok, 95),
        "stated_error_max": float(ok.max()),
        "stated_error_max_aperiodic": float(aperiodic.max(initial=0.0)),
    }


def _written(path: Path, config: dict[str, Any]) -> Path:
    path.write_text(json.dumps(config))  # JSON is YAML
    return path


# --- d: memory ------------------------------------------------------------------------------------


def _memory(where: Path, shape: tuple[int, ...]) -> dict[str, Any]:
    """Peak memory of a sweep through the command line."""
    config = _written(where / "memory.yaml", _sweep(shape, [MEMORY_FLUID]))
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
