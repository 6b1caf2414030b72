"""Attacks on sweeps: kills, failing files, damage, full disks, signals; and what became of each.

Half an hour and more on two cores. Each kind of attack is a module of `benchmarks/faults/`.
"""

from __future__ import annotations

import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from common import arguments, finish
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
    quick = arguments(__doc__).quick
    rows: dict[str, Any] = {}
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as name, ProcessPoolExecutor(2) as pool:
        tried = {pool.submit(_attack, attack, quick, Path(name)): attack for attack in ATTACKS}
        for future in as_completed(tried):
            rows |= (found := future.result())
            print(f"{tried[future]}: after {time.perf_counter() - begun:.0f} s", flush=True)
            for what, row in found.items():
                print(f"  {what}: {row}", flush=True)
    seconds = time.perf_counter() - begun
    finish("faults", {"seconds": seconds, "attacks": rows}, quick=quick)
    sys.exit(any(row["lost"] + row["wrong"] + row["hung"] for row in rows.values()))


def _attack(attack: str, quick: bool, where: Path) -> dict[str, Any]:
    folder = where / attack
    folder.mkdir()
    found: dict[str, Any] = ATTACKS[attack].run(quick, folder)
    return found


if __name__ == "__main__":
    main()
