"""Fills the tables of the pages from the records.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`; what is around it is written by
hand. A function here gives a table's head and rows from the results of some parts of a record.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

from shared.record import RESULTS, Record, Results, read_record

from pages import stability_tables

DOCS = Path(__file__).parents[2] / "docs"
NAMES = ("performance", "stability", "reliability", "decisions/speed")
PAGES = tuple(DOCS / f"{name}.md" for name in NAMES)

FLUIDS = {"gamma=-2/3": "−2/3", "gamma=0": "0", "gamma=2/3": "2/3"}
ERRORS = (1e-4, 1e-6, 1e-8)

Rows = list[Iterable[str]]


class Table(NamedTuple):
    """A script, the parts of its record that a table needs, what makes head and rows of them."""

    script: str
    parts: tuple[str, ...]
    rows: Callable[..., Rows]

    def text(self, record: Record) -> str:
        """Return the table in Markdown."""
        head, *rows = map(tuple, self.rows(*(record[part]["results"] for part in self.parts)))
        lines = [head, ("---",) * len(head), *rows]
        return "".join("| " + " | ".join(line) + " |\n" for line in lines)

    def source(self, record: Record) -> str:
        """Return the script, and at which commits and on which machines the parts were measured."""
        places: dict[tuple[str, str], list[str]] = {}
        for part in self.parts:
            where = record[part]["environment"]
            places.setdefault((where["processor"], where["commit"]), []).append(part)
        if len(places) == 1:
            ((machine, commit),) = places
            return f"(`bench_{self.script}.py`, commit {commit}, {machine})"
        found = [f"{', '.join(parts)} at {place[1]}" for place, parts in places.items()]
        machines = " and ".join(dict.fromkeys(machine for machine, _ in places))
        return f"(`bench_{self.script}.py`, commits: {'; '.join(found)}; {machines})"


def main() -> None:
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
        print(page)


def filled(page: str) -> str:
    """Return the page with the tables of today's records."""
    return re.sub(
        r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)",
        lambda found: found[1] + _filling(TABLES[found[2]]) + found[3],
        page,
        flags=re.DOTALL,
    )


def _filling(table: Table) -> str:
    record = read_record(RESULTS / f"{table.script}.json")
    if not set(table.parts) <= set(record):
        return f"\n(No record yet: `bench_{table.script}.py`.)\n\n"
    return f"\n{table.text(record)}\n{table.source(record)}\n\n"


def _shown(value: float | None, absent: str = "not reached") -> str:
    return absent if value is None else f"{value:.3g}"


def _seconds(value: float) -> str:
    return f"{value:.3g} s"


# --- sweeps ---------------------------------------------------------------------------------------


def _jobs(
    start: Results, figures: Results, regimes: Results, cube: Results, scaling: Results
) -> Rows:
    """Return what a user waits for."""
    points = sum(row["points"] for row in figures["figures"].values())
    rows = {
        "`import stickslip`": _seconds(start["import stickslip"]),
        "`stickslip --help`": _seconds(start["stickslip --help"]),
        "`configs/quickstart.yaml`, two curves of 18 points": _seconds(start["warm first result"]),
    }
    if "cold first result" in start:
        cold, elsewhere = start["cold first result"], start["first result of another installation"]
        rows["... the first time, with compilation"] = _seconds(cold)
        rows["... in another installation of the same sources"] = _seconds(elsewhere)
    rows[f"Figs. 7, 8 and 9: {points} points, files and pictures"] = _seconds(
        figures["command_seconds"]
    )
    computed = sum(row["seconds"] for row in figures["figures"].values())
    rows["... the points alone"] = _seconds(computed)
    share = regimes["computed"] / regimes["points"]
    what = f"`configs/regimes.yaml`: map of {regimes['points']} points, {share:.1%} computed"
    rows[what] = _seconds(regimes["refined_seconds"])
    rows["... the same map in full"] = _seconds(regimes["full_seconds"])
    what = f"a cube of {cube['points']} points, rtol {cube['rtol']:.0e}, three fluids"
    rows[what] = f"{cube['seconds']:.0f} s"
    both = f"{scaling['one_worker_seconds']:.3g} and {scaling['two_workers_seconds']:.3g} s"
    rows[f"{scaling['points']} points of this kind at rtol 1e-06, one worker and two"] = both
    return [("job on two cores", "time"), *rows.items()]


