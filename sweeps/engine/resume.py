"""Run, resume and grow follow one rule: compute the requested points that do not exist yet."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import Config
from sweeps.engine.existing import (
    ExistingPoints,
    Part,
    RefusalError,
    Target,
    found_in_file,
    found_in_input,
    found_in_journal,
)
from sweeps.engine.refine import interpolate
from sweeps.exits import StorageError
from sweeps.files.atomic import fingerprint, refuse_odd_output, storage_errors
from sweeps.files.attributes import now
from sweeps.files.journal import BYTES_PER_POINT, Journal, Manifest, readable_manifest
from sweeps.files.outputs import WAYS_OUT
from sweeps.files.result_rows import Chunks, Memory, failures, tally
from sweeps.files.run_folder import RunFolder
from sweeps.files.sweep_file import RESULT_BYTES, RESULT_BYTES_PER_POINT, Written, contents
from sweeps.grid import Grid
from sweeps.human import counted, reason, size_text

# Bytes of memory for each point of a grid: its place in the journal, its status and its key; on a
# followed axis also the key of its line; on a refined grid several copies of its row.
_HELD, _FOLLOWED, _REFINED = 16, 48, 800


@dataclass(frozen=True)
class ExistingPolicy:
    """The user's choice about existing results; see the options of `stickslip sweep`."""

    overwrite: bool = False
    retry_failed: bool = False


