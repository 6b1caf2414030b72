"""A cube of a million points over T, k, K, omega and three fluids, through the command line.

Part a: the loosest tolerance that is accurate enough, on a sample. Part b: the cube: seconds,
statuses, stated errors. Part c: the microseconds of a point on one core, by fluid and stage; the
seconds of ordinary, late and watched points, and how full their lanes are.
Part d: how many late points should be computed together. With `--full` part e: after how many
drive periods a point is left for later, over a part of the cube.
"""

from __future__ import annotations

import math
import os
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from command import MIB, run_command
from common import (
    amplitude_errors,
    arguments,
    column,
    finish,
    good,
    parameter,
    quantile,
    timed,
)
from inside import lanes_used, timed_stages
from parts.grids import FLUIDS, MOST_PERIODS, grid_config, written

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.status import Status
from sweeps.engine.executors.worker import Block
from sweeps.engine.in_memory import compute
from sweeps.engine.order import stragglers
from sweeps.engine.settings import read_config
from sweeps.grid import Grid

WORKERS = 2
SHAPE, QUICK_SHAPE = (24, 24, 24, 24), (3, 3, 2, 2)
SEED, SAMPLE, ERROR = 17, 300, 1e-4
LADDER = (1e-3, 1e-4, 1e-5)
REFERENCE = Options(rtol=1e-9, stationary_rtol=1e-9, max_periods=MOST_PERIODS)
STAGE_POINTS = 4096  # of each fluid
KIND_POINTS = 60_000
PATIENCE = 64  # drive periods after which a sweep leaves a point for later
PART_SHAPE, PATIENCES = (4, 24, 24, 24), (16, 32, 64, 128)
LATE, TOGETHER = 1024, (64, 256, 1024)


def main() -> None:
    options = arguments(__doc__, full="when points are left for later")
    quick = options.quick
    shape = QUICK_SHAPE if quick else SHAPE
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cube.nc"
        sample = _sample(shape, 20 if quick else SAMPLE)
        results = {"sample": sample, "cores": os.cpu_count()}
        results |= _whole(path, shape, sample["chosen"])
        results["stages"] = _stages(shape, 64 if quick else STAGE_POINTS, sample["chosen"])
        results["kinds"] = _kinds(shape, 64 if quick else KIND_POINTS, sample["chosen"])
        results["late"] = _late(path, shape, sample["chosen"])
    if options.full:
        results["patience"] = _patience(sample["chosen"])
    finish("cube", results, quick=quick)


def _config(shape: tuple[int, ...], rtol: float) -> dict[str, Any]:
    return grid_config(shape, FLUIDS, integrator={"rtol": rtol})


def _grid(shape: tuple[int, ...]) -> Grid:
    return Grid.from_config(read_config(_config(shape, LADDER[0])))


def _drawn(shape: tuple[int, ...], count: int) -> np.ndarray:
    """Random points of the cube, in the order of the grid."""
    grid = _grid(shape)
    chosen = np.random.default_rng(SEED).choice(
        grid.size, size=min(count, grid.size), replace=False
    )
    return grid.rows(np.sort(chosen))


# --- a: the tolerance -----------------------------------------------------------------------------


def _sample(shape: tuple[int, ...], count: int) -> dict[str, Any]:
    """The cheapest tolerance that is accurate enough on random points of the cube."""
    points = _drawn(shape, count)
    exact = compute_orbits(points, REFERENCE)[0]
    rows = []
    for rtol in LADDER:
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
            "cube_on_one_core_seconds": seconds / count * math.prod((*shape, len(FLUIDS))),
        }
        rows.append(row)
        print("cube sample:", row)
    enough = [row["rtol"] for row in rows if row["error_95"] <= ERROR]
    failing = {row["rtol"]: count - row["statuses"].get("ok", 0) for row in rows}
    least = min(failing.values())
    flawless = [row for row in rows if row["rtol"] in enough and failing[row["rtol"]] == least]
    cheapest = min(flawless or rows[-1:], key=lambda row: row["seconds"])
    return {
        "points": count,
        "seed": SEED,
        "rows": rows,
        "accurate_enough": enough,
        "chosen": cheapest["rtol"],
    }


def _statuses(values: np.ndarray) -> dict[str, int]:
    """How many points have each status, by its name."""
    counted = Counter(np.asarray(values).ravel().astype(int).tolist())
    return {Status(value).name.lower(): count for value, count in sorted(counted.items())}