def _errors_of_sweeps(figures: Results, regimes: Results, cube: Results) -> Rows:
    """Return errors of the figures and of a cube; pixels of a refined map."""
    sample, wrong = cube["sample"], regimes["wrong_kind"] + regimes["missed"]
    statuses = ", ".join(f"{count} {name}" for name, count in cube["statuses"].items())
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
        ("cube: statuses", statuses),
        ("cube: largest stated error, ok and aperiodic", stated),
    ]


def _error_of_figure(row: Results) -> str:
    return f"{row['error_median']:.1e}, {row['error_max']:.1e}; {row['failed']}"


def _engine(engine: Results) -> Rows:
    """Time, memory and bytes of large grids, and the share of the engine."""
    head = ("points", "film", "points/s", "kernel [µs a point]", "engine [µs a point]")
    rows: Rows = [(*head, "share of the cores", "peak, at most", "file")]
    rows += [
        (
            f"{row['points']:.0f}",
            row["scene"],
            f"{row['points_per_second']:.0f}",
            _shown(row["kernel_us_per_point"]),
            f"{row['overhead_us_per_point']:.2g}",
            f"{row['overhead_part']:.2g}",
            f"{row['peak_mib']:.0f} MiB",
            f"{row['file_mib']:.3g} MiB",
        )
        for row in engine["sweeps"]
    ]
    huge = engine["huge"]
    peak = max(step["peak_mib"] for step in huge.values() if isinstance(step, dict))
    what = "liquid; planned, run in part, resumed, exported"
    return [*rows, (str(huge["points"]), what, "", "", "", "", f"{peak:.0f} MiB", "")]


# --- orbits ---------------------------------------------------------------------------------------


def _accuracy(found: Results) -> Rows:
    """Return random points: which orbit, how accurate, how honest."""
    plain, points = found["plain_iteration"], found["points"]
    rows = {
        "points that are ok": f"{found['statuses'].get('ok', 0)} of {points}",
        "on the orbit of plain iteration": (
            f"{plain['same_orbit']} of {points} ({plain['settled']} of them settle plainly)"
        ),
        "periods integrated: median, 95 %, largest": _listed(found["periods"].values()),
    }
    for name, errors in found["errors"].items():
        what = f"error of the {name.replace('_', ' ')}: median, largest"
        rows[what] = f"{errors['median']:.1e}, {errors['max']:.1e}"
    for row in found["stated"]:
        what = (
            f"`amplitude_error` at rtol {row['rtol']:.0e}: bounds the error of; too large, median"
        )
        rows[what] = f"{row['held']:.1%}; {row['over_median']:.2g} times"
    return [("what", "value"), *rows.items()]


def _listed(values: Iterable[float]) -> str:
    return ", ".join(map(_shown, values))


def _orbit_times(found: Results) -> Rows:
    """Time for the orbits of all points, against plain iteration with another solver."""
    rows = {"all points on one core": f"{found['seconds']:.2g} s"}
    if "numbalsoda" in found:
        peer, many = found["numbalsoda"], found["in_company"]
        ratios = found["ratios"]
        rows |= {
            "median error, ours and numbalsoda's (at its rtol)": (
                f"{found['error_median']:.1e}, {peer['error_median']:.1e} ({peer['rtol']:.0e})"
            ),
            "points that fail with numbalsoda, left out on both sides": str(peer["failed"]),
            "times faster: all points, γ < 0": _listed((ratios["all"], ratios["gamma<0"])),
            f"a point among {many['points']}: time, times faster": (
                f"{1e6 * many['seconds']:.0f} µs, {many['ratio']:.0f}"
            ),
        }
    return [("what", "value"), *rows.items()]


# --- run time against error -----------------------------------------------------------------------


