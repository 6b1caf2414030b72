"""Run, resume and grow are one rule: compute what is asked for and not there yet."""

from __future__ import annotations

import contextlib
import itertools
import shutil
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import Config
from sweeps.engine.existing import (
    ExistingPoints,
    RefusalError,
    Target,
    found_beside,
    found_in_file,
)
from sweeps.engine.order.follow import lines_of
from sweeps.engine.order.part import Part
from sweeps.files.atomic import StorageError, fingerprint, refuse_odd_output, storage_errors
from sweeps.files.attributes import now
from sweeps.files.columns import failures
from sweeps.files.journal import BYTES_PER_POINT, Journal, Manifest, readable_manifest
from sweeps.files.results import RESULT_BYTES, RESULT_BYTES_PER_POINT, Written, contents
from sweeps.files.run_folder import RunFolder
from sweeps.human import counted, reason, size_text


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


@dataclass(frozen=True)
class Decision:
    """What a sweep does with what is there: decided by reading alone, nothing is changed yet.

    A journal that begins with this `manifest` is continued or, without one, a journal is begun with
    the points of the `sources`, `afresh` if it is to replace the output whatever that holds. Where
    `complete` holds something, the output is exactly what is asked for, and no journal is needed.
    """

    manifest: Manifest | None = None
    sources: tuple[ExistingPoints, ...] = ()
    afresh: bool = False
    complete: Written | None = None

    def there(self, target: Target, folder: RunFolder) -> NDArray[np.bool_]:
        """Return which points (size,) of a target are not computed again."""
        if self.complete is not None:
            return target.needed
        if self.manifest is not None:
            with closing(_opened(target, folder, self.manifest, readonly=True)) as journal:
                return journal.done
        done = np.zeros(target.grid.size, dtype=bool)
        for found in self.sources:
            for numbers, _ in found.carried(target.grid):
                done[numbers] = True
        return done


@dataclass(frozen=True)
class Intention:
    """What a sweep would compute: a target, of which the points of `there` (size,) are not new."""

    target: Target
    there: NDArray[np.bool_]

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Flags (size,) of the points that would be computed."""
        return self.target.needed & ~self.there


def intention(
    config: Config,
    output: Path,
    part: Part | None = None,
    policy: ExistingPolicy = ExistingPolicy(),
) -> Intention:
    """Return what a sweep of a config into an output would compute; nothing is changed.

    Raises whatever the sweep would refuse before it computes: RefusalError, PulledError,
    InUseError, StorageError.
    """
    refuse_odd_output(output)
    target, folder = Target.of(config, part), RunFolder(output)
    with named_after(output):
        folder.require_free()
        there = decide(target, folder, policy).there(target, folder)
        needed = np.count_nonzero(target.needed | there)
        require_room(folder, int(np.count_nonzero(target.needed & ~there)), int(needed))
    return Intention(target, there)


def decide(target: Target, folder: RunFolder, policy: ExistingPolicy) -> Decision:
    """Return what a sweep does with the points that are there; whoever asks gets the same answer.

    An interrupted sweep that was begun afresh is resumed when it is asked for afresh once more: the
    same command always leads to the end.

    Raises RefusalError if existing points were computed with other settings or by another
    version, or would be lost; StorageError.
    """
    if not (folder.output.exists() or folder.journal.exists()):
        require_room(folder, target.points, target.points)  # before they take memory
    if (complete := _complete_already(target, folder, policy)) is not None:
        return complete
    manifest = _manifest(folder, policy)
    if manifest and not policy.overwrite:
        _refuse_another_part(manifest, target, folder.output)
    if manifest and _continues(manifest, target, folder.output, policy):
        return Decision(manifest)
    if policy.overwrite:
        return Decision(afresh=True)
    sources = found_beside(folder)
    for found in sources:
        found.refuse_differences(target)
        found.refuse_lost_points(target.grid)
    # It stays afresh when its config grows.
    return Decision(sources=tuple(sources), afresh=bool(manifest and manifest["afresh"]))


def prepare_journal(
    target: Target, folder: RunFolder, policy: ExistingPolicy, decision: Decision
) -> PreparedJournal:
    """Return the journal of this computation, with every point that is there already.

    Raises StorageError.
    """
    if decision.manifest is not None:
        return _resumed(target, folder, decision.manifest, policy)
    return _created(target, folder, decision, policy)


def require_room(folder: RunFolder, left: int, total: int) -> None:
    """Raise StorageError now rather than after the computation of what is left of the points."""
    needed = left * BYTES_PER_POINT + total * RESULT_BYTES_PER_POINT + RESULT_BYTES
    free = shutil.disk_usage(folder.nearest).free
    if free < needed:
        raise StorageError(
            f"{folder.path.parent} has {size_text(free)} left, but the sweep of "
            f"{counted(total, 'point')} may need {size_text(needed)}; make room, or write "
            "elsewhere with -o"
        )


@contextlib.contextmanager
def named_after(output: Path) -> Iterator[None]:
    """Errors of the files beside an output, with its name."""
    try:
        yield
    except StorageError:
        raise
    except OSError as error:
        raise StorageError(
            f"cannot read or write what belongs to {output}: {reason(error)}; what is finished is "
            "kept"
        ) from error


def _complete_already(target: Target, folder: RunFolder, policy: ExistingPolicy) -> Decision | None:
    """Return the decision where the output holds exactly what is asked for, else None.

    Raises StorageError if it cannot be read; where it does not fit, `decide` says so.
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
    if pending or (policy.retry_failed and failures(written.statuses)):
        return None
    return Decision(sources=(found,), complete=written)


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
    journal = _opened(target, folder, manifest)
    damaged = journal.damaged
    if policy.retry_failed and failures(journal.statuses):
        journal = _without_failures(journal, target, folder)
    found = [f"{journal.done.sum()} in its journal"] if journal.done.any() else []
    passed = f"{damaged} damaged bytes of {folder.journal} were passed over"
    return PreparedJournal(journal, found, [passed] if damaged else [])


def _opened(
    target: Target, folder: RunFolder, manifest: Manifest, *, readonly: bool = False
) -> Journal:
    size = target.grid.size
    return Journal.open(folder.journal, manifest, target.chunks, size, readonly=readonly)


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
    target: Target, folder: RunFolder, decision: Decision, policy: ExistingPolicy
) -> PreparedJournal:
    """Return a new journal with the points of the sources that the target has too."""
    sources = decision.sources
    manifest = manifest_of(target, folder.output, sources, afresh=decision.afresh)
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
    target: Target, output: Path, sources: Sequence[ExistingPoints], *, afresh: bool
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
