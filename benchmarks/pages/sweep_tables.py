"""Sweeps: typical jobs, their errors, the engine, attacks on them."""

from __future__ import annotations

from pages.numbers import WHAT, Lines, Results, count_by_name, powers


def jobs(
    start: Results, figures: Results, regimes: Results, cube: Results, scaling: Results
) -> Lines:
    """Yield what a user waits for."""
    rows = figures["figures"].values()
    points, alone = (sum(row[name] for row in rows) for name in ("points", "seconds"))
    yield "job on two cores | time"
    yield f"`import stickslip` | {start['import stickslip']:.3g} s"
    yield f"`stickslip --help` | {start['stickslip --help']:.3g} s"
    first = f"{start['warm first result']:.3g} s"
    yield f"`configs/quickstart.yaml`, two curves of 18 points | {first}"
    if "cold first result" in start:
        elsewhere = start["first result of another installation"]
        yield f"... the first time, with compilation | {start['cold first result']:.3g} s"
        yield f"... in another installation of the same sources | {elsewhere:.3g} s"
    pictures = f"{figures['command_seconds']:.3g} s"
    yield f"Figs. 7, 8 and 9: {points} points, files and pictures | {pictures}"
    yield f"... the points alone | {alone:.3g} s"
    computed = f"{regimes['computed'] / regimes['points']:.1%} computed"
    refined = f"{regimes['refined_seconds']:.3g} s"
    yield f"`configs/regimes.yaml`: map of {regimes['points']} points, {computed} | {refined}"
    yield f"... the same map in full | {regimes['full_seconds']:.3g} s"
    what = f"a cube of {cube['points']} points, rtol {cube['rtol']:.0e}, three fluids"
    yield f"{what} | {cube['seconds']:.0f} s"
    both = f"{scaling['one_worker_seconds']:.3g} and {scaling['two_workers_seconds']:.3g} s"
    yield f"{scaling['points']} points of this kind at rtol 1e-06, one worker and two | {both}"


def errors_of_sweeps(figures: Results, regimes: Results, cube: Results) -> Lines:
    """Yield errors of the figures and of a cube; pixels of a refined map."""
    yield WHAT
    for name, row in figures["figures"].items():
        errors = powers((row["error_median"], row["error_max"]))
        yield f"{name}: error, median and largest; points that failed | {errors}; {row['failed']}"
    wrong = regimes["wrong_kind"] + regimes["missed"]
    yield f"refined map: wrong pixels | {wrong} of {regimes['points']}"
    sample = cube["sample"]
    errors = powers(sample[name] for name in ("error_median", "error_95", "error_max"))
    yield f"cube: error, median, 95 % and largest of {sample['points']} | {errors}"
    yield f"cube: statuses | {count_by_name(cube['statuses'])}"
    stated = powers((cube["stated_error_max"], cube["stated_error_max_aperiodic"]))
    yield f"cube: largest stated error, ok and aperiodic | {stated}"


def engine(grids: Results, huge: Results) -> Lines:
    """Yield time, memory and bytes of large grids, and the share of the engine."""
    head = "points | film | points/s | kernel [µs a point] | engine [µs a point]"
    yield f"{head} | share of the cores | peak, at most | file"
    for row in grids["sweeps"]:
        yield (
            f"{row['points']:.0f} | {row['scene']} | {row['points_per_second']:.0f} | "
            f"{row['kernel_us_per_point']:.3g} | {row['overhead_us_per_point']:.2g} | "
            f"{row['overhead_part']:.2g} | {row['peak_mib']:.0f} MiB | {row['file_mib']:.3g} MiB"
        )
    peak = max(step["peak_mib"] for step in huge.values() if isinstance(step, dict))
    what = "liquid; planned, run in part, resumed, exported"
    yield f"{huge['points']} | {what} |  |  |  |  | {peak:.0f} MiB | "


def attacks(*kinds: Results) -> Lines:
    """Yield what became of each kind of attack on sweeps."""
    columns = ("tried", "survived", "lost", "wrong", "hung")
    tallies = {what: row for kind in kinds for what, row in kind.items()}
    tallies["all"] = {name: sum(row[name] for row in tallies.values()) for name in columns}
    yield " | ".join(("attack", *columns))
    for what, row in tallies.items():
        yield " | ".join((what, *(str(row[name]) for name in columns)))