def _against_peers(fluids: Results) -> Rows:
    """Return how many times faster the package is at equal error."""
    columns = {
        "ensemble against numbalsoda": "ensemble",
        "one at a time against numbalsoda": "one at a time",
        "single trajectory against numbalsoda": "single trajectory",
        "single trajectory against the fastest peer": "single, fastest of all",
    }
    return [
        ("γ", "error", *columns.values()),
        *(
            (shown, f"{error:.0e}", *(_ratio(fluids, fluid, what, error) for what in columns))
            for fluid, shown in FLUIDS.items()
            for error in ERRORS
        ),
    ]


def _ratio(fluids: Results, fluid: str, what: str, error: float) -> str:
    rows = fluids["regimes"][fluid]["ratios"]["times_faster"]
    (found,) = (row["ratio"] for row in rows if (row["what"], row["error"]) == (what, error))
    return _shown(found)


def _random_fluids(random: Results) -> Rows:
    """Return random points of five fluids: cost at one error, ratios of ensembles at three."""
    faster = [f"times faster at {error:.0e}" for error in ERRORS]
    rows: Rows = [("γ", "steps a period", "µs a period", *faster)]
    for name, fluid in random["fluids"].items():
        costs = {row["error"]: row for row in fluid["costs"]}
        steps, seconds = (costs[1e-6][key] for key in ("steps_per_period", "seconds_per_period"))
        ratios = [costs[error]["ratio"] for error in ERRORS]
        shown = map(_shown, (steps, seconds and 1e6 * seconds, *ratios))
        rows.append((name.removeprefix("gamma=").replace("-", "−"), *shown))
    return rows


def _against_paper(fluids: Results) -> Rows:
    """Return the scheme of the paper at its step, which is too slow to be run to the end."""
    times = "ensemble, times faster at error 1e-06"
    rows: Rows = [("γ", "Euler–Cromer [s a period]", "its error", times)]
    for fluid, shown in FLUIDS.items():
        scheme = fluids["regimes"][fluid]["euler_cromer"]
        error = "not measured" if scheme["error"] is None else f"{scheme['error']:.0e}"
        ratio = _ratio(fluids, fluid, "ensemble against Euler-Cromer (extrapolated)", 1e-6)
        rows.append((shown, _shown(scheme["seconds_per_period"]), error, ratio))
    return rows


# --- steps in lanes -------------------------------------------------------------------------------


def _adaptive_steps(adaptive: Results) -> Rows:
    """Return the adaptive method: a step in lanes, and what a single point takes."""
    step = f"a step of {adaptive['lanes']} lanes in a search [ns]"
    one = "a period of one point, scalar [µs]"
    return [
        ("γ", step, one, "... in one of the lanes"),
        *(
            (
                gamma.replace("-", "−"),
                f"{row['search']['ns']:.0f}",
                _shown(1e-3 * row["single"]["scalar_ns"]),
                f"{row['single']['ratio']:.2f} times as long",
            )
            for gamma, row in adaptive["fluids"].items()
        ),
    ]


def _fixed_steps(fixed: Results) -> Rows:
    """Return a step of Euler-Cromer in lanes."""
    rows: Rows = [("γ", "plain loop [ns a step]", "lanes [ns a step]", "times faster, at most")]
    for gamma, plain in fixed["plain"].items():
        lanes = [row for row in fixed["lanes"] if f"{row['gamma']:.2f}" == gamma]
        times = [row["ns_per_step"] for row in lanes]
        faster = max(row["times_faster_than_plain"] for row in lanes)
        between = f"{min(times):.2g} to {max(times):.2g}"
        rows.append((gamma.replace("-", "−"), _shown(plain), between, f"{faster:.0f}"))
    return rows


def _whole_period(period: Results) -> Rows:
    """Return a drive period at the paper's step, run to its end."""
    return [
        ("what", "value"),
        ("steps", f"{period['steps']}"),
        ("time", f"{period['seconds']:.0f} s, {period['ns_per_step']:.2g} ns a step"),
        ("largest error of x", f"{period['largest_error_x']:.1e}"),
    ]


# --- optional physics -----------------------------------------------------------------------------


