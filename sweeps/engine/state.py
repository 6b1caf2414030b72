"""How a sweep stands, for whoever asks from another terminal."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.status import Status
from sweeps.engine.existing import found_in_file, found_in_journal
from sweeps.engine.order.part import Part
from sweeps.engine.progress.counts import tally
from sweeps.files.atomic import refuse_odd_output
from sweeps.files.chunks import Chunks
from sweeps.files.journal import Journal, readable_manifest
from sweeps.files.results import contents
from sweeps.files.run_folder import RunFolder


def state_of(output: Path) -> dict[str, Any]:
    """How the sweep to this output stands; nothing is changed, a running sweep is not disturbed.

    `state` is running, stopping, interrupted (its journal can be resumed), partial (a file with
    pending points), complete or absent; the counts are those of `tally`. A file that holds a part
    of a sweep, or is to hold it, adds `part`, and the counts are those of its points. A running
    sweep adds what its heartbeat says. Raises StorageError and RefusalError where what is there
    cannot be read.
    """
    refuse_odd_output(output)
    folder, told = RunFolder(output), {"output": str(output)}
    if folder.is_held():
        return told | {"state": "running"} | _understood(folder.last_beat())
    manifest = readable_manifest(folder.journal)
    if manifest is not None:
        grid, part = found_in_journal(folder.journal, manifest).grid, manifest.get("part", "")
        asked = Part.parse(part).points(grid) if part else np.ones(grid.size, dtype=bool)
        with closing(
            Journal.open(folder.journal, manifest, Chunks(grid.shape), grid.size, readonly=True)
        ) as journal:
            statuses = journal.statuses.copy()
            statuses[Status.PENDING] = np.count_nonzero(asked & ~journal.done)
        whole = statuses[Status.PENDING] == 0 and output.exists()
        told |= {"part": part} if part else {}
        return told | {"state": "complete" if whole else "interrupted"} | tally(statuses)
    if output.exists():
        found = found_in_file(output)
        statuses = contents(output, Chunks(found.grid.shape)).statuses
        if found.part:  # which is written where exactly its points are there
            statuses[Status.PENDING] = 0
            told |= {"part": found.part}
        state = "partial" if statuses[Status.PENDING] else "complete"
        return told | {"state": state} | tally(statuses)
    return told | {"state": "absent"}


def _understood(beat: dict[str, Any]) -> dict[str, Any]:
    """What a heartbeat says, where it has the shape of one; nothing else where it has not."""
    kinds: dict[str, Any] = {"points": int, "done": int, "failed": int, "statuses": dict}
    kinds |= {"seconds_left": (int, float, type(None)), "points_per_second": (int, float)}
    kinds |= dict.fromkeys(("pid", "host", "updated", "state"), (int, str))
    sound = all(isinstance(beat[key], kind) for key, kind in kinds.items() if key in beat)
    counted = "points" not in beat or {"done", "failed", "statuses"} <= beat.keys()
    named = all(name.upper() in Status.__members__ for name in beat.get("statuses") or {})
    whole = {"pid", "host", "updated"} <= beat.keys() or "pid" not in beat
    return beat if sound and counted and named and whole else {}
