"""What the results of each benchmark say in a few lines: `headline(name, results)`.

Lines are made from the records whenever they are shown, never stored: so the table of all results
cannot be older than they are.
"""

from __future__ import annotations

from collections.abc import Callable

from pages import cube, default, lanes, orbits, physics, stochastic
from pages.lines import Lines, Results, shown

STARTS = (
    "import stickslip",
    "stickslip --help",
    "warm first result",
    "cold first result",
    "first result of another installation",
)


def headline(name: str, results: Results) -> Lines:
    """The lines of a benchmark, by what they measure; KeyError for one without lines here."""
    return HEADLINES[name](results)


def _engine(results: Results) -> Lines:
    lines: Lines = {}
    for row in results["sweeps"]:
        lines[f"{row['points']} points, {row['scene']}, {results['workers']} threads"] = (
            f"{row['command_seconds']:.3g} s, {row['points_per_second']:.0f} points/s, "
            f"peak {row['peak_mib']:.0f} MiB, file {row['file_mib']:.3g} MiB"
        )
        lines[f"... a point: kernel, engine on top ({row['points']}, {row['scene']})"] = (
            f"{row['kernel_us_per_point']:.3g} us, {row['overhead_us_per_point']:.2g} us "
            f"({100 * row['overhead_part']:.2g} % of all cores)"
        )
    huge = results["huge"]
    peak = max(huge[step]["peak_mib"] for step in ("plan", "part", "resumed", "export"))
    what = f"{huge['points']} points planned, run in part, resumed, exported: peak"
    return lines | {what: f"{peak:.0f} MiB"}


def _faults(results: Results) -> Lines:
    lines: Lines = {}
    for what, row in results["attacks"].items():
        lines[what] = ", ".join(
            f"{row[part]} {part}" for part in ("tried", "survived", "lost", "wrong", "hung")
        )
    return lines


def _figures(results: Results) -> Lines:
    rows = {name: row for name, row in results.items() if name.startswith("fig")}
    total = sum(row["seconds_median"] for row in rows.values())
    lines = {f"{len(rows)} figures on {results['workers']} threads": f"{total:.3g} s"}
    for name, row in rows.items():
        lines[f"{name}: {row['points']} points"] = (
            f"{row['seconds_median']:.3g} s; error: median {row['error_median']:.1e}, "
            f"max {row['error_max']:.1e}; {row['failed']} failed"
        )
    return lines


def _fixed_lanes(results: Results) -> Lines:
    lines = lanes.machine(results)
    for gamma, plain in results["plain"].items():
        rows = [row for row in results["lanes"] if f"{row['gamma']:.2f}" == gamma]
        steps = [row["ns_per_step"] for row in rows]
        times = [row["times_faster_than_plain"] for row in rows]
        lines[f"gamma = {gamma}: a step in lanes, in a plain loop"] = (
            f"{min(steps):.2g} to {max(steps):.2g} ns, {plain:.3g} ns: "
            f"{min(times):.0f} to {max(times):.0f} times faster"
        )
        parts = [row["part_of_peak"] for row in rows if "part_of_peak" in row]
        if parts:
            lines[f"gamma = {gamma}: part of the peak"] = f"{min(parts):.0%} to {max(parts):.0%}"
    if "full_period" in results:
        full = results["full_period"]
        lines["a whole period, 64 temperatures: a step, largest error of x"] = (
            f"{full['ns_per_step']:.2g} ns, {full['largest_error_x']:.1e}"
        )
    return lines


def _methods(results: Results) -> Lines:
    return {
        f"steps against {results['own']}'s at equal error: {name}": ", ".join(
            f"{ratio:.2f} ({scene})" for scene, ratio in ratios.items()
        )
        for name, ratios in results["compared"].items()
    }


