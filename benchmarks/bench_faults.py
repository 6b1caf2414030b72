"""Attacks on sweeps: kills, failing files, damage, full disks, signals; and what became of each.

Two hours and more on two cores. The attacks are in `benchmarks/faults/`; a kind that is tried
alone (`bench_faults.py operations workers`) leaves the others as they are in the record.
"""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from faults import damage, kills, kinds, outputs, page, planted, together, workers
from faults.arena import Tally
from shared.measuring import measure


def _attack(run: Callable[[bool, Path], dict[str, Tally]], quick: bool) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        tallies = {what: vars(tally) for what, tally in run(quick, Path(folder)).items()}
    for what, tally in tallies.items():
        print(f"  {what}: {tally}", flush=True)
    return tallies


# Two at a time; the longest first.
ATTACKS = {
    "damage": damage.journals,
    "results": damage.results,
    "operations": kills.failures,
    "kills": kills.kills,
    "memory": kills.memory,
    "kinds": kinds.run,
    "together": together.run,
    "workers": workers.run,
    "outputs": outputs.run,
    "page": page.run,
    "planted": planted.run,
}

if __name__ == "__main__":
    # In the background of a shell, or under nohup, some are ignored, and a process hands that down:
    # what is attacked would rightly not hear them.
    for number in together.SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    parts = {kind: partial(_attack, run) for kind, run in ATTACKS.items()}
    record = measure("faults", __doc__, parts, processes=2)
    tallies = [tally for part in record.values() for tally in part["results"].values()]
    sys.exit(any(tally["lost"] + tally["wrong"] + tally["hung"] for tally in tallies))