def _prices(prices: Results) -> Rows:
    """Return what sixth order and a relaxing strain cost a point."""
    models = list(prices["fluids"][0]["microseconds"])
    rows: Rows = [("γ", "default [µs a point]", *(f"{m}, times as much" for m in models[1:]))]
    for row in prices["fluids"]:
        default, *others = row["microseconds"].values()
        factors = (f"{value / default:.2f}" for value in others)
        rows.append((f"{row['gamma']:.2f}".replace("-", "−"), _shown(default), *factors))
    return rows


def _ensembles(found: Results) -> Rows:
    """Return the stochastic film: means beside independent ones, the typical path, prices."""
    ours, plain = found["ensemble"], found["euler_maruyama"]
    closure = [row for row in found["closure"] if row["status"] == 0]
    name = "elastic_stress_amplitude"
    changes = [abs(row[name] / row[f"typical_{name}"] - 1.0) for row in closure]
    beyond = sum(c > row["amplitude_error"] for c, row in zip(changes, closure, strict=True))
    rows = {
        "largest stress at ω = 15 rad/s, ensemble [MPa]": _mean(ours),
        "... by Euler–Maruyama": f"{_mean(plain)}; steps of {_shown(plain['step'])} s",
        "... of the typical path [MPa]": f"{1e-6 * ours['typical_path']:.4f}",
        "largest change of the stress amplitude over ω": f"{max(changes):.2%}",
        "frequencies where it exceeds the stated error": f"{beyond} of {len(closure)}",
    }
    for row in found["prices"]:
        what = f"γ = {row['gamma']:.2f}: µs a period of a realization; a point"
        seconds = f"{_shown(row['microseconds'])}; {_seconds(row['seconds'])}"
        rows[what.replace("-", "−")] = seconds
    return [("what", "value"), *rows.items()]


def _mean(row: Results) -> str:
    mean, error, spread = (1e-6 * row[name] for name in ("mean", "standard_error", "spread"))
    return f"{mean:.4f} ± {error:.4f}, spread {spread:.4f}, {row['periods']} periods"


# --- faults ---------------------------------------------------------------------------------------


def _attacks(*kinds: Results) -> Rows:
    """Return what became of each kind of attack on sweeps."""
    columns = ("tried", "survived", "lost", "wrong", "hung")
    attacks = {what: row for kind in kinds for what, row in kind.items()}
    total = (str(sum(row[part] for row in attacks.values())) for part in columns)
    return [
        ("attack", *columns),
        *((what, *(str(row[part]) for part in columns)) for what, row in attacks.items()),
        ("all", *total),
    ]


VERDICTS = (
    "references", "locked", "stated", "step_map", "fixed_step", "extremes", "acceleration",
    "watched", "long_run",
)  # fmt: skip

TABLES: dict[str, Table] = {
    "jobs": Table("sweeps", ("start", "figures", "regimes", "cube", "scaling"), _jobs),
    "errors_of_sweeps": Table("sweeps", ("figures", "regimes", "cube"), _errors_of_sweeps),
    "engine": Table("sweeps", ("engine",), _engine),
    "accuracy": Table("orbits", ("accuracy",), _accuracy),
    "orbit_times": Table("orbits", ("time",), _orbit_times),
    "against_peers": Table("work_precision", ("fluids",), _against_peers),
    "random_fluids": Table("work_precision", ("random",), _random_fluids),
    "against_paper": Table("work_precision", ("fluids",), _against_paper),
    "adaptive_steps": Table("lanes", ("adaptive",), _adaptive_steps),
    "fixed_steps": Table("lanes", ("fixed",), _fixed_steps),
    "whole_period": Table("lanes", ("period",), _whole_period),
    "prices": Table("physics", ("prices",), _prices),
    "ensembles": Table("physics", ("ensembles",), _ensembles),
    "stability_errors": Table(
        "stability",
        ("ladder", "references", "locked", "fixed_step", "stated"),
        stability_tables.errors,
    ),
    "stability_verdicts": Table("stability", VERDICTS, stability_tables.verdicts),
    "faults": Table(
        "faults", ("damage", "results", "operations", "kills", "together", "workers"), _attacks
    ),
}


if __name__ == "__main__":
    main()