def _refinement(results: Results) -> Lines:
    full, seconds, found = (results[key] for key in ("full_seconds", "refined_seconds", "refined"))
    return {
        f"{results['points']} points in full, refined": f"{full:.3g} s, {seconds:.3g} s",
        "computed of the refined map": f"{found['computed']}, {found['computed_part']:.2%}",
        "wrong pixels: kind, amplitude": f"{found['wrong_kind']}, {found['missed']}",
        "stated error of the interpolated, largest": shown(found["stated_error_max"]),
    } | {
        f"{row['levels']} levels, where {row['where']}": f"{row['computed_part']:.1%} computed; "
        f"{row['wrong_kind'] + row['missed']} wrong"
        for row in results["curve"]
    }


def _skips(results: Results) -> Lines:
    return {
        row["skip"]: (
            f"{row['times_faster']:.3g} times faster; "
            f"changes {row.get('change_of', 'the amplitudes')} by {row['change']:.1e}"
        )
        for row in results["rows"]
    }


def _sweeps(results: Results) -> Lines:
    figures, scaling, overhead = results["figures"], results["scaling"], results["overhead"]
    start = results["start"]
    lines = {
        "Figs. 7, 8, 9 by one command, warm": f"{figures['command_seconds']:.3g} s",
        "their computations alone": (
            f"{figures['computations_seconds']:.3g} s for {figures['points']} points"
        ),
        "their pictures alone": f"{figures['pictures_seconds']:.3g} s",
        "two workers against one": (
            f"{scaling['times_faster']:.3g} times faster; {scaling['points']} points in "
            f"{scaling['one_worker_seconds']:.3g} s on one"
        ),
        "points per second on two workers": shown(scaling["points_per_second"]["2"]),
        "a point in one call of the kernels": f"{overhead['one_call_us_per_point']:.3g} us",
        "the engine adds to a point, cutting included": (
            f"{overhead['with_cutting_us_per_point']:.3g} us"
        ),
    }
    for name, row in results["memory"].items():
        lines[f"peak memory of {name} points"] = f"{row['peak_mib']:.0f} MiB"
    for what in STARTS:
        if what in start:
            lines[what] = f"{start[what]:.3g} s"
    return lines


def _work_precision(results: Results) -> Lines:
    """The ratios of each fluid, Euler-Cromer, and the failures."""
    lines: Lines = {}
    for name, regime in results["regimes"].items():
        for row in regime["ratios"]["times_faster"]:
            error = "its own error" if row["error"] is None else f"error {row['error']:.0e}"
            value = "not reached" if row["ratio"] is None else f"{row['ratio']:.3g} times faster"
            lines[f"{name}: {row['what']}, {error}"] = value
        reference = regime["reference"]
        if "tightest_peer" in reference:
            peer = f"{reference['tightest_peer']} at {reference['its_rtol']:g}"
            lines[f"{name}: reference against {peer}"] = f"{reference['disagreement']:.1e}"
        for curve in regime["curves"]:
            if curve["failures"]:
                lines[f"{name}: {curve['solver']} fails"] = _failures(curve["failures"])
    random = results["random"]
    for name, fluid in random["fluids"].items():
        for row in fluid["costs"]:
            what = f"{random['points']} random points, {name}: error {row['error']:.0e}"
            lines[what] = _costs(row)
    return lines


def _failures(failures: list[Results]) -> str:
    reasons: dict[str, list[str]] = {}
    for failure in failures:
        reasons.setdefault(failure["reason"], []).append(f"{failure['rtol']:.0e}")
    return "; ".join(f"rtol {', '.join(at)}: {why}" for why, at in reasons.items())


def _stability(results: Results) -> Lines:
    """The lines of each question that the record answers."""
    lines: Lines = {}
    for question, lines_of in _QUESTIONS.items():
        if question in results:
            lines |= lines_of(results[question])
    return lines


