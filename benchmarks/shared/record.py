"""The command line of a script, its parts, and the record that they leave.

A record is `results/NAME.json`: for each part what was measured, and the environment it was
measured in. A part that is run alone replaces its own entry and no other.
"""

from __future__ import annotations

import argparse
import json
import platform
import subprocess
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from stickslip.compiled.cache import source_hash
from sweeps.files.attributes import software

RESULTS = Path(__file__).parents[1] / "results"

Results = dict[str, Any]
Record = dict[str, dict[str, Any]]
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
        _write(path, {p: record[p] for p in parts if p in record})
    _show(name, record)
    print(path)
    return record


def read_record(path: Path) -> Record:
    """Return a record; empty where there is none."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def environment() -> dict[str, str]:
    """Return commit, code, machine and versions."""
    return {
        "commit": _commit(),
        "code_sha256": source_hash(),
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "software": software(),
    }


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


def _write(path: Path, record: Record) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def _show(name: str, record: Record) -> None:
    """Print the tables of the pages as this record makes them."""
    from pages.tables import TABLES

    for title, table in TABLES.items():
        if table.script == name and set(table.parts) <= set(record):
            print(f"\n{title}\n{table.text(record)}")


def _commit() -> str:
    """Return the commit, marked where the sources, not just earlier results, differ from it."""
    git = ("git", "-C", str(RESULTS.parent))
    sources = ("--", ":/", ":(exclude,top)benchmarks/results")
    changed = _output(*git, "status", "--porcelain", *sources)
    return _output(*git, "rev-parse", "--short", "HEAD") + ("-dirty" if changed else "")


def _output(*command: str) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _processor() -> str:
    lines = _output("lscpu").splitlines()
    known = dict(line.split(":", 1) for line in lines if ":" in line)
    name, cores = known.get("Model name", "unknown").strip(), known.get("CPU(s)", "?").strip()
    return f"{name}, {cores} cores"
