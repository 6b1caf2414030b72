"""A sweep on disk: finished points are kept, and the same command always resumes the sweep."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.task import Block
from stickslip.status import Status
from sweeps.config.load import Config
from sweeps.engine.computing import compile_first, missing_blocks
from sweeps.engine.executors import make_executor
from sweeps.engine.existing import Part, RefusalError, Target
from sweeps.engine.progress import Counts, display_of, stop_text
from sweeps.engine.refine import interpolate
from sweeps.engine.resume import (
    Decision,
    ExistingPolicy,
    decide,
    forget_failures,
    named_after,
    require_room,
)
from sweeps.engine.signals import Stop, listening
from sweeps.exits import Exit, ExpectedError, StorageError
from sweeps.files.atomic import fingerprint, refuse_odd_output
from sweeps.files.attributes import breaks_of, global_attributes
from sweeps.files.journal import DamagedRecordError, Journal, readable_manifest
from sweeps.files.result_rows import STATUS, failures, status_counts
from sweeps.files.run_folder import RunFolder
from sweeps.files.sweep_file import Written, try_writing, write_result
from sweeps.human import counted, reason


class LostPointsError(ExpectedError, RuntimeError):
    """Workers were given points that never came back."""

    code = Exit.STOPPED


_RECOVERIES = 3  # how often a journal may be damaged while it is in use


@dataclass(frozen=True)
class Outcome:
    """The outcome of a sweep, or of a part of one.

    `statuses` (128,) counts the points of each status, `computed` the points that this run added;
    `worst_error` and `statistical_error` are those of `Written`. `workers` counts those at the
    end of the run. `suspicious` counts the points whose power balance, and those whose stress,
    looks wrong without being impossible. If the sweep ended early, `stopped` is the exit code, and
    `reason` says why. A merged result is `complete` if it existed already.
    """

    output: Path
    statuses: np.ndarray
    worst_error: float
    computed: int = 0
    seconds: float = 0.0
    kernel_seconds: float = 0.0
    workers: int = 0
    suspicious: tuple[int, int] = (0, 0)
    stopped: Exit | None = None
    reason: str = ""
    part: Part | None = None
    statistical_error: float = math.nan
    complete: bool = False

    @property
    def points(self) -> int:
        """The number of points of the sweep."""
        return int(self.statuses.sum())

    @property
    def failures(self) -> int:
        """The number of finished points without a result."""
        return failures(self.statuses)


def sweep(
    config: Config,
    output: Path,
    *,
    say: Callable[[str], None],
    progress: bool = True,
    policy: ExistingPolicy = ExistingPolicy(),  # noqa: B008 - immutable
    stop: Stop | None = None,
    partial: bool = False,
    keep_journal: bool = False,
    part: Part | None = None,
) -> Outcome:
    """Compute the missing points of a config, and write the result.

    Finished blocks are kept in `<output>.run/` until the result is complete; the same call resumes
    a sweep that ended early, for whatever reason. A grown config adds its new points to a finished
    result.

    `say` prints a line; `progress` shows how far the sweep is. `stop` ends it early, as signals do.
    `partial` computes nothing and writes the existing points, the others with the status `pending`.
    `keep_journal` leaves the journal beside a complete result. `part` computes part of the points;
    the others stay `pending` unless they exist already.

    Raises RefusalError for parts of a refined grid, and if existing results do not fit and no
    option says what to do; InUseError if another run holds the output; StorageError; ExecutorError
    if the workers are not available or are lost. Finished points are kept.
    """
    refuse_odd_output(output)
    target, folder, stop = Target.of(config, part), RunFolder(output), stop or Stop()
    with folder.held(), listening(stop), named_after(output):
        folder.discard_leftovers()
        before = fingerprint(folder.output)
        if partial:
            return _export(target, folder, policy, before, say, keep_journal=keep_journal)
        decision = decide(target, folder, policy)
        if decision.complete is not None:
            return _complete(target, output, decision.complete, say)
        with closing(decision.begin()) as journal:
            result = JournaledResult(target, journal, folder, before)
            interpolate(target.config, target.grid, journal)  # which needs no workers
            needed = target.needed | journal.done  # points of other parts are kept
            counts = Counts(int(np.count_nonzero(needed)), journal)
            recorder = Recorder(result, counts, stop, say, progress=progress)
            for line in _announcement(decision, journal, counts):
                say(line)
            require_room(folder, counts.left, counts.total)
            result.try_writing()
            for _ in range(_RECOVERIES):
                try:
                    if counts.left:
                        recorder.compute(needed)
                    if counts.left:
                        return _stopped(recorder, counts, stop)
                    written = result.write()
                except DamagedRecordError:
                    # Points damaged since the journal was opened count as not computed.
                    lost = counted(journal.recover(), "point")
                    forget_failures(journal, target)
                    say(
                        f"warning: {journal.path} was damaged during the sweep; {lost} to compute "
                        "again"
                    )
                else:
                    _finish(journal, folder, keep_journal=keep_journal)
                    return recorder.outcome(written)
            raise StorageError(
                f"{folder.journal} keeps being damaged while it is in use, by the disk or by "
                "another program; write elsewhere with -o"
            )


def _announcement(decision: Decision, journal: Journal, counts: Counts) -> Iterator[str]:
    """Yield warnings about existing points, and a line of what exists and what is missing."""
    for warning in decision.warnings(journal):
        yield f"warning: {warning}"
    target = decision.target
    shape = target.grid.shape
    product = f" ({' x '.join(map(str, shape))})" if len(shape) > 1 else ""
    found = f": {there}" if (there := decision.found(journal)) else ""
    part = f"part {target.part}, " if target.part else ""
    points = counted(target.grid.size, "point")
    points = f"{counts.total} of {points}" if target.part else points
    yield f"{part}{points}{product}{found}; {counts.left} to compute"


def _stopped(recorder: Recorder, counts: Counts, stop: Stop) -> Outcome:
    if not stop.reason:
        raise LostPointsError(
            f"{counts.left} of {counts.total} points did not come back from the workers; "
            "the others are kept; run the same command again"
        )
    kept = Written(recorder.journal.statuses, math.nan)
    return recorder.outcome(kept, stopped=stop.code, reason=stop.reason)


def _finish(journal: Journal, folder: RunFolder, *, keep_journal: bool) -> None:
    """Remove the files of a complete sweep; if the journal is kept, note in it that it is over."""
    if keep_journal:
        # Not `afresh`, so that the next sweep reads the output before it replaces it.
        journal.note(journal.manifest | {"finished": True, "afresh": False})
    folder.remove(keep_journal=keep_journal)


def _complete(
    target: Target, output: Path, complete: Written, say: Callable[[str], None]
) -> Outcome:
    ended = _ended(target, output, complete, missing=0)
    say(f"{output} is complete: {counted(ended.points, 'point')}, nothing to do")
    return ended


def _ended(target: Target, output: Path, written: Written, missing: int) -> Outcome:
    """Return how a sweep ended; `missing` counts the points of the target that are not finished."""
    statuses = written.statuses.copy()
    statuses[Status.PENDING] = missing
    return Outcome(
        output,
        statuses,
        written.worst_error,
        part=target.part,
        statistical_error=written.statistical_error,
    )


def _export(
    target: Target,
    folder: RunFolder,
    policy: ExistingPolicy,
    before: list[int] | None,
    say: Callable[[str], None],
    *,
    keep_journal: bool,
) -> Outcome:
    """Write the finished points; leave the journal if points are missing or `keep_journal` is true.

    Points that an interrupted retry has yet to compute again are written as they were.

    Raises RefusalError if there are none, or if the output would lose points.
    """
    output, manifest = folder.output, readable_manifest(folder.journal)
    if manifest is None and not output.exists():
        raise RefusalError(f"{output} has no points yet; leave out --partial to compute them")
    if manifest and manifest["afresh"] and output.exists() and not policy.overwrite:
        raise RefusalError(
            f"{output} would be replaced by an unfinished sweep that started from scratch; finish "
            "that sweep first, or replace it now with --overwrite"
        )
    decision = decide(target, folder, ExistingPolicy())
    if decision.complete is not None:
        return _complete(target, output, decision.complete, say)
    with closing(decision.begin(with_failures=True)) as journal:
        for warning in decision.warnings(journal):
            say(f"warning: {warning}")
        interpolate(target.config, target.grid, journal)
        written = JournaledResult(target, journal, folder, before).write()
        missing = int(np.count_nonzero(target.needed & ~journal.done))
        forget_failures(journal, target)
        if not np.any(target.needed & ~journal.done):
            _finish(journal, folder, keep_journal=keep_journal)
        else:  # the output has no points that the journal lacks
            journal.note(journal.manifest | {"output": fingerprint(output)})
    return _ended(target, output, written, missing)


@dataclass(frozen=True)
class JournaledResult:
    """A result file made from a journal; its methods raise StorageError.

    `before` is the fingerprint of the output when the sweep began.
    """

    target: Target
    journal: Journal
    folder: RunFolder
    before: list[int] | None

    def try_writing(self) -> None:
        """Write it without numbers, and remove it, so that errors come before the sweep."""
        target = self.target
        try_writing(target.grid, target.chunks, self.attributes(), self.folder.result)

    def write(self, path: Path | None = None) -> Written:
        """Write the points of the journal, the rest as `pending`, to the output or to `path`.

        An output that has changed since the sweep began is not replaced.
        """
        output = path or self.folder.output
        if path is None and fingerprint(output) != self.before:
            raise StorageError(
                f"{output} was created or changed by something else during the sweep, and is left "
                f"alone; finished points are kept in {self.folder.path}. Move {output.name} away "
                "and run the same command again, or choose another -o"
            )
        statuses = self.journal.statuses.copy()
        statuses[Status.PENDING] = self.target.grid.size - statuses.sum()
        return write_result(
            self.target.grid,
            self.target.chunks,
            self.journal.chunk,
            statuses,
            self.attributes(),
            self.folder.result,
            output,
        )

    def attributes(self) -> dict[str, str]:
        """Return the global attributes."""
        manifest = self.journal.manifest
        config = self.target.config
        attributes = global_attributes(config) | breaks_of(config, self.journal.statuses)
        if earlier := manifest.get("history"):
            attributes["history"] += "\n" + earlier
        if sample := manifest.get("sample"):
            attributes["sample"] = sample
        if manifest.get("processors"):
            attributes["processor"] = ", ".join(manifest["processors"])
        if self.target.part and np.array_equal(self.journal.done, self.target.needed):
            attributes["part"] = str(self.target.part)
        return attributes


class Recorder:
    """Computes the points that a journal lacks, and records the finished blocks."""

    def __init__(
        self,
        result: JournaledResult,
        counts: Counts,
        stop: Stop,
        say: Callable[[str], None],
        *,
        progress: bool,
    ) -> None:
        self._suspicious = np.zeros(2, dtype=np.int64)
        self._target, self.journal, self._folder = result.target, result.journal, result.folder
        self._counts, self._stop, self._say, self._progress = counts, stop, say, progress

    def compute(self, needed: NDArray[np.bool_]) -> None:
        """Compute the needed points (size,) that the journal lacks, unless stopped.

        Raises StorageError if the journal cannot be written, DamagedRecordError if a round of a
        refined grid finds it damaged, ExecutorError.
        """
        config, grid = self._target.config, self._target.grid
        counts, stop = self._counts, self._stop
        if not compile_first(config, grid, stop, wanted=self._progress):
            return
        with ExitStack() as stack:
            executor = stack.enter_context(make_executor(config.execution))
            display = stack.enter_context(display_of(counts, wanted=self._progress))
            stop.at_once += [executor.kill, display.stop]
            stop.at_a_stop = lambda: stop_text(counts.in_flight)
            counts.begin(lambda: executor.slots, stop)
            stack.enter_context(self._folder.beating(self._beat))
            journal = self.journal
            self._record(missing_blocks(config, grid, needed, journal, executor, counts, stop))

    def outcome(self, written: Written, **ending: Any) -> Outcome:
        """Return how the sweep ended, with the numbers of this run."""
        return replace(
            _ended(self._target, self._folder.output, written, missing=self._counts.left),
            computed=self._counts.computed,
            seconds=self._counts.seconds,
            kernel_seconds=self._counts.costs.seconds,
            workers=self._counts.slots,
            suspicious=(int(self._suspicious[0]), int(self._suspicious[1])),
            **ending,
        )

    def _beat(self) -> dict[str, object]:
        """Return the contents of the heartbeat."""
        state = "stopping" if self._stop.reason else "running"
        backend, part = self._target.config.execution.backend, self._target.part
        named = {"part": str(part)} if part else {}
        return self._counts.as_dict() | named | {"state": state, "backend": backend}

    def _record(self, blocks: Iterator[Block]) -> None:
        try:
            for number, block in enumerate(blocks, start=1):
                self.take_in(block)
                if number == 1:
                    self._stop_if_all_fail(block)
            with self._journaling():
                self.journal.flush()
        except DamagedRecordError:  # found between two rounds, when no block is in flight
            raise
        except StorageError:
            self._stop.request("the journal could not be written")
            for _ in blocks:  # blocks in flight can no longer be kept
                pass
            raise

    def take_in(self, block: Block) -> None:
        """Write the points of a block to the journal, and pass on its messages."""
        with self._journaling():
            self._note_processor(block.processor)
            self.journal.append(block.indices, block.results)
        self._suspicious += block.suspicious
        for message in block.messages:
            self._say(f"warning: {message}")

    @contextlib.contextmanager
    def _journaling(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise StorageError(
                f"cannot write {self._folder.journal}: {reason(error)}. "
                f"{self._counts.done} of {self._counts.total} points are kept there; make room "
                "and run the same command again"
            ) from error

    def _note_processor(self, processor: str) -> None:
        """Note a type of processor that is new to this sweep."""
        manifest = self.journal.manifest
        known = list(manifest.get("processors", []))
        if not processor or processor in known:
            return
        self.journal.note(manifest | {"processors": sorted([*known, processor])})
        if known:
            self._say(
                f"warning: some points were computed on {', '.join(known)}, others are "
                f"computed on {processor}: the last digits may differ between them"
            )

    def _stop_if_all_fail(self, first: Block) -> None:
        alone = self._counts.done == self._counts.computed and self._counts.left > 0
        failed = failures(status_counts(first.results[:, STATUS]))
        if alone and failed == len(first.indices):
            self._stop.request(
                f"all of the first block failed ({counted(failed, 'point')}); if that is "
                "expected, run the same command to resume",
                code=Exit.FAILED_POINTS,
            )
