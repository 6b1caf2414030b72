"""The state of a sweep, as seen from another terminal."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.status import Status
from sweeps.engine.counts import tally
from sweeps.engine.existing import Target, found_in_file, found_in_journal
from sweeps.engine.part import Part
from sweeps.engine.resume import opened_journal
from sweeps.files.atomic import refuse_odd_output
from sweeps.files.chunks import Chunks
from sweeps.files.journal import Manifest, readable_manifest
from sweeps.files.results import contents
from sweeps.files.run_folder import RunFolder


def state_of(output: Path) -> dict[str, Any]:
    """Return how the sweep to this output stands; a running sweep is not disturbed.

    `state` is running, stopping, interrupted (its journal can be resumed), partial (a file with
    pending points), complete or absent; the counts are those of `tally`. A file that holds a part
    of a sweep, or is to hold it, adds `part`, and the counts are those of its points. A running
    sweep adds what its heartbeat says. Raises StorageError and RefusalError if what is there
    cannot be read.
    """
    refuse_odd_output(output)
    folder, found = RunFolder(output), {"output": str(output)}
    if folder.is_held():
        return found | {"state": "running"} | folder.last_beat()
    if (manifest := readable_manifest(folder.journal)) is not None:
        return found | _state_of_journal(folder, manifest)
    if output.exists():
        return found | _state_of_file(output)
    return found | {"state": "absent"}


def _state_of_journal(folder: RunFolder, manifest: Manifest) -> dict[str, Any]:
    part, config = manifest.get("part", ""), found_in_journal(folder.journal, manifest).config
    target = Target.of(config, Part.parse(part) if part else None)
    with closing(opened_journal(target, folder, manifest, readonly=True)) as journal:
        statuses = journal.statuses.copy()
        statuses[Status.PENDING] = np.count_nonzero(target.needed & ~journal.done)
    whole = statuses[Status.PENDING] == 0 and folder.output.exists()
    named = {"part": part} if part else {}
    return named | {"state": "complete" if whole else "interrupted"} | tally(statuses)


def _state_of_file(output: Path) -> dict[str, Any]:
    found = found_in_file(output)
    statuses = contents(output, Chunks(found.grid.shape)).statuses
    if found.part:  # which is written where exactly its points are there
        statuses[Status.PENDING] = 0
    named = {"part": found.part} if found.part else {}
    return (
        named | {"state": "partial" if statuses[Status.PENDING] else "complete"} | tally(statuses)
    )
