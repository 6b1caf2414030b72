"""Run, resume and grow are one rule: compute what is asked for and not there yet."""

from __future__ import annotations

import itertools
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.engine.existing import (
    ExistingPoints,
    RefusalError,
    Target,
    found_beside,
    found_in_file,
)
from sweeps.engine.order.follow import lines_of
from sweeps.files.atomic import StorageError, fingerprint, storage_errors
from sweeps.files.attributes import now
from sweeps.files.columns import failures
from sweeps.files.journal import Journal, Manifest, readable_manifest
from sweeps.files.results import Written, contents
from sweeps.files.run_folder import RunFolder


@dataclass(frozen=True)
class ExistingPolicy:
    """The user's choice about existing results; see the options of `stickslip sweep`."""

    overwrite: bool = False
    retry_failed: bool = False


@dataclass
class PreparedJournal:
    """The journal to write into, what its points come from, and what looks odd about them."""

    journal: Journal
    found: list[str]
    warnings: list[str]


def prepare_journal(target: Target, folder: RunFolder, policy: ExistingPolicy) -> PreparedJournal:
    """Return the journal of this computation, with every point that is there already.

    An interrupted sweep that was begun afresh is resumed when it is asked for afresh once more: the
    same command always leads to the end.

    Raises RefusalError if existing points were computed with other settings or by another
    version, or would be lost; StorageError.
    """
    manifest = _manifest(folder, policy)
    if manifest and not policy.overwrite:
        _refuse_another_part(manifest, target, folder.output)
    if manifest and _continues(manifest, target, folder.output, policy):
        return _resumed(target, folder, manifest, policy)
    if policy.overwrite:
        return _created(target, folder, [], policy, afresh=True)
    sources = found_beside(folder)
    for found in sources:
        found.refuse_differences(target)
        found.refuse_lost_points(target.grid)
    afresh = bool(manifest and manifest["afresh"])  # it stays so when its config grows
    return _created(target, folder, sources, policy, afresh=afresh)


def complete_already(target: Target, folder: RunFolder, policy: ExistingPolicy) -> Written | None:
    """Return what the output holds where that is exactly what is asked for, else None.

    Raises StorageError if it cannot be read; where it does not fit, `prepare_journal` says so.
    """
    output = folder.output
    if policy.overwrite or folder.journal.exists() or not output.exists():
        return None
    found = found_in_file(output)
    same = found.config.resolved_yaml() == target.config.resolved_yaml()
    if not same or not found.fits(target):
        return None
    written = contents(output, target.chunks)
    pending = _lacks_needed(found, written, target)
    return None if pending or (policy.retry_failed and failures(written.statuses)) else written


def _lacks_needed(found: ExistingPoints, written: Written, target: Target) -> bool:
    """Return whether points that are asked for are not in a file."""
    if target.part is None or not written.statuses[Status.PENDING]:
        return bool(written.statuses[Status.PENDING])
    done = np.zeros(target.grid.size, dtype=bool)
    for indices, _ in found.points():
        done[indices] = True
    return bool((target.needed & ~done).any())


def _continues(manifest: Manifest, target: Target, output: Path, policy: ExistingPolicy) -> bool:
    """Return whether a journal is of this computation, and this command left it behind."""
    if manifest["key"] != target.key.hex():
        return False
    if manifest["config"].get("refine") != target.config.resolved().get("refine"):
        return False  # what was interpolated is no point
    if policy.overwrite:
        return bool(manifest["afresh"] and not manifest["finished"])
    return bool(manifest["afresh"]) or manifest["output"] == fingerprint(output)


def _refuse_another_part(manifest: Manifest, target: Target, output: Path) -> None:
    """Raise RefusalError if a part of a sweep would end one that was begun from scratch.

    The output would be replaced by what the journal and this part hold, though it may hold more.
    """
    begun, part = manifest.get("part", ""), _name_of_part(target)
    unfinished = manifest["afresh"] and not manifest["finished"]
    if part and part != begun and unfinished and output.exists():
        raise RefusalError(
            f"{output} would lose points to an unfinished sweep that started from scratch, "
            f"{f'its part {begun}' if begun else 'all of its parts'}: finish that first with the "
            "command that began it, or choose another -o; --overwrite drops them"
        )


def _name_of_part(target: Target) -> str:
    return str(target.part) if target.part else ""


def _resumed(
    target: Target, folder: RunFolder, manifest: Manifest, policy: ExistingPolicy
) -> PreparedJournal:
    journal = Journal.open(folder.journal, manifest, target.chunks, target.grid.size)
    damaged = journal.damaged
    if policy.retry_failed and failures(journal.statuses):
        journal = _without_failures(journal, target, folder)
    found = [f"{journal.done.sum()} in its journal"] if journal.done.any() else []
    passed = f"{damaged} damaged bytes of {folder.journal} were passed over"
    return PreparedJournal(journal, found, [passed] if damaged else [])


def _without_failures(old: Journal, target: Target, folder: RunFolder) -> Journal:
    gone = [indices[target.failed(indices, rows)] for indices, rows in old.records()]
    lost = np.zeros(target.grid.size, dtype=bool)
    lost[np.concatenate(gone)] = True
    if target.grid.followed:  # what follows a failed point is computed anew with it
        lost = lines_of(target.grid, np.flatnonzero(lost))
    kept = ((i[~lost[i]], rows[~lost[i]]) for i, rows in old.records())
    with closing(old):
        return Journal.create(folder.journal, old.manifest, target.chunks, target.grid.size, kept)


def _created(
    target: Target,
    folder: RunFolder,
    sources: list[ExistingPoints],
    policy: ExistingPolicy,
    *,
    afresh: bool,
) -> PreparedJournal:
    """Return a new journal with the points of the sources that the target has too."""
    manifest = manifest_of(target, folder.output, sources, afresh=afresh)
    drop = target.failed if policy.retry_failed else None
    carried = itertools.chain(*(found.carried(target.grid, drop) for found in sources))
    with storage_errors(f"cannot write into {folder.path}", folder.path):
        journal = Journal.create(folder.journal, manifest, target.chunks, target.grid.size, carried)
    count, names = int(np.count_nonzero(journal.done)), " and ".join(s.name for s in sources)
    return PreparedJournal(
        journal,
        [f"{count} in {names}"] if count else [],
        [line for found in sources for line in found.warnings(target)],
    )


def manifest_of(
    target: Target, output: Path, sources: list[ExistingPoints], *, afresh: bool
) -> Manifest:
    """Return what a journal says of its computation, and of where its points come from."""
    return {
        "key": target.key.hex(),
        "config": target.config.resolved(),
        "columns": list(RESULT_COLUMNS),
        "numerics_version": NUMERICS_VERSION,
        "afresh": afresh,
        "part": _name_of_part(target),
        "finished": False,
        "output": fingerprint(output),
        "processors": sorted({name for found in sources for name in found.processors}),
        "history": next((found.history for found in sources if found.history), ""),
        "created": now(),
    }


def _manifest(folder: RunFolder, policy: ExistingPolicy) -> Manifest | None:
    try:
        return readable_manifest(folder.journal)
    except StorageError:
        if policy.overwrite:  # a damaged journal is dropped
            return None
        raise