@dataclass(frozen=True)
class Decision:
    """What a sweep does with existing points; deciding only reads and changes nothing.

    With a `manifest` the sweep continues its journal, which holds the points of `journal`; it takes
    over the points of `file`. Without a manifest it begins a journal, `afresh` if the journal will
    replace the output whatever that contains. If `complete` is set, the output is exactly the
    requested result, and no journal is needed.
    """

    target: Target
    folder: RunFolder
    policy: ExistingPolicy
    manifest: Manifest | None = None
    journal: ExistingPoints | None = None
    file: ExistingPoints | None = None
    afresh: bool = False
    complete: Written | None = None

    @property
    def sources(self) -> list[ExistingPoints]:
        """All existing points."""
        return [found for found in (self.journal, self.file) if found]

    @cached_property
    def there(self) -> NDArray[np.bool_]:
        """Flags (size,) of the points of the target that exist already."""
        if self.complete is not None:
            return self.target.needed
        config, grid = self.target.config, self.target.grid
        done = np.zeros(grid.size, dtype=bool)
        # Only the rows of all computed points tell whether the others are interpolated.
        store = Memory(grid.size) if config.refine else None
        if self.manifest is not None:
            opened = opened_journal(self.target, self.folder, self.manifest, readonly=True)
            with closing(opened) as journal:
                done |= journal.done
                if store:
                    store.append(np.flatnonzero(done), journal.rows()[done])
        if self.file is not None:
            for numbers, rows in self.file.carried(self.target):
                done[numbers] = True
                if store:
                    store.append(numbers, rows)
        if store:
            interpolate(config, grid, store)
            done |= store.done
        return done

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Flags (size,) of the points to compute."""
        return self.target.needed & ~self.there

    def begin(self, *, with_failures: bool = False) -> Journal:
        """Return the journal of this computation, with every existing point.

        Points that a retry computes again are missing, unless `with_failures`. Raises StorageError.
        """
        with storage_errors(f"cannot write into {self.folder.path}", self.folder.path):
            journal = self._opened(with_failures=with_failures)
            try:
                self._take_over(journal)
                if self.policy.retry_failed:
                    begun = {"retried": journal.records, "finished": False}
                    journal.note(journal.manifest | begun)
                    forget_failures(journal, self.target)
            except BaseException:
                journal.close()
                raise
        self.target.keys.release()  # from here on every point is known by its number
        return journal

    def found(self, journal: Journal) -> str:
        """Return how many points exist and where, as text; empty if there are none."""
        count, names = int(np.count_nonzero(journal.done)), [each.name for each in self.sources]
        if self.manifest is not None and is_of(self.manifest, self.target):
            names[0] = "its journal"
        return f"{count} in {' and '.join(names)}" if count else ""

    def warnings(self, journal: Journal) -> list[str]:
        """Return a line for each oddity of the existing points."""
        lines = [line for found in self.sources for line in found.warnings(self.target)]
        if journal.damaged:
            lines.append(f"{journal.damaged} damaged bytes of {self.folder.journal} were skipped")
        return lines

    def _opened(self, *, with_failures: bool) -> Journal:
        """Return the journal to continue, or a new one."""
        target, folder = self.target, self.folder
        if self.manifest is not None:
            return opened_journal(target, folder, self.manifest, with_failures=with_failures)
        begun = self._manifest(self.afresh)
        if self.file:  # it is read until the journal holds all its points
            begun["output"] = None
        return Journal.create(folder.journal, begun, target.keys, target.chunks)

    def _take_over(self, journal: Journal) -> None:
        """Copy the points of a file into the journal, and note the target in its manifest."""
        if self.file is not None:
            for numbers, rows in self.file.carried(self.target):
                journal.append(numbers, rows)
            journal.flush()  # before the manifest says that the journal has all of the file
        if self.file is not None or not is_of(journal.manifest, self.target):
            # `afresh` and `retried` stay as they were when the config grows.
            before = journal.manifest
            journal.note(self._manifest(before["afresh"]) | {"retried": before["retried"]})
        elif journal.manifest.get("part", "") != (part := _name_of_part(self.target)):
            journal.note(journal.manifest | {"part": part})  # another part, or the whole, continues

    def _manifest(self, afresh: bool) -> Manifest:
        return manifest_of(self.target, self.folder.output, self.sources, afresh=afresh)


def intention(
    config: Config,
    output: Path,
    part: Part | None = None,
    policy: ExistingPolicy = ExistingPolicy(),
) -> Decision:
    """Return what a sweep of a config into an output would do, without changing anything.

    Raises the errors with which the sweep would refuse to begin: RefusalError, PulledError,
    InUseError, StorageError.
    """
    refuse_odd_output(output)
    target, folder = Target.of(config, part), RunFolder(output)
    with named_after(output):
        folder.require_free()
        decision = decide(target, folder, policy)
        needed = np.count_nonzero(target.needed | decision.there)
        require_room(folder, int(np.count_nonzero(decision.missing)), int(needed))
    return decision


def decide(target: Target, folder: RunFolder, policy: ExistingPolicy) -> Decision:
    """Return what a sweep does with existing points; `check`, `plan` and `status` use it too.

    If an interrupted sweep was begun afresh, the same command with --overwrite resumes it:
    repeating a command always finishes the sweep.

    Raises RefusalError if existing points were computed with other settings or by another
    version, or would be lost; StorageError.
    """
    _require_memory(target)
    if not (folder.output.exists() or folder.journal.exists()):
        require_room(folder, target.points, target.points)  # before the points take memory
    nothing = Decision(target, folder, policy)
    if (complete := _complete_already(nothing)) is not None:
        return complete
    manifest = None
    try:
        manifest = readable_manifest(folder.journal)
    except StorageError:
        if not policy.overwrite:  # --overwrite drops a damaged journal
            raise
    afresh = bool(manifest and manifest["afresh"])
    if policy.overwrite:
        is_begun = manifest and afresh and not manifest["finished"] and is_of(manifest, target)
        if not is_begun:
            return replace(nothing, afresh=True)
    elif manifest:
        _refuse_another_part(manifest, target, folder.output)
    decision = replace(
        nothing,
        manifest=manifest,
        journal=found_in_journal(folder.journal, manifest) if manifest else None,
        file=_found_in_output(folder.output) if _may_have_more(folder.output, manifest) else None,
        afresh=afresh,
    )
    for found in decision.sources:
        found.refuse_differences(target)
        if found.config.sha256() != target.sha256:
            found.refuse_lost_points(target)
    return decision


def require_room(folder: RunFolder, left: int, total: int) -> None:
    """Raise StorageError before the sweep if the disk lacks room for `left` of `total` points."""
    needed = left * BYTES_PER_POINT + total * RESULT_BYTES_PER_POINT + RESULT_BYTES
    usage = shutil.disk_usage(folder.nearest)
    if usage.total > 0 and usage.free < needed:  # some file systems state no size
        raise StorageError(
            f"{folder.path.parent} has {size_text(usage.free)} left, but the sweep of "
            f"{counted(total, 'point')} may need {size_text(needed)}; make room, or write "
            "elsewhere with -o"
        )


def _require_memory(target: Target) -> None:
    """Raise StorageError if the grid alone takes more memory than the machine has."""
    each = _REFINED if target.config.refine else _FOLLOWED if target.grid.followed else _HELD
    needed, there = each * target.grid.size, free_memory()
    if needed > there:
        raise StorageError(
            f"a sweep of {counted(target.grid.size, 'point')} needs {size_text(needed)} of memory, "
            f"but this machine has {size_text(there)}; use fewer values, or sweep one part of the "
            "grid at a time, each into its own file"
        )


def free_memory() -> float:
    """Return the bytes of memory of this machine; infinity if they are unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return math.inf


