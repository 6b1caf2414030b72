"""A sweep on disk: finished work is kept, and the same command always goes on from there."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.status import Status
from sweeps.config.load import Config
from sweeps.config.schema import Execution
from sweeps.engine.blocks import PILOT_BLOCKS, pilot_points
from sweeps.engine.cost import Costs
from sweeps.engine.dispatch import finished_blocks
from sweeps.engine.executors.base import Executor
from sweeps.engine.executors.choose import make_executor
from sweeps.engine.existing import RefusalError, Target, readable_manifest
from sweeps.engine.options import options_of
from sweeps.engine.outcome import Console, Outcome, size_text
from sweeps.engine.progress import Progress, Tally, make_progress
from sweeps.engine.resume import (
    ExistingPolicy,
    PreparedJournal,
    complete_already,
    prepare_journal,
)
from sweeps.engine.signals import Stop, listening, wait_for
from sweeps.engine.worker import Block, compile_kernels
from sweeps.files.atomic import StorageError, refuse_odd_output
from sweeps.files.attributes import global_attributes
from sweeps.files.journal import BYTES_PER_POINT, Journal
from sweeps.files.results import Written, try_writing, write_result
from sweeps.files.run_folder import RunFolder
from sweeps.identity import seal_key

# A float a result variable, less what compression gains.
RESULT_BYTES_PER_POINT = 90

# From so many points on, the first blocks are a pilot that tells the cost of the rest.
_PILOT_FROM = 20_000

_BLOCKS_TO_JUDGE = 3  # ... and of a small sweep so many

_TELL_ABOVE, _ASK_ABOVE = 10.0, 3600.0  # seconds that are left


@dataclass
class _Sweep:
    """A sweep that holds its output: everything between the lock and the result."""

    target: Target
    output: Path
    folder: RunFolder
    stop: Stop
    console: Console
    execution: Execution
    prepared: PreparedJournal
    tally: Tally
    doubts: np.ndarray = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    costs: Costs = field(default_factory=Costs)

    @property
    def journal(self) -> Journal:
        return self.prepared.journal

    # --- before ---

    def prove_writable(self) -> None:
        """Raise StorageError now rather than after the computation."""
        missing = self.tally.left
        needed = missing * BYTES_PER_POINT + self.tally.total * RESULT_BYTES_PER_POINT
        free = shutil.disk_usage(self.folder.path).free
        if free < needed:
            raise StorageError(
                f"{self.folder.path.parent} has {size_text(free)} left, but the sweep may need "
                f"{size_text(needed)}; make room, or write elsewhere with -o"
            )
        attributes = self.attributes()
        try_writing(self.target.grid, self.target.chunks, attributes, self.folder.result)

    def announce(self) -> None:
        """Say what is found and what is to be done."""
        for warning in self.prepared.warnings:
            self.console.say(f"warning: {warning}")
        shape = self.target.grid.shape
        product = f" ({' x '.join(map(str, shape))})" if len(shape) > 1 else ""
        found = f": {', '.join(self.prepared.found)}" if self.prepared.found else ""
        self.console.say(f"{self.tally.total} points{product}{found}; {self.tally.left} to compute")

    # --- computing ---

    def compute(self) -> None:
        """Compute what is missing, until it is done or a stop is requested."""
        options = options_of(self.target.config)
        remote = self.execution.backend == "dask" and self.execution.scheduler
        if not remote and not wait_for(
            lambda: compile_kernels(options, self.target.grid), self.stop
        ):
            return
        large = self.tally.left >= _PILOT_FROM
        pilot = pilot_points(self.tally.left) if large else 0
        with ExitStack() as stack:
            executor = stack.enter_context(make_executor(self.execution))
            progress = stack.enter_context(make_progress(self.tally, wanted=self.console.progress))
            self.stop.at_once += [executor.kill, progress.stop]
            self.tally.begin()
            stack.enter_context(self.folder.beating(lambda: self.beat(executor)))
            blocks = finished_blocks(
                self.target.grid,
                options,
                self.journal.done,
                executor,
                self.stop,
                block_points=self.execution.block_points,
                pilot=pilot,
            )
            try:
                self._record(blocks, executor, progress, pilot)
            except StorageError:
                self.stop.request("the journal could not be written")
                for _ in blocks:  # what is in flight cannot be kept any more
                    pass
                raise

    def _record(
        self, blocks: Iterator[Block], executor: Executor, progress: Progress, pilot: int
    ) -> None:
        for number, block in enumerate(blocks):
            self._keep(block)
            self.costs.learn(len(block.indices), block.seconds)
            self.doubts += block.doubts
            for message in block.messages:
                self.console.say(f"warning: {message}")
            self.tally.advance(len(block.indices))
            progress.refresh()
            if number == 0:
                self._stop_if_all_fail(block)
            if self.costs.blocks == (PILOT_BLOCKS if pilot else _BLOCKS_TO_JUDGE):
                self._estimate(executor, progress)

        self._keep(None)

    def _keep(self, block: Block | None) -> None:
        """Journal a block; in the end, have all of them on the disk."""
        try:
            if block is None:
                self.journal.flush()
            else:
                self._meet(block)
                self.journal.append(block.indices, block.results)
        except OSError as error:
            raise StorageError(self._not_written(error)) from error

    def _meet(self, block: Block) -> None:
        """Take note of a kind of processor that has not computed anything of this sweep yet."""
        manifest = self.journal.manifest or {}
        known = list(manifest.get("processors", []))
        if not block.processor or block.processor in known:
            return
        self.journal.note(manifest | {"processors": sorted([*known, block.processor])})
        if known:
            self.console.say(
                f"warning: a {block.processor} processor joins points computed on "
                f"{', '.join(known)}: the last digits may differ between them"
            )

    def _stop_if_all_fail(self, block: Block) -> None:
        alone = self.tally.found == 0 and self.tally.left > 0
        if alone and block.failures == len(block.indices):
            self.stop.request(
                f"all {block.failures} points of the first block failed; if that is meant, the "
                "same command goes on",
                code=3,
            )

    def _estimate(self, executor: Executor, progress: Progress) -> None:
        estimate = self.costs.estimate(self.tally.left, executor.slots)
        if estimate.seconds < _TELL_ABOVE:
            return
        progress.say(f"time left: {estimate}")
        if estimate.seconds > _ASK_ABOVE and self.console.confirm is not None:
            progress.pause()
            if not self.console.confirm("Go on?"):
                self.stop.request("not wanted to go on")
            progress.resume()

    # --- after ---

    def write(self, path: Path) -> Written:
        """The result file from the journal."""
        return write_result(
            self.target.grid,
            seal_key(self.target.settings, self.target.grid),
            self.target.chunks,
            self.journal.chunk,
            self.attributes(),
            self.folder.result,
            path,
        )

    def attributes(self) -> dict[str, str]:
        """The global attributes of the result."""
        manifest, attributes = self.journal.manifest or {}, global_attributes(self.target.config)
        earlier = manifest.get("history", "")
        if earlier:
            attributes["history"] += "\n" + earlier
        if manifest.get("processors"):
            attributes["processor"] = ", ".join(manifest["processors"])
        if manifest.get("mixed"):
            attributes["mixed_with"] = "\n".join(manifest["mixed"])
        return attributes

    def outcome(self, statuses: np.ndarray, worst: float, **ended: Any) -> Outcome:
        """What this run did."""
        return Outcome(
            self.output,
            statuses,
            worst,
            computed=self.tally.computed,
            seconds=self.tally.seconds,
            kernel_seconds=self.costs.seconds,
            doubts=(int(self.doubts[0]), int(self.doubts[1])),
            **ended,
        )

    def stopped(self) -> Outcome:
        """The outcome of a sweep that ended early."""
        statuses = self.journal.statuses.copy()
        statuses[Status.PENDING] = self.tally.left
        return self.outcome(statuses, np.nan, stopped=self.stop.code, reason=self.stop.reason)

    def beat(self, executor: Executor) -> dict[str, Any]:
        """What the heartbeat says."""
        state = "stopping" if self.stop.reason else "running"
        return self.tally.as_dict() | {
            "state": state,
            "backend": self.execution.backend,
            "slots": executor.slots,
        }

    def _not_written(self, error: OSError) -> str:
        return (
            f"cannot write {self.folder.journal}: {error.strerror or error}. "
            f"{self.tally.done} of {self.tally.total} points are kept there; make room and give "
            "the same command again"
        )


def sweep(
    config: Config,
    output: Path,
    *,
    console: Console,
    execution: Execution | None = None,
    policy: ExistingPolicy = ExistingPolicy(),  # noqa: B008 - immutable
    stop: Stop | None = None,
    partial: bool = False,
    keep_journal: bool = False,
) -> Outcome:
    """Compute the points of a config that are not there yet, and write the result.

    Finished blocks are kept in `<output>.run/` until the result is complete; a sweep that ends
    early, for whatever reason, goes on from there. A finished result gets the points that a grown
    config adds.

    Parameters
    ----------
    config
        What to compute.
    output
        The result file.
    console
        Where to speak, and whom to ask.
    execution
        Workers and backend; by default those of the config.
    policy
        What to do with results that are there and do not fit.
    stop
        Ends the sweep early; signals request it too.
    partial
        Compute nothing: write what is there, the rest with the status `pending`.
    keep_journal
        Leave the journal beside the complete result.

    Raises
    ------
    RefusalError
        What is there does not fit, and no option decides.
    InUseError
        Another run holds the output.
    StorageError
        Something cannot be read or written; what is finished is kept.
    ExecutorError
        The workers cannot be had, or were lost; what is finished is kept.
    """
    refuse_odd_output(output)
    target, folder = Target.of(config), RunFolder(output)
    stop = stop or Stop()
    with folder.held(), listening(stop), _named_after(output):
        folder.discard_leftovers()
        complete = None if partial else complete_already(target, output, folder, policy)
        if complete is not None:
            console.say(
                f"{output} is complete: {int(complete.statuses.sum())} points, nothing to do"
            )
            return Outcome(output, complete.statuses, complete.worst_error)
        if partial:
            _refuse_partial(output, folder, policy)
            policy = replace(policy, overwrite=False, recompute=False)
        prepared = prepare_journal(target, output, folder, policy)
        try:
            run = _Sweep(
                target,
                output,
                folder,
                stop,
                console,
                execution or config.execution,
                prepared,
                Tally(target.grid.size, prepared.journal.statuses),
            )
            return _export(run) if partial else _finish(run, keep_journal)
        finally:
            prepared.journal.close()


@contextlib.contextmanager
def _named_after(output: Path) -> Iterator[None]:
    """Errors of the files beside an output, with its name."""
    try:
        yield
    except StorageError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise StorageError(
            f"cannot read or write what belongs to {output}: {reason}; what is finished is kept"
        ) from error


def _finish(run: _Sweep, keep_journal: bool) -> Outcome:
    run.announce()
    run.prove_writable()
    if run.tally.left:
        run.compute()
    if run.tally.left:
        if not run.stop.reason:
            raise RuntimeError(f"{run.tally.left} points did not come back from the workers")
        return run.stopped()
    written = run.write(run.output)
    if keep_journal:
        run.journal.note((run.journal.manifest or {}) | {"finished": True})
    run.folder.remove(keep_journal=keep_journal)
    return run.outcome(written.statuses, written.worst_error)


def _refuse_partial(output: Path, folder: RunFolder, policy: ExistingPolicy) -> None:
    """Raise RefusalError where an export would write nothing, or less than there is."""
    manifest = readable_manifest(folder.journal)
    if manifest is None and not output.exists():
        raise RefusalError(f"nothing is there yet of {output}; leave out --partial to compute it")
    if manifest and manifest["afresh"] and output.exists() and not policy.overwrite:
        raise RefusalError(
            f"{output} would lose its points to an unfinished sweep that was begun afresh; "
            "--overwrite does so, or finish the sweep first"
        )


def _export(run: _Sweep) -> Outcome:
    """Write what is there, and leave the journal for the rest."""
    written = run.write(run.output)
    if not run.tally.left:
        run.folder.remove()
    return run.outcome(written.statuses, written.worst_error)
