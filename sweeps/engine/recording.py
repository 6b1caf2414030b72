"""The handling of finished blocks: journal them, count them, and stop early."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.task import Block
from sweeps.config.schema import Execution
from sweeps.engine.computing import compiled, missing_blocks
from sweeps.engine.counts import Counts, stop_text
from sweeps.engine.executors import make_executor
from sweeps.engine.existing import Target
from sweeps.engine.outcome import Console, Outcome
from sweeps.engine.progress import display_of
from sweeps.engine.signals import Stop
from sweeps.exits import Exit
from sweeps.files.atomic import StorageError
from sweeps.files.columns import STATUS, failures, status_counts
from sweeps.files.journal import Journal
from sweeps.files.run_folder import RunFolder
from sweeps.human import counted, reason


class Recorder:
    """Computes what a journal lacks, and takes in the blocks as they are finished."""

    def __init__(
        self, journal: Journal, folder: RunFolder, counts: Counts, console: Console, stop: Stop
    ) -> None:
        self._suspicious = np.zeros(2, dtype=np.int64)
        self._journal, self._folder, self._counts = journal, folder, counts
        self._console, self._stop = console, stop

    def compute(self, target: Target, needed: NDArray[np.bool_]) -> None:
        """Compute what the journal lacks of the points (size,) that are needed, unless stopped.

        Raises StorageError if the journal cannot be written, ExecutorError.
        """
        config, counts, stop = target.config, self._counts, self._stop
        if not compiled(config, target.grid, stop, wanted=self._console.progress):
            return
        with ExitStack() as stack:
            executor = stack.enter_context(make_executor(config.execution))
            display = stack.enter_context(display_of(counts, wanted=self._console.progress))
            stop.at_once += [executor.kill, display.stop]
            stop.at_a_stop = lambda: stop_text(counts.in_flight)
            counts.begin(lambda: executor.slots, stop)
            stack.enter_context(self._folder.beating(lambda: self._beat(config.execution)))
            blocks = missing_blocks(
                config, target.grid, needed, self._journal, executor, counts, stop
            )
            self._record(blocks)

    def outcome(self, ended: Outcome) -> Outcome:
        """Return how the sweep ended, with what this run has done."""
        return replace(
            ended,
            computed=self._counts.computed,
            seconds=self._counts.seconds,
            kernel_seconds=self._counts.costs.seconds,
            suspicious=(int(self._suspicious[0]), int(self._suspicious[1])),
        )

    def _beat(self, execution: Execution) -> dict[str, object]:
        """Return what the heartbeat says."""
        state = "stopping" if self._stop.reason else "running"
        return self._counts.as_dict() | {"state": state, "backend": execution.backend}

    def _record(self, blocks: Iterator[Block]) -> None:
        try:
            for number, block in enumerate(blocks, start=1):
                self._take_in(block)
                if number == 1:
                    self._stop_if_all_fail(block)
            with self._journaling():
                self._journal.flush()
        except StorageError:
            self._stop.request("the journal could not be written")
            for _ in blocks:  # what is in flight cannot be kept any more
                pass
            raise

    def _take_in(self, block: Block) -> None:
        with self._journaling():
            self._note_processor(block.processor)
            self._journal.append(block.indices, block.results)
        self._suspicious += block.suspicious
        for message in block.messages:
            self._console.say(f"warning: {message}")

    @contextlib.contextmanager
    def _journaling(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise StorageError(
                f"cannot write {self._folder.journal}: {reason(error)}. "
                f"{self._counts.done} of {self._counts.total} points are kept there; make room "
                "and give the same command again"
            ) from error

    def _note_processor(self, processor: str) -> None:
        """Note a kind of processor that has not computed anything of this sweep before."""
        manifest = self._journal.manifest
        known = list(manifest.get("processors", []))
        if not processor or processor in known:
            return
        self._journal.note(manifest | {"processors": sorted([*known, processor])})
        if known:
            self._console.say(
                f"warning: a {processor} processor joins points computed on "
                f"{', '.join(known)}: the last digits may differ between them"
            )

    def _stop_if_all_fail(self, first: Block) -> None:
        alone = self._counts.done == self._counts.computed and self._counts.left > 0
        failed = failures(status_counts(first.results[:, STATUS]))
        if alone and failed == len(first.indices):
            self._stop.request(
                f"all of the first block failed ({counted(failed, 'point')}); if that is "
                "meant, the same command resumes",
                code=Exit.FAILED_POINTS,
            )
