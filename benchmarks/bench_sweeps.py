"""What typical jobs take: a first result, the figures, a map, a cube of a million points.

Jobs go through the command line, as a user runs them; maps and bare points are computed in memory.
"""

from __future__ import annotations

import os
import shutil
import statistics
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from shared.commands import MIB, median_of_commands, run_command, run_process
from shared.grids import CUBE, FLUIDS, MOST_PERIODS, SWEEP, WORKERS, grid_config, write_config
from shared.measuring import measure
from shared.points import Orbits, at, count_by_name, orbits, quantile
from shared.timing import median_seconds, medians_in_turn, timed

import stickslip
import sweeps
from stickslip.status import Status
from sweeps import run
from sweeps.config.load import Config
from sweeps.config.paper import shipped_config
from sweeps.engine.computing import compile_kernels
from sweeps.engine.run import compute
from sweeps.engine.settings import options_of, read_config
from sweeps.grid import Grid

RUNS = 5

FIGURES = ("fig7", "fig8", "fig9")
COARSE = {
    "fig7": "temperature={linspace: [150, 320], num: 8}",
    "fig8": "viscosity_coefficient={linspace: [1e4, 2e5], num: 8}",
    "fig9": "spring_stiffness={linspace: [100, 1e4], num: 8}",
}
COARSE_MAP = ("T={linspace: [150, 300], num: 33}", "omega={linspace: [5, 60], num: 33}")
REFERENCE = ("integrator.rtol=1e-9", "stationary.rtol=1e-9")

CUBE_SHAPE, QUICK_SHAPE = (24, 24, 24, 24), (3, 3, 2, 2)
CUBE_RTOL = 1e-4  # the loosest that is accurate to 1e-4 on a sample
SEED, SAMPLE = 17, 300


# --- a first result -------------------------------------------------------------------------------


def start(quick: bool) -> dict[str, Any]:
    """Time the first words and the first results."""
    runs = 1 if quick else RUNS
    with tempfile.TemporaryDirectory() as where, tempfile.TemporaryDirectory() as empty:
        config, output = shipped_config("quickstart"), Path(where) / "first.nc"
        sweep = ("sweep", config, "-o", output, *SWEEP)
        run_command(*sweep)
        imports = [run_process([sys.executable, "-c", "import stickslip"]) for _ in range(runs)]
        result = {
            "import stickslip": statistics.median(took["seconds"] for took in imports),
            "stickslip --help": median_of_commands(runs, "--help"),
            "warm first result": median_of_commands(runs, *sweep),
        }
        if not quick:
            result["cold first result"] = run_command(*sweep, NUMBA_CACHE_DIR=empty)["seconds"]
            result["first result of another installation"] = _elsewhere(sweep, empty)
    return result


def _elsewhere(words: tuple[str | Path, ...], compiled: str) -> float:
    """Return the seconds of a command of the same sources in another place, with compiled code."""
    with tempfile.TemporaryDirectory() as place:
        for package in (stickslip, sweeps):
            sources = Path(package.__file__).parent
            leave_out = shutil.ignore_patterns("__pycache__")
            shutil.copytree(sources, Path(place) / sources.name, ignore=leave_out)
        command = [sys.executable, "-P", "-c", "from sweeps.cli import main; main()", *words]
        return run_process(command, NUMBA_CACHE_DIR=compiled, PYTHONPATH=place)["seconds"]


# --- the figures of the paper ---------------------------------------------------------------------


def figures(quick: bool) -> dict[str, Any]:
    """Time Figs. 7, 8 and 9 by one command; measure their computations and errors one by one."""
    runs = 1 if quick else RUNS
    with tempfile.TemporaryDirectory() as folder:
        words = ("figure", "7", "8", "9", "-o", folder, "--overwrite", "--workers", str(WORKERS))
        run_command(*words)
        command = median_of_commands(runs, *words)
    rows = {name: _figure(name, runs, (COARSE[name],) if quick else ()) for name in FIGURES}
    return {"command_seconds": command, "figures": rows}


def _figure(name: str, runs: int, changes: tuple[str, ...]) -> dict[str, Any]:
    """Time a figure's sweep, and compare it with the same sweep at rtol 1e-9."""
    config = read_config(shipped_config(name), changes)
    found = _swept(config)
    errors = found.errors(_swept(read_config(shipped_config(name), (*changes, *REFERENCE))))
    known = errors[np.isfinite(errors)]
    return {
        "points": len(found),
        "failed": int((~found.ok).sum()),
        "seconds": median_seconds(lambda: run(config, workers=WORKERS), runs),
        "error_median": float(np.median(known)),
        "error_max": float(known.max()),
    }


