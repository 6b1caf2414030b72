"""Fills the tables of the pages from the records.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`; what is around it is written by
hand. A function gives a table's lines from the results of some parts of a record.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from shared.record import RESULTS, Record, read_record

from pages import orbit_tables, solver_tables, stability_tables, sweep_tables
from pages.numbers import Lines

DOCS = Path(__file__).parents[2] / "docs"
NAMES = (
    "performance", "stability", "reliability", "benchmark-orbits", "decisions/integrator",
    "decisions/speed",
)  # fmt: skip
PAGES = tuple(DOCS / f"{name}.md" for name in NAMES)


class Table(NamedTuple):
    """A script, the parts of its record that a table needs, what makes its lines of them."""

    script: str
    parts: tuple[str, ...]
    lines: Callable[..., Lines]

    def text(self, record: Record) -> str:
        """Return the table in Markdown."""
        head, *rows = self.lines(*(record[part]["results"] for part in self.parts))
        rule = " | ".join("---" for _ in head.split(" | "))
        return "".join(f"| {line} |\n" for line in (head, rule, *rows))

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


ERRORS = ("ladder", "references", "locked", "fixed_step", "stated")

VERDICTS = (
    "references", "locked", "stated", "step_map", "fixed_step", "extremes", "acceleration",
    "freezing", "multipliers", "watched", "long_run",
)  # fmt: skip

ATTACKS = (
    "damage", "results", "operations", "kills", "memory", "kinds", "together", "workers", "outputs",
    "page", "planted",
)  # fmt: skip

FITS = ("random_1", "random_2", "random_3", "random_4", "four", "starts", "three")

TABLES: dict[str, Table] = {
    "jobs": Table("sweeps", ("start", "figures", "regimes", "cube", "scaling"), sweep_tables.jobs),
    "errors_of_sweeps": Table(
        "sweeps", ("figures", "regimes", "cube"), sweep_tables.errors_of_sweeps
    ),
    "engine": Table("engine", ("grids", "huge"), sweep_tables.engine),
    "accuracy": Table("orbits", ("accuracy",), orbit_tables.accuracy),
    "derivatives": Table("derivatives", ("together", "derivatives"), orbit_tables.derivatives),
    "fits": Table("fit", FITS, orbit_tables.fits),
    "reference_orbits": Table("reference", ("orbits",), orbit_tables.reference_orbits),
    "orbit_times": Table("orbits", ("time",), orbit_tables.orbit_times),
    "against_peers": Table("work_precision", ("fluids",), solver_tables.against_peers),
    "random_fluids": Table("work_precision", ("random",), solver_tables.random_fluids),
    "against_paper": Table("work_precision", ("fluids",), solver_tables.against_paper),
    "adaptive_steps": Table("lanes", ("adaptive",), solver_tables.adaptive_steps),
    "fixed_steps": Table("lanes", ("fixed",), solver_tables.fixed_steps),
    "of_peak": Table("lanes", ("peak",), solver_tables.of_peak),
    "methods": Table("methods", ("variants",), solver_tables.methods),
    "stability_errors": Table("stability", ERRORS, stability_tables.errors),
    "stability_work": Table("stability", ("work",), stability_tables.work),
    "stability_verdicts": Table("stability", VERDICTS, stability_tables.verdicts),
    "faults": Table("faults", ATTACKS, sweep_tables.attacks),
}


if __name__ == "__main__":
    main()
