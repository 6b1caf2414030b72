"""Attacks on sweeps: kills, failing files, damage, full disks, signals; and what became of each.

Half an hour and more on two cores. Each kind of attack is a module of `benchmarks/faults/`, and can
be tried alone (`bench_faults.py operations workers`): the others stay as they are in the record,
where each names its commit.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from common import arguments, finish
from environment import HERE, environment
from faults import damage, kills, operations, results, together, workers

# Two at a time; the longest first.
ATTACKS = {
    "damage": damage,
    "results": results,
    "operations": operations,
    "kills": kills,
    "together": together,
    "workers": workers,
}


def main() -> None:
    chosen = arguments(__doc__, parts=ATTACKS)
    kinds = [kind for kind in ATTACKS if kind in chosen.parts or not chosen.parts]
    rows: dict[str, Any] = _recorded() if chosen.parts and not chosen.quick else {}
    commit, begun = environment()["commit"], time.perf_counter()
    with tempfile.TemporaryDirectory() as name, ProcessPoolExecutor(2) as pool:
        tried = {pool.submit(_attack, kind, chosen.quick, Path(name)): kind for kind in kinds}
        for future in as_completed(tried):
            found = future.result()
            rows |= {what: row | {"commit": commit} for what, row in found.items()}
            print(f"{tried[future]}: after {time.perf_counter() - begun:.0f} s", flush=True)
            for what, row in found.items():
                print(f"  {what}: {row}", flush=True)
    finish("faults", {"attacks": rows}, quick=chosen.quick)
    sys.exit(any(row["lost"] + row["wrong"] + row["hung"] for row in rows.values()))


def _recorded() -> dict[str, Any]:
    """What became of each kind when it was last tried."""
    record = json.loads((HERE / "results" / "faults.json").read_text())
    attacks: dict[str, Any] = record["results"]["attacks"]
    return attacks


def _attack(attack: str, quick: bool, where: Path) -> dict[str, Any]:
    folder = where / attack
    folder.mkdir()
    found: dict[str, Any] = ATTACKS[attack].run(quick, folder)
    return found


if __name__ == "__main__":
    main()
