"""Sweeps: typical jobs, their errors, the engine, attacks on them."""

from __future__ import annotations

from pages.numbers import Results, Rows, count_by_name, digits, seconds


def jobs(
    start: Results, figures: Results, regimes: Results, cube: Results, scaling: Results
) -> Rows:
    """Return what a user waits for."""
    points = sum(row["points"] for row in figures["figures"].values())
    rows = {
        "`import stickslip`": seconds(start["import stickslip"]),
        "`stickslip --help`": seconds(start["stickslip --help"]),
        "`configs/quickstart.yaml`, two curves of 18 points": seconds(start["warm first result"]),
    }
    if "cold first result" in start:
        cold, elsewhere = start["cold first result"], start["first result of another installation"]
        rows["... the first time, with compilation"] = seconds(cold)
        rows["... in another installation of the same sources"] = seconds(elsewhere)
    rows[f"Figs. 7, 8 and 9: {points} points, files and pictures"] = seconds(
        figures["command_seconds"]
    )
    computed = sum(row["seconds"] for row in figures["figures"].values())
    rows["... the points alone"] = seconds(computed)
    share = regimes["computed"] / regimes["points"]
    what = f"`configs/regimes.yaml`: map of {regimes['points']} points, {share:.1%} computed"
    rows[what] = seconds(regimes["refined_seconds"])
    rows["... the same map in full"] = seconds(regimes["full_seconds"])
    what = f"a cube of {cube['points']} points, rtol {cube['rtol']:.0e}, three fluids"
    rows[what] = f"{cube['seconds']:.0f} s"
    both = f"{scaling['one_worker_seconds']:.3g} and {scaling['two_workers_seconds']:.3g} s"
    rows[f"{scaling['points']} points of this kind at rtol 1e-06, one worker and two"] = both
    return [("job on two cores", "time"), *rows.items()]


def errors_of_sweeps(figures: Results, regimes: Results, cube: Results) -> Rows:
    """Return errors of the figures and of a cube; pixels of a refined map."""
    sample, wrong = cube["sample"], regimes["wrong_kind"] + regimes["missed"]
    stated = f"{cube['stated_error_max']:.1e}, {cube['stated_error_max_aperiodic']:.1e}"
    errors = f"{sample['error_median']:.1e}, {sample['error_95']:.1e}, {sample['error_max']:.1e}"
    return [
        ("what", "value"),
        *(
            (f"{name}: error, median and largest; points that failed", _error_of_figure(row))
            for name, row in figures["figures"].items()
        ),
        ("refined map: wrong pixels", f"{wrong} of {regimes['points']}"),
        (f"cube: error, median, 95 % and largest of {sample['points']}", errors),
        ("cube: statuses", count_by_name(cube["statuses"])),
        ("cube: largest stated error, ok and aperiodic", stated),
    ]


def _error_of_figure(row: Results) -> str:
    return f"{row['error_median']:.1e}, {row['error_max']:.1e}; {row['failed']}"


def engine(grids: Results, huge: Results) -> Rows:
    """Return time, memory and bytes of large grids, and the share of the engine."""
    head = ("points", "film", "points/s", "kernel [µs a point]", "engine [µs a point]")
    rows: Rows = [(*head, "share of the cores", "peak, at most", "file")]
    rows += [
        (
            f"{row['points']:.0f}",
            row["scene"],
            f"{row['points_per_second']:.0f}",
            digits(row["kernel_us_per_point"]),
            f"{row['overhead_us_per_point']:.2g}",
            f"{row['overhead_part']:.2g}",
            f"{row['peak_mib']:.0f} MiB",
            f"{row['file_mib']:.3g} MiB",
        )
        for row in grids["sweeps"]
    ]
    peak = max(step["peak_mib"] for step in huge.values() if isinstance(step, dict))
    what = "liquid; planned, run in part, resumed, exported"
    return [*rows, (str(huge["points"]), what, "", "", "", "", f"{peak:.0f} MiB", "")]


def attacks(*kinds: Results) -> Rows:
    """Return what became of each kind of attack on sweeps."""
    columns = ("tried", "survived", "lost", "wrong", "hung")
    tallies = {what: row for kind in kinds for what, row in kind.items()}
    total = (str(sum(row[part] for row in tallies.values())) for part in columns)
    return [
        ("attack", *columns),
        *((what, *(str(row[part]) for part in columns)) for what, row in tallies.items()),
        ("all", *total),
    ]