def _ladder(ladder: Results) -> Lines:
    lines: Lines = {}
    for row in ladder["steps"]:
        lines[f"rtol {row['rtol']:.0e}: true error median, 95 %, worst"] = (
            f"{row['error_median']:.1e}, {row['error_95']:.1e}, {row['error_max']:.1e}"
        )
        lines[f"rtol {row['rtol']:.0e}: stated error held; too large, median and 95 %"] = (
            f"{100 * row['held']:.1f} % of {row['compared']}; "
            f"{row['over_median']:.2g} and {row['over_95']:.2g} times"
        )
    lines["slope of the median error, 1e-3 to 1e-8"] = shown(ladder["slope"])
    return lines


def _references(found: Results) -> Lines:
    lines: Lines = {}
    lines["500 references by plain iteration: wrong orbits, other periods"] = (
        f"{len(found['wrong'])}, {found['other_period']} of {found['compared']} that closed"
    )
    lines["... true error median, worst; stated error held"] = (
        f"{found['error_median']:.1e}, {found['error_max']:.1e}; {100 * found['held']:.1f} %"
    )
    lines["... stated over true error, median and 95 %"] = (
        f"{found['over_median']:.2g} and {found['over_95']:.2g} times"
    )
    return lines


def _locked(locked: Results) -> Lines:
    lines: Lines = {}
    lines[f"{locked['points']} locked blocks near resonance: error of the force, median, worst"] = (
        f"{locked['force_median']:.1e}, {locked['force_max']:.1e}, of {locked['compared']} settled"
    )
    lines["... against abs(2K - M omega^2) X_m; stated error held"] = (
        f"within 1e-5 on {100 * locked['balance_held']:.1f} %, worst {locked['balance_max']:.1e}; "
        f"{100 * locked['held']:.1f} %"
    )
    return lines


def _step_map(steps: Results) -> Lines:
    lines: Lines = {}
    for kind, count in steps["counts"].items():
        lines[f"Euler-Cromer, step over scene ({len(steps['cells'])} cells): {kind}"] = str(count)
    return lines


def _fixed_step(fixed: Results) -> Lines:
    lines: Lines = {}
    lines[f"Euler-Cromer at 0.9 of the largest step, {fixed['points']} orbits"] = (
        f"{_counted(fixed['statuses'])}; true error median, worst "
        f"{fixed['error_median']:.1e}, {fixed['error_max']:.1e}"
    )
    lines["... stated error held; too large, median and 95 %"] = (
        f"{100 * fixed['held']:.1f} %; {fixed['over_median']:.2g} and {fixed['over_95']:.2g} times"
    )
    return lines


def _extremes(extremes: Results) -> Lines:
    lines: Lines = {}
    lines[f"{extremes['points']} random extremes"] = _counted(extremes["statuses"])
    lines["... one at a time"] = _counted(_tally(extremes["one_at_a_time"]))
    sample = extremes["sample"]
    lines["... a sample at a hundredth of the tolerance: within what was stated, wrong"] = (
        f"{100 * sample['held']:.1f} % of {sample['compared']}, {len(sample['wrong'])}"
    )
    return lines


def _acceleration(jumps: Results) -> Lines:
    kinds = {"points, random starts": jumps, "films with several orbits": jumps["several"]}
    lines: Lines = {}
    for kind, found in kinds.items():
        what = f"acceleration on and off, {found['points']} {kind}"
        lines[what] = (
            f"{found['same']} of {found['compared']} on the same orbit, "
            f"{found['periods_plain'] / found['periods']:.2g} times fewer periods"
        )
        lines[f"... {kind}: statuses with, without"] = (
            f"{_counted(found['statuses'])}; {_counted(found['statuses_plain'])}"
        )
    return lines


def _long_run(run: Results) -> Lines:
    lines: Lines = {}
    for scene in run["scenes"]:
        lines[f"{run['periods']} periods, {scene['scene']}: drift, balance"] = (
            f"stress {scene['drift_stress']:.1e}, force {scene['drift_force']:.1e}, "
            f"{scene['balance_after']:.1e}"
        )
    return lines