@contextlib.contextmanager
def named_after(output: Path) -> Iterator[None]:
    """Turn an OSError, perhaps of a file beside the output, into one that names the output."""
    try:
        yield
    except StorageError:
        raise
    except OSError as error:
        raise StorageError(
            f"cannot read or write the files of {output}: {reason(error)}; finished points are kept"
        ) from error


def _complete_already(nothing: Decision) -> Decision | None:
    """Return the decision if the output is exactly the requested result, else None.

    Raises StorageError if the output cannot be read; if it does not fit, `decide` raises.
    """
    target, folder, policy = nothing.target, nothing.folder, nothing.policy
    if policy.overwrite or folder.journal.exists() or not folder.output.exists():
        return None
    found = _found_in_output(folder.output)
    same = found.config.resolved_yaml() == target.config.resolved_yaml()
    if not same or not found.fits(target):
        return None
    written = contents(folder.output, target.chunks)
    pending = bool(written.statuses[Status.PENDING])
    if pending and target.part is not None:  # points of other parts may be pending
        done = np.zeros(target.grid.size, dtype=bool)
        for indices, _ in found.points():
            done[indices] = True
        pending = bool((target.needed & ~done).any())
    if pending or (policy.retry_failed and failures(written.statuses)):
        return None
    return replace(nothing, file=found, complete=written)


def _found_in_output(output: Path) -> ExistingPoints:
    """Return the finished points of an output; raises RefusalError if it is the file of a fit.

    A fit's file holds its curve like a sweep's, but a sweep would drop the data and the fit.
    """
    found = found_in_file(output)
    if found.is_fit:
        raise RefusalError(f"{output} holds a fit, not a sweep; {WAYS_OUT}")
    return found


def is_of(manifest: Manifest, target: Target) -> bool:
    """Return whether a journal belongs to exactly this config, not just to some of its points."""
    return bool(manifest["sha256"] == target.sha256)


def _may_have_more(output: Path, manifest: Manifest | None) -> bool:
    """Return whether an output may have points that a journal lacks."""
    if manifest is None:
        return output.exists()
    return not manifest["afresh"] and output.exists() and manifest["output"] != fingerprint(output)


def _refuse_another_part(manifest: Manifest, target: Target, output: Path) -> None:
    """Raise RefusalError if a part would complete an unfinished sweep that began from scratch.

    The journal and this part would replace the output, though the output may hold more points.
    """
    begun, part = manifest.get("part", ""), _name_of_part(target)
    unfinished = manifest["afresh"] and not manifest["finished"]
    if part and part != begun and unfinished and output.exists():
        raise RefusalError(
            f"{output} would lose points: an unfinished sweep that started from scratch "
            f"({f'part {begun}' if begun else 'all parts'}) would replace it; finish that first "
            "with the command that began it, or choose another -o; --overwrite drops the points"
        )


