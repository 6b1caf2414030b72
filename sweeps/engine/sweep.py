"""A sweep on disk: finished work is kept, and the same command always resumes it."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip.status import Status
from sweeps.config.load import Config
from sweeps.engine.counts import Counts
from sweeps.engine.existing import RefusalError, Target
from sweeps.engine.outcome import Console, JournaledResult, Outcome
from sweeps.engine.part import Part
from sweeps.engine.recording import Recorder
from sweeps.engine.resume import (
    Decision,
    ExistingPolicy,
    decide,
    forget_failures,
    named_after,
    require_room,
)
from sweeps.engine.signals import Stop, listening
from sweeps.exits import Exit, ExpectedError
from sweeps.files.atomic import StorageError, fingerprint, refuse_odd_output
from sweeps.files.journal import DamagedRecordError, Journal, readable_manifest
from sweeps.files.results import Written
from sweeps.files.run_folder import RunFolder
from sweeps.human import counted


class LostPointsError(ExpectedError, RuntimeError):
    """Points that were handed out and never came back."""

    code = Exit.STOPPED


_RECOVERIES = 3  # times that a journal may be damaged while it is in use


def sweep(
    config: Config,
    output: Path,
    *,
    console: Console,
    policy: ExistingPolicy = ExistingPolicy(),  # noqa: B008 - immutable
    stop: Stop | None = None,
    partial: bool = False,
    keep_journal: bool = False,
    part: Part | None = None,
) -> Outcome:
    """Compute the points of a config that are not there yet, and write the result.

    Finished blocks are kept in `<output>.run/` until the result is complete; the same call resumes
    a sweep that ended early, for whatever reason. A finished result gets the points that a grown
    config adds.

    `stop` ends the sweep early, as signals do. `partial` computes nothing and writes what is there,
    the rest with the status `pending`. `keep_journal` leaves the journal beside a complete result.
    `part` computes part of the points; the others stay `pending` where they are not there already.

    Raises RefusalError if a refined grid is to be computed in parts, or where what is there does
    not fit and no option decides, InUseError where another run holds the output, StorageError, and
    ExecutorError where the workers cannot be had or were lost; what is finished is kept.
    """
    refuse_odd_output(output)
    target, folder, stop = Target.of(config, part), RunFolder(output), stop or Stop()
    with folder.held(), listening(stop), named_after(output):
        folder.discard_leftovers()
        before = fingerprint(folder.output)
        if partial:
            return _export(target, folder, policy)
        decision = decide(target, folder, policy)
        if decision.complete is not None:
            ended = _ended(target, output, decision.complete, missing=0)
            console.say(f"{output} is complete: {counted(ended.points, 'point')}, nothing to do")
            return ended
        with closing(decision.begin()) as journal:
            result = JournaledResult(target, journal, folder, before)
            needed = target.needed | journal.done  # points of other parts are kept
            counts = Counts(int(np.count_nonzero(needed)), journal)
            recorder = Recorder(journal, folder, counts, console, stop)
            _announce(decision, journal, counts, console)
            require_room(folder, counts.left, counts.total)
            result.try_writing()
            for _ in range(_RECOVERIES):
                if counts.left:
                    recorder.compute(target, needed)
                if counts.left:
                    return _stopped(result, recorder, counts, stop)
                try:
                    return _finished(result, recorder, keep_journal=keep_journal)
                except DamagedRecordError:
                    _recover(journal, target, console)
            raise StorageError(
                f"{folder.journal} is damaged again and again while it is in use; the disk or "
                "another program changes it. Write elsewhere with -o"
            )


def _recover(journal: Journal, target: Target, console: Console) -> None:
    """Count what was damaged in the journal since it was opened as not computed."""
    lost = journal.recover()
    forget_failures(journal, target)
    console.say(
        f"warning: {journal.path} was damaged during the sweep; {counted(lost, 'point')} to "
        "compute again"
    )


def _announce(decision: Decision, journal: Journal, counts: Counts, console: Console) -> None:
    """Say what exists already and what is to be computed."""
    for warning in decision.warnings(journal):
        console.say(f"warning: {warning}")
    target = decision.target
    shape = target.grid.shape
    product = f" ({' x '.join(map(str, shape))})" if len(shape) > 1 else ""
    found = f": {there}" if (there := decision.found(journal)) else ""
    part = f"part {target.part}, " if target.part else ""
    points = counted(target.grid.size, "point")
    points = f"{counts.total} of {points}" if target.part else points
    console.say(f"{part}{points}{product}{found}; {counts.left} to compute")


def _finished(result: JournaledResult, recorder: Recorder, *, keep_journal: bool) -> Outcome:
    written, journal = result.write(), result.journal
    if keep_journal:
        journal.note(journal.manifest | {"finished": True})
    result.folder.remove(keep_journal=keep_journal)
    ended = _ended(result.target, result.folder.output, written, missing=0)
    return recorder.outcome(ended)


def _ended(target: Target, output: Path, written: Written, missing: int) -> Outcome:
    """Return how a sweep ended that lacks so many of the points that are asked for."""
    statuses = written.statuses.copy()
    statuses[Status.PENDING] = missing
    return Outcome(
        output,
        statuses,
        written.worst_error,
        part=target.part,
        statistical_error=written.statistical_error,
    )


def _stopped(result: JournaledResult, recorder: Recorder, counts: Counts, stop: Stop) -> Outcome:
    if not stop.reason:
        raise LostPointsError(
            f"{counts.left} of {counts.total} points did not come back from the workers; "
            "what did is kept. Give the same command again"
        )
    kept = Written(result.journal.statuses, math.nan)
    ended = _ended(result.target, result.folder.output, kept, missing=counts.left)
    return recorder.outcome(replace(ended, stopped=stop.code, reason=stop.reason))


def _export(target: Target, folder: RunFolder, policy: ExistingPolicy) -> Outcome:
    """Write what is there, and leave the journal for the rest."""
    _refuse_partial(folder, policy)
    policy = replace(policy, overwrite=False, retry_failed=False)
    before = fingerprint(folder.output)
    with closing(decide(target, folder, policy).begin()) as journal:
        written = JournaledResult(target, journal, folder, before).write()
        missing = int(np.count_nonzero(target.needed & ~journal.done))
        if not missing:
            folder.remove()
    return _ended(target, folder.output, written, missing)


def _refuse_partial(folder: RunFolder, policy: ExistingPolicy) -> None:
    """Raise RefusalError if an export would write nothing, or less than there is."""
    output, manifest = folder.output, readable_manifest(folder.journal)
    if manifest is None and not output.exists():
        raise RefusalError(f"nothing is there yet of {output}; leave out --partial to compute it")
    if manifest and manifest["afresh"] and output.exists() and not policy.overwrite:
        raise RefusalError(
            f"{output} would lose its points to an unfinished sweep that started from scratch; "
            "--overwrite does so, or finish the sweep first"
        )