def _swept(config: Config) -> Orbits:
    """Return the orbits of a sweep in memory, without their states."""
    grid = Grid.from_config(config)
    points = grid.points(0, grid.size)
    return Orbits(points, compute(config, workers=WORKERS), points[:, :0])


# --- a refined map --------------------------------------------------------------------------------


def regimes(quick: bool) -> dict[str, Any]:
    """Time the map of `configs/regimes.yaml` in full and refined, and count wrong pixels.

    A pixel is wrong where its regime or status is another one, or where an amplitude misses by
    more than its stated error.
    """
    config = read_config(shipped_config("regimes"), COARSE_MAP if quick else ())
    grid, options = Grid.from_config(config), options_of(config)
    compile_kernels(options, grid)
    unrefined = config.model_copy(update={"refine": None})
    full, full_seconds = timed(lambda: _swept(unrefined))
    refined, seconds = timed(lambda: _swept(config))
    times = {"full_seconds": full_seconds, "refined_seconds": seconds}
    return {"points": grid.size} | times | _compared(full, refined)


def _compared(full: Orbits, found: Orbits) -> dict[str, Any]:
    """Count the points that were computed, and those of the others that are wrong."""
    filled = found.status == Status.INTERPOLATED
    ended = np.where(filled, float(Status.OK), found.status)
    kind = (found.regime != full.regime) | (ended != full.status)
    scale = np.maximum(full.amplitudes, 0.01 * np.nanmax(full.amplitudes, axis=0))
    off = np.abs(found.amplitudes - full.amplitudes) / scale
    stated = (found.amplitude_error + full.amplitude_error)[:, None]
    return {
        "computed": int((~filled).sum()),
        "wrong_kind": int(kind.sum()),
        "missed": int((filled & ~kind & (off > stated).any(axis=1)).sum()),
        "stated_error_max": float(found.amplitude_error[filled].max(initial=0.0)),
    }


# --- a cube of a million points -------------------------------------------------------------------


def cube(quick: bool) -> dict[str, Any]:
    """Time a cube over T, k, K, omega and three fluids; count statuses, measure some errors."""
    config = grid_config(CUBE, QUICK_SHAPE if quick else CUBE_SHAPE, FLUIDS, CUBE_RTOL)
    sample = _sample(config, 20 if quick else SAMPLE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cube.nc"
        file = write_config(path.with_suffix(".yaml"), config)
        took = run_command("sweep", file, "-o", path, *SWEEP)
        with xr.open_dataset(path) as ds:
            stated, status = ds.amplitude_error.values, ds.status.values
        size = path.stat().st_size / MIB
    ok, aperiodic = stated[status == Status.OK], stated[status == Status.APERIODIC]
    return {
        "rtol": CUBE_RTOL,
        "sample": sample,
        "file_mib": size,
        "points": int(status.size),
        "seconds": took["seconds"],
        "points_per_second": status.size / took["seconds"],
        "peak_mib": took["peak_mib"],
        "statuses": count_by_name(status),
        "stated_error_median": quantile(ok, 50),
        "stated_error_max": float(ok.max()),
        "stated_error_max_aperiodic": float(aperiodic.max(initial=0.0)),
    }


def _sample(config: dict[str, Any], count: int) -> dict[str, Any]:
    """Return errors of random points of the cube."""
    grid = Grid.from_config(read_config(config))
    chosen = np.random.default_rng(SEED).choice(grid.size, min(count, grid.size), replace=False)
    points = grid.rows(np.sort(chosen))
    found = orbits(points, rtol=CUBE_RTOL, max_periods=MOST_PERIODS)
    exact = orbits(points, max_periods=MOST_PERIODS, **at(1e-9))
    errors = found.errors(exact)[found.ok & exact.ok]
    return {
        "points": len(points),
        "error_median": quantile(errors, 50),
        "error_95": quantile(errors, 95),
        "error_max": float(errors.max()),
    }


# --- two workers ---------------------------------------------------------------------------------


def scaling(quick: bool) -> dict[str, Any]:
    """Time the same large sweep on one worker and on two."""
    config = read_config(grid_config(CUBE, (4, 2, 2, 2) if quick else (16, 8, 8, 8), FLUIDS))
    calls = [lambda n=workers: run(config, workers=n) for workers in (1, WORKERS)]
    one, two = medians_in_turn(calls, 1 if quick else 3)
    times = {"one_worker_seconds": one, "two_workers_seconds": two}
    return {"points": Grid.from_config(config).size} | times | {"cores": os.cpu_count()}


if __name__ == "__main__":
    parts = (start, figures, regimes, cube, scaling)
    measure("sweeps", __doc__, {part.__name__: part for part in parts})