def _name_of_part(target: Target) -> str:
    return str(target.part) if target.part else ""


def opened_journal(
    target: Target,
    folder: RunFolder,
    manifest: Manifest,
    *,
    readonly: bool = False,
    with_failures: bool = False,
) -> Journal:
    """Open the journal of a target, without the points that a retry computes again, by default."""
    keys, chunks = target.keys, target.chunks
    journal = Journal.open(folder.journal, manifest, keys, chunks, readonly=readonly)
    if not with_failures:
        forget_failures(journal, target)
    return journal


def forget_failures(journal: Journal, target: Target) -> None:
    """Drop the points that had failed when a retry was requested."""
    if count := journal.manifest["retried"]:
        failed = journal.failures_before(count) & target.needed
        if target.grid.followed:  # the points after a failed one are computed again with it
            failed = lines_of(target.grid, np.flatnonzero(failed))
        journal.forget(failed)


def manifest_of(
    target: Target, output: Path, sources: Sequence[ExistingPoints], *, afresh: bool
) -> Manifest:
    """Return the manifest of a journal: its computation, and the origin of its points."""
    return {
        "sha256": target.sha256,
        "config": target.config.resolved(),
        "columns": list(RESULT_COLUMNS),
        "numerics_version": NUMERICS_VERSION,
        "afresh": afresh,
        "part": _name_of_part(target),
        "finished": False,
        "retried": 0,
        "output": fingerprint(output),
        "processors": sorted({name for found in sources for name in found.processors}),
        "history": next((found.history for found in sources if found.history), ""),
        "created": now(),
    }


def lines_of(grid: Grid, points: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which points (grid.size,) share a line with one of these points."""
    lines, chosen = grid.lines(), np.zeros(grid.size, dtype=bool)
    chosen[points] = True
    chosen[lines] = chosen[lines].any(axis=1, keepdims=True)
    return chosen


def state_of(output: Path) -> dict[str, Any]:
    """Return the state of the sweep to this output, without disturbing it if it is running.

    `state` is running, stopping, interrupted (its journal can be resumed), partial (a file with
    pending points), complete or absent; the counts are those of `tally`. A part of a sweep adds
    `part` and counts only its own points. A running sweep adds its heartbeat. Raises StorageError
    and RefusalError if existing files cannot be read or are of another kind, such as a fit.
    """
    refuse_odd_output(output)
    folder, found = RunFolder(output), {"output": str(output)}
    if folder.is_held():
        # The heartbeat has the output as that sweep was given it, relative to its folder.
        return {"state": "running"} | folder.last_beat() | found
    if (manifest := readable_manifest(folder.journal)) is not None:
        config, part = found_in_journal(folder.journal, manifest).config, manifest.get("part", "")
        target = Target.of(config, Part.parse(part) if part else None)
        with closing(opened_journal(target, folder, manifest, readonly=True)) as journal:
            interpolate(target.config, target.grid, journal)
            statuses = journal.statuses.copy()
            statuses[Status.PENDING] = np.count_nonzero(target.needed & ~journal.done)
        # An output beside a journal of all points may be the older result that they replace.
        kept = manifest["finished"] and folder.output.exists()
        state = "complete" if kept and not statuses[Status.PENDING] else "interrupted"
    elif output.exists():
        existing = found_in_input(output)
        if existing.is_fit:
            raise RefusalError(f"{output} holds a fit, not a sweep; `stickslip info` describes it")
        part, statuses = existing.part, contents(output, Chunks(existing.grid.shape)).statuses
        if part:  # a file has this attribute only if exactly that part is finished
            statuses[Status.PENDING] = 0
        state = "partial" if statuses[Status.PENDING] else "complete"
    else:
        return found | {"state": "absent"}
    named = {"part": part} if part else {}
    return found | named | {"state": state} | tally(statuses)
