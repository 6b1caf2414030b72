"""The command line of a script, its parts, and the record that they leave.

A part that is run alone replaces its own entry in the record and no other.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed

from pages.tables import TABLES

from shared.record import RESULTS, Record, Results, environment, read_record, write_record

Part = Callable[[bool], Results]
"""Measures something; the argument says whether it only shows that it is alive."""


def measure(
    name: str,
    doc: str | None,
    parts: Mapping[str, Part],
    *,
    long: Collection[str] = (),
    processes: int = 1,
) -> Record:
    """Run the parts of a script that its command line asks for; keep and return the record.

    Those that are `long` run with `--full`, with `--quick`, and when they are named.
    """
    chosen = _arguments(doc, parts, long)
    every = chosen.quick or chosen.full
    wanted = chosen.parts or [part for part in parts if every or part not in long]
    path = RESULTS / "quick" / f"{name}.json" if chosen.quick else RESULTS / f"{name}.json"
    record, where = {} if chosen.quick else read_record(path), environment()
    for part, results in _measured({p: parts[p] for p in wanted}, processes, chosen.quick):
        record[part] = {"environment": where, "results": results}
        write_record(path, {p: record[p] for p in parts if p in record})
    _show(name, record)
    print(path)
    return record


def _arguments(
    doc: str | None, parts: Collection[str], long: Collection[str]
) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(doc or "").split("\n\n")[0])
    parser.add_argument("--quick", action="store_true", help="keep the script alive, no more")
    longer = f"also what takes long: {', '.join(long) or 'the same here'}"
    parser.add_argument("--full", action="store_true", help=longer)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"only {', '.join(parts)}")
    chosen = parser.parse_args()
    if unknown := set(chosen.parts) - set(parts):
        parser.error(f"no part is called {', '.join(sorted(unknown))}")
    return chosen


def _measured(parts: dict[str, Part], processes: int, quick: bool) -> Iterator[tuple[str, Results]]:
    """Return the results of each part when it is done, one after the other or side by side."""
    begun = time.perf_counter()
    if processes == 1:
        for part, run in parts.items():
            print(f"\n{part}", flush=True)
            yield part, run(quick)
        return
    with ProcessPoolExecutor(processes) as pool:
        running = {pool.submit(run, quick): part for part, run in parts.items()}
        for future in as_completed(running):
            print(f"{running[future]}: after {time.perf_counter() - begun:.0f} s", flush=True)
            yield running[future], future.result()


def _show(name: str, record: Record) -> None:
    """Print the tables of the pages as this record makes them."""
    for title, table in TABLES.items():
        if table.script == name and set(table.parts) <= set(record):
            print(f"\n{title}\n{table.text(record)}")