# --- b: the cube ----------------------------------------------------------------------------------


def _whole(path: Path, shape: tuple[int, ...], rtol: float) -> dict[str, Any]:
    """All of it, once, as a user would compute it."""
    import xarray as xr

    config = written(path.with_suffix(".yaml"), _config(shape, rtol))
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


# --- c: stages ------------------------------------------------------------------------------------


def _stages(shape: tuple[int, ...], count: int, rtol: float) -> dict[str, dict[str, float]]:
    """Microseconds of a point on one core by stage, for each fluid; points that are late left out.

    What is not of a stage is `other`; what late points took before they were left is in `search`.
    """
    points = _drawn(shape, 4 * len(FLUIDS) * count)
    options, rows = Options(rtol=rtol, max_periods=MOST_PERIODS), {}
    gammas = parameter(points, "rheological_index")
    for gamma in np.unique(gammas):
        own = points[gammas == gamma][:count]
        compute_orbits(own[:16], options, patience=PATIENCE)
        with timed_stages() as stages:
            _, whole = timed(lambda chosen=own: compute_orbits(chosen, options, patience=PATIENCE))
        row = {"points": len(own), "all": whole} | stages
        row["other"] = whole - math.fsum(stages.values())
        rows[f"{gamma:.2f}"] = {
            stage: value if stage == "points" else 1e6 * value / len(own)
            for stage, value in row.items()
        }
        print("stages:", f"{gamma:.2f}", {k: f"{v:.3g}" for k, v in rows[f"{gamma:.2f}"].items()})
    return rows


def _kinds(shape: tuple[int, ...], count: int, rtol: float) -> dict[str, Any]:
    """Seconds of one core for points that are ordinary, late or watched, and how full lanes are."""
    points = _drawn(shape, count)
    options = Options(rtol=rtol, max_periods=MOST_PERIODS)
    compute_orbits(points[:16], options)
    with lanes_used() as ordinary_lanes:
        results, ordinary = timed(lambda: compute_orbits(points, options, patience=PATIENCE)[0])
    late = points[column(results, "status") == Status.PENDING]
    never = compute_orbits(late, options)[0]
    watched = column(never, "status") == Status.APERIODIC
    rows: dict[str, Any] = {
        "ordinary": {
            "points": len(points) - len(late),
            "seconds": ordinary,
            "lanes_full": ordinary_lanes.fullness,
        }
    }
    for kind, of in (("late", ~watched), ("watched", watched)):
        with lanes_used() as lanes:
            _, seconds = timed(lambda some=late[of]: compute_orbits(some, options))
        rows[kind] = {
            "points": int(of.sum()),
            "seconds": seconds,
            "lanes_full": lanes.fullness,
        }
    print("kinds:", rows)
    return rows


# --- d: late points -------------------------------------------------------------------------------


def _late(path: Path, shape: tuple[int, ...], rtol: float) -> dict[str, Any]:
    """Seconds for late points of the cube on one core, in groups of so many."""
    import xarray as xr

    with xr.open_dataset(path) as ds:
        periods = ds.periods_integrated.transpose(*ds.status.dims).values.ravel()
    late = np.flatnonzero(periods > PATIENCE)
    chosen = np.random.default_rng(SEED).permutation(late)[:LATE]
    points = _grid(shape).rows(np.sort(chosen))
    options = Options(rtol=rtol, max_periods=MOST_PERIODS)
    seconds = {
        str(size): timed(
            lambda step=size: [
                compute_orbits(points[first : first + step], options)
                for first in range(0, len(points), step)
            ]
        )[1]
        for size in TOGETHER
    }
    rows = {"of_all": len(late), "points": len(points), "seconds": seconds}
    print("late:", rows)
    return rows


# --- e: patience ----------------------------------------------------------------------------------


def _patience(rtol: float) -> dict[str, dict[str, float]]:
    """Seconds of one core for a part of the cube, where points are left so early."""
    config, rows = read_config(_config(PART_SHAPE, rtol)), {}
    for patience in PATIENCES:
        blocks: list[Block] = []
        with patch.object(stragglers, "_PATIENCE", patience):
            compute(config, workers=1, on_block=blocks.append)
        rows[str(patience)] = {"seconds": math.fsum(block.seconds for block in blocks)}
    print("patience:", rows)
    return rows


if __name__ == "__main__":
    main()