def _stiff_problems(found: Results) -> Lines:
    lines: Lines = {}
    for name, rows in found["problems"].items():
        lines[f"{name}: error at 1e-4, 1e-6, 1e-8"] = ", ".join(
            f"{row['error']:.1e}" for row in rows if row["rtol"] in (1e-4, 1e-6, 1e-8)
        )
    return lines


def _stated(boxes: Results) -> Lines:
    lines: Lines = {}
    for box, tolerances in boxes.items():
        if box == "seconds_taken":
            continue
        for rtol, found in tolerances.items():
            for kind, row in found["kinds"].items():
                lines[f"films {box}, rtol {float(rtol):.0e}, {kind}: stated error held"] = (
                    f"{100 * row['held']:.2f} % of {row['compared']}, {row['far_off']} off by more "
                    f"than 3 times; too large {row['over_median']:.2g} and {row['over_95']:.2g} "
                    f"times, rank correlation {row['rank_correlation']:.2f}; "
                    f"{_counted(found['statuses'][kind])}"
                )
            if found["balance_max"] > 0.0:
                lines[f"... {box}, rtol {float(rtol):.0e}: worst force of locked blocks"] = (
                    f"{found['balance_max']:.1e} from abs(2K - M omega^2) X_m"
                )
    return lines


def _watched(found: Results) -> Lines:
    lines: Lines = {}
    for what in ("weakly_viscous", "everywhere"):
        row = found[what]
        lines[f"{row['points']} films {what.replace('_', ' ')}, up to 5000 periods"] = (
            f"{_counted(row['statuses'])}; {row['periods']} periods"
        )
    plain, long = found["aperiodic"], found["long_cycles"]
    apart = [film["standard_errors_apart"] for film in plain["films"]]
    lines[f"... {len(apart)} aperiodic against plain iteration of {plain['periods']} periods"] = (
        f"means up to {max(apart, default=0.0):.1f} standard errors apart"
    )
    lines["... cycles of more than 32 periods that still close after 3000 more"] = (
        f"{long['closed']} of {long['found']}"
    )
    for row in found["windows"]:
        film = row["film"]
        what = f"T = {film['temperature']:g}, k = {film['viscosity_coefficient']:g}, aperiodic"
        lines[f"{what}: stated error covers, windows of {', '.join(row['lengths'])}"] = ", ".join(
            f"{100 * of['covered']:.1f} % of {of['aperiodic']}" for of in row["lengths"].values()
        )
    return lines


_QUESTIONS = {
    "ladder": _ladder,
    "references": _references,
    "locked": _locked,
    "step_map": _step_map,
    "fixed_step": _fixed_step,
    "extremes": _extremes,
    "acceleration": _acceleration,
    "long_run": _long_run,
    "stiff_problems": _stiff_problems,
    "stated": _stated,
    "watched": _watched,
}


def _counted(counts: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.items())


def _tally(rows: list[Results]) -> dict[str, int]:
    names = [row["status"] for row in rows]
    return {name: names.count(name) for name in sorted(set(names))}


def _costs(row: Results) -> str:
    if row["steps_per_period"] is None:
        return "not reached"
    steps, seconds = row["steps_per_period"], row["seconds_per_period"]
    ratios = [row["ratio"], row["ratio_one_at_a_time"]]
    times = ", ".join("not reached" if ratio is None else f"{ratio:.3g}" for ratio in ratios)
    return f"{steps:.3g} steps and {1e6 * seconds:.3g} us a period; times faster: {times}"


HEADLINES: dict[str, Callable[[Results], Lines]] = {
    "cube": cube.lines,
    "engine": _engine,
    "faults": _faults,
    "figures": _figures,
    "fixed_lanes": _fixed_lanes,
    "lanes": lanes.lines,
    "methods": _methods,
    "default": default.lines,
    "physics": physics.lines,
    "stochastic": stochastic.lines,
    "random": orbits.lines,
    "refinement": _refinement,
    "skips": _skips,
    "stability": _stability,
    "sweeps": _sweeps,
    "work_precision": _work_precision,
}
