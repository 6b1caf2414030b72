"""Run, resume and grow are one rule: compute what is asked for and not there yet."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.status import Status
from sweeps.engine.existing import (
    Found,
    Stock,
    Wanted,
    found_beside,
    found_in_file,
    not_ok,
    readable_manifest,
    warnings_of_near_duplicates,
)
from sweeps.files.datasets import StorageError
from sweeps.files.journal import Journal
from sweeps.files.results import Written, contents
from sweeps.files.run_folder import RunFolder
from sweeps.identity import differences

Manifest = dict[str, Any]


@dataclass(frozen=True)
class Choices:
    """What the user decided about what is there already; see the options of `stickslip sweep`."""

    overwrite: bool = False
    recompute: bool = False
    accept_mixed: bool = False
    retry_failed: bool = False

    @property
    def afresh(self) -> bool:
        """Whether nothing that is there counts."""
        return self.overwrite or self.recompute


def take_stock(wanted: Wanted, output: Path, folder: RunFolder, choices: Choices) -> Stock:
    """The journal of this computation, with every point that is there already.

    An interrupted sweep that was begun afresh goes on when it is asked for afresh once more: the
    same command always leads to the end.

    Raises
    ------
    RefusalError
        What is there was computed with other settings, or holds points that would be lost.
    StorageError
        It cannot be read, or the journal cannot be written.
    """
    manifest = _manifest(folder, choices)
    if choices.afresh:
        unfinished = manifest and manifest["afresh"] and not manifest["finished"]
        if manifest and unfinished and manifest["key"] == wanted.key.hex():
            return _resumed(wanted, folder, manifest, choices)
        if not choices.overwrite:
            for found in found_beside(output, folder.journal):
                found.refuse_lost_points(wanted.grid)
        return _created(wanted, output, folder, [], choices, afresh=True)
    mine = manifest is not None and manifest["key"] == wanted.key.hex()
    if manifest and mine and (manifest["afresh"] or manifest["output"] == fingerprint(output)):
        return _resumed(wanted, folder, manifest, choices)
    sources = found_beside(output, folder.journal)
    for found in sources:
        if not choices.accept_mixed:
            found.refuse_other_settings(wanted.settings)
        found.refuse_lost_points(wanted.grid)
    afresh = bool(manifest and manifest["afresh"])  # it stays so when its config grows
    return _created(wanted, output, folder, sources, choices, afresh=afresh)


def complete_already(
    wanted: Wanted, output: Path, folder: RunFolder, choices: Choices
) -> Written | None:
    """What the output holds, if it is exactly what is asked for; it need not be touched then.

    Raises StorageError where it cannot be read; where it does not fit, `take_stock` says so.
    """
    if choices.afresh or choices.accept_mixed or folder.journal.exists() or not output.exists():
        return None
    found = found_in_file(output)
    same = found.config.resolved_yaml() == wanted.config.resolved_yaml()
    if not same or found.settings != wanted.settings:
        return None
    written = contents(output, wanted.slabs)
    pending, failed = written.statuses[Status.PENDING], written.statuses[1:].sum()
    return None if pending or (failed and choices.retry_failed) else written


def fingerprint(output: Path) -> list[int] | None:
    """Tells whether a file is still the same; None where there is none."""
    try:
        found = output.stat()
    except FileNotFoundError:
        return None
    return [found.st_size, found.st_mtime_ns]


def _resumed(wanted: Wanted, folder: RunFolder, manifest: Manifest, choices: Choices) -> Stock:
    slabs, size = wanted.slabs, wanted.grid.size
    journal = Journal.open(folder.journal, wanted.key, slabs, size)
    damaged = journal.damaged
    if choices.retry_failed and journal.statuses[1:].any():
        again = Journal.create(
            folder.journal,
            wanted.key,
            journal.manifest or manifest,
            slabs,
            size,
            ((indices[~not_ok(rows)], rows[~not_ok(rows)]) for indices, rows in journal.records()),
        )
        journal.close()
        journal = again
    found = [f"{journal.done.sum()} in its journal"] if journal.done.any() else []
    passed = f"{damaged} damaged bytes of {folder.journal} were passed over"
    return Stock(journal, found, [passed] if damaged else [])


def _created(
    wanted: Wanted,
    output: Path,
    folder: RunFolder,
    sources: list[Found],
    choices: Choices,
    *,
    afresh: bool,
) -> Stock:
    mixed = [line for found in sources for line in found.mixed]
    for found in sources:
        lines = differences_told(found, wanted)
        mixed += [line for line in lines if line not in mixed]
    manifest = {
        "key": wanted.key.hex(),
        "config": wanted.config.resolved(),
        "numerics_version": NUMERICS_VERSION,
        "afresh": afresh,
        "finished": False,
        "output": fingerprint(output),
        "mixed": mixed,
        "processors": sorted({name for found in sources for name in found.processors}),
        "history": next((found.history for found in sources if found.history), ""),
        "created": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
    }
    keep = (lambda rows: ~not_ok(rows)) if choices.retry_failed else None
    carried = itertools.chain(*(found.carried(wanted.grid, keep) for found in sources))
    try:
        journal = Journal.create(
            folder.journal, wanted.key, manifest, wanted.slabs, wanted.grid.size, carried
        )
    except OSError as error:
        reason = getattr(error, "strerror", None) or error
        raise StorageError(f"cannot write into {folder.path}: {reason}") from error
    count, names = int(np.count_nonzero(journal.done)), " and ".join(s.name for s in sources)
    return Stock(
        journal,
        [f"{count} in {names}"] if count else [],
        [line for found in sources for line in warnings_of_near_duplicates(found, wanted)],
    )


def differences_told(found: Found, wanted: Wanted) -> list[str]:
    """One line for the points of a source that were computed with other settings."""
    lines = differences(found.settings, wanted.settings)
    return ["; ".join(lines)] if lines else []


def _manifest(folder: RunFolder, choices: Choices) -> Manifest | None:
    try:
        return readable_manifest(folder.journal)
    except StorageError:
        if choices.overwrite:  # a damaged journal is dropped
            return None
        raise
