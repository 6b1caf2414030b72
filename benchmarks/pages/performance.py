"""Fills the tables of docs/performance.md, stability.md and reliability.md from the records.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`; what is around it is written by
hand and names no measured number, so that a new record never contradicts it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from pages.headlines import headline

RESULTS = Path(__file__).parents[1] / "results"
DOCS = Path(__file__).parents[2] / "docs"
PAGES = tuple(DOCS / f"{name}.md" for name in ("performance", "stability", "reliability"))

FLUIDS = {"gamma=-2/3": "−2/3", "gamma=0": "0", "gamma=2/3": "2/3"}

Results = dict[str, Any]


def main() -> None:
    for page in PAGES:
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")
        print(page)


def filled(page: str) -> str:
    """The page with the tables of today's records."""
    return re.sub(
        r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)",
        lambda found: found[1] + _table(found[2]) + found[3],
        page,
        flags=re.DOTALL,
    )


def _table(name: str) -> str:
    script, make = _TABLES[name]
    path = RESULTS / f"{script}.json"
    source = f"{script}.py"
    if not path.exists():
        return f"\n(No record yet: `bench_{source}`.)\n\n"
    content = json.loads(path.read_text(encoding="utf-8"))
    where = content["environment"]
    note = f"(`bench_{source}`, commit {where['commit']}, {where['processor']})"
    return f"\n{make(content['results'])}\n{note}\n\n"


def _rows(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def _lines_of(script: str) -> Callable[[Results], str]:
    """A table of two columns: the lines of a benchmark as they are."""
    return lambda results: _rows(("what", "value"), headline(script, results).items())


def _against_peers(results: Results) -> str:
    """How many times faster the package is at equal error."""
    columns = {
        "ensemble against numbalsoda": "ensemble",
        "one at a time against numbalsoda": "one at a time",
        "single trajectory against numbalsoda": "single trajectory",
        "single trajectory against the fastest peer": "single, fastest of all",
    }
    errors = (1e-4, 1e-6, 1e-8)
    return _rows(
        ("γ", "error", *columns.values()),
        [
            (shown, f"{error:.0e}", *(_ratio(results, fluid, what, error) for what in columns))
            for fluid, shown in FLUIDS.items()
            for error in errors
        ],
    )


def _random_fluids(results: Results) -> str:
    """Random points of five fluids: what they cost at equal error."""
    head = ("γ", "error", "steps a period", "µs a period", "ensemble", "one at a time")
    fluids = results["random"]["fluids"]
    return _rows(head, [_cells(name, row) for name in fluids for row in fluids[name]["costs"]])


def _cells(name: str, row: Results) -> tuple[str, ...]:
    seconds = row["seconds_per_period"]
    numbers = [row["steps_per_period"], seconds and 1e6 * seconds]
    numbers += [row["ratio"], row["ratio_one_at_a_time"]]
    shown = ("not reached" if number is None else f"{number:.3g}" for number in numbers)
    return name.removeprefix("gamma=").replace("-", "−"), f"{row['error']:.0e}", *shown


def _ratio(results: Results, fluid: str, what: str, error: float) -> str:
    rows = results["regimes"][fluid]["ratios"]["times_faster"]
    (found,) = (row["ratio"] for row in rows if (row["what"], row["error"]) == (what, error))
    return "not reached" if found is None else f"{found:.3g}"


def _against_paper(results: Results) -> str:
    """The scheme of the paper at its step, which is too slow to be run to the end."""
    rows = []
    for fluid, shown in FLUIDS.items():
        scheme = results["regimes"][fluid]["euler_cromer"]
        seconds, error = f"{scheme['seconds_per_period']:.3g}", f"{scheme['error']:.0e}"
        ratio = _ratio(results, fluid, "ensemble against Euler-Cromer (extrapolated)", 1e-6)
        rows.append((shown, seconds, error, ratio))
    head = ("γ", "Euler–Cromer [s a period]", "its error", "ensemble, times faster at error 1e-06")
    return _rows(head, rows)


def _fixed_steps(results: Results) -> str:
    """A step of Euler-Cromer in lanes."""
    rows = []
    for gamma, plain in results["plain"].items():
        lanes = [row for row in results["lanes"] if f"{row['gamma']:.2f}" == gamma]
        best = min(lanes, key=lambda row: row["ns_per_step"])
        least, most = best["ns_per_step"], max(row["ns_per_step"] for row in lanes)
        faster = f"{best['times_faster_than_plain']:.0f}"
        rows.append((gamma, f"{plain:.3g}", f"{least:.2g} to {most:.2g}", faster))
    return _rows(
        ("γ", "plain loop [ns a step]", "lanes [ns a step]", "times faster, at most"), rows
    )


def _attacks(results: Results) -> str:
    """What became of each kind of attack on sweeps."""
    columns = ("tried", "survived", "lost", "wrong", "hung")
    attacks = results["attacks"]
    rows = [
        (what, *(str(row[part]) for part in columns), row["commit"])
        for what, row in attacks.items()
    ]
    total = ("all", *(str(sum(row[part] for row in attacks.values())) for part in columns), "")
    return _rows(("attack", *columns, "commit"), [*rows, total])


_TABLES: dict[str, tuple[str, Callable[[Results], str]]] = {
    "against_peers": ("work_precision", _against_peers),
    "random_fluids": ("work_precision", _random_fluids),
    "against_paper": ("work_precision", _against_paper),
    "fixed_steps": ("fixed_lanes", _fixed_steps),
    "faults": ("faults", _attacks),
} | {
    name: (name, _lines_of(name))
    for name in (
        "random",
        "physics",
        "stochastic",
        "default",
        "lanes",
        "figures",
        "sweeps",
        "engine",
        "cube",
        "refinement",
        "skips",
        "methods",
        "stability",
    )
}


if __name__ == "__main__":
    main()
