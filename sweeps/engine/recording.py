"""What a sweep does with its finished blocks: journal them, count them, and stop early."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.options import Options
from sweeps.config.schema import Execution
from sweeps.engine.dispatch import finished_blocks
from sweeps.engine.executors.base import Executor
from sweeps.engine.executors.choose import make_executor
from sweeps.engine.executors.kernels import compile_kernels
from sweeps.engine.executors.worker import Block
from sweeps.engine.existing import Target
from sweeps.engine.order.product import PILOT_BLOCKS, pilot_points
from sweeps.engine.order.refine import Refinement, refinement_of
from sweeps.engine.outcome import Console, Outcome
from sweeps.engine.progress.compiling import Compiling
from sweeps.engine.progress.counts import Counts
from sweeps.engine.progress.display import Progress, make_progress
from sweeps.engine.settings import options_of
from sweeps.engine.signals import Stop, wait_for
from sweeps.exits import Exit
from sweeps.files.atomic import StorageError
from sweeps.files.journal import Journal
from sweeps.files.run_folder import RunFolder
from sweeps.grid import Grid
from sweeps.human import duration, reason

# From so many points on, the first blocks are a pilot that tells the cost of the rest.
_PILOT_FROM = 20_000

_BLOCKS_TO_JUDGE = 3  # ... and of a small sweep so many

_TELL_ABOVE, _ASK_ABOVE = 10.0, 3600.0  # seconds that are left


class Recorder:
    """Computes what a journal lacks, and takes in the blocks as they are finished."""

    def __init__(
        self, journal: Journal, folder: RunFolder, counts: Counts, console: Console, stop: Stop
    ) -> None:
        self._suspicious = np.zeros(2, dtype=np.int64)
        self._journal, self._folder, self._counts = journal, folder, counts
        self._console, self._stop = console, stop

    def compute(self, target: Target, asked: NDArray[np.bool_]) -> None:
        """Compute what the journal lacks of the points (size,) that are asked for, unless stopped.

        Raises StorageError where the journal cannot be written, ExecutorError.
        """
        options, execution = options_of(target.config), target.config.execution
        remote = execution.backend == "dask" and execution.scheduler
        if not remote and not self._compiled(options, target.grid):
            return
        refinement = refinement_of(target.config.refine, target.grid)
        rounds = refinement.rounds(self._rows) if refinement else [asked]
        with ExitStack() as stack:
            executor = stack.enter_context(make_executor(execution))
            progress = stack.enter_context(
                make_progress(self._counts, wanted=self._console.progress)
            )
            self._stop.at_once += [executor.kill, progress.stop]
            self._stop.in_flight = self._counts.in_flight.__str__
            self._counts.begin(lambda: executor.slots, self._stop)
            stack.enter_context(self._folder.beating(lambda: self._beat(execution)))
            for needed in rounds:
                self._compute_round(target, options, needed, executor, progress)
        if refinement and not self._stop.requested:
            self._fill_in(refinement)

    def _compute_round(
        self,
        target: Target,
        options: Options,
        needed: NDArray[np.bool_],
        executor: Executor,
        progress: Progress,
    ) -> None:
        """Compute what the journal lacks of the points (size,) that are needed."""
        done = self._journal.done | ~needed
        left = len(done) - int(np.count_nonzero(done))
        self._counts.expect(left)
        pilot = pilot_points(left) if left >= _PILOT_FROM else 0
        blocks = finished_blocks(
            target.grid,
            options,
            done,
            executor,
            self._stop,
            block_points=target.config.execution.block_points,
            pilot=pilot,
            in_flight=self._counts.in_flight,
        )
        self._record(blocks, progress, judged=PILOT_BLOCKS if pilot else _BLOCKS_TO_JUDGE)

    def _rows(self) -> NDArray[np.float64]:
        """The result rows (size, columns) of what the journal holds, NaN where it has no point."""
        chunks = range(len(self._journal.chunks))
        return np.concatenate([self._journal.chunk(number).copy() for number in chunks])

    def _fill_in(self, refinement: Refinement) -> None:
        """Journal what lies between the computed points of a refined grid."""
        numbers, rows = refinement.interpolated(self._rows())
        with self._journaling():
            self._journal.append(numbers, rows)
            self._journal.flush()
        self._counts.fill(len(numbers))

    def outcome(self, ended: Outcome) -> Outcome:
        """How the sweep ended, with what this run has done."""
        return replace(
            ended,
            computed=self._counts.computed,
            seconds=self._counts.seconds,
            kernel_seconds=self._counts.costs.seconds,
            suspicious=(int(self._suspicious[0]), int(self._suspicious[1])),
        )

    def _compiled(self, options: Options, grid: Grid) -> bool:
        """Compile what the grid needs; returns False where a stop was requested meanwhile."""
        with Compiling(wanted=self._console.progress) as compiling:
            self._stop.at_once.append(compiling.stop)
            return wait_for(lambda: compile_kernels(options, grid), self._stop)

    def _beat(self, execution: Execution) -> dict[str, object]:
        """What the heartbeat says."""
        state = "stopping" if self._stop.reason else "running"
        return self._counts.as_dict() | {"state": state, "backend": execution.backend}

    def _record(self, blocks: Iterator[Block], progress: Progress, judged: int) -> None:
        """Record all blocks; the time left is judged after so many of them."""
        try:
            for number, block in enumerate(blocks, start=1):
                self._take_in(block)
                if number == 1:
                    self._stop_if_all_fail(block)
                if number == judged:
                    self._judge(progress)
            with self._journaling():
                self._journal.flush()
        except StorageError:
            self._stop.request("the journal could not be written")
            for _ in blocks:  # what is in flight cannot be kept any more
                pass
            raise

    def _take_in(self, block: Block) -> None:
        # A line is computed as a whole where one of its points is missing.
        fresh = int(np.count_nonzero(~self._journal.done[block.indices]))
        with self._journaling():
            self._note_processor(block.processor)
            self._journal.append(block.indices, block.results)
        self._counts.costs.learn(fresh, block.seconds)
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
        alone = self._counts.found == 0 and self._counts.left > 0
        if alone and first.failures == len(first.indices):
            self._stop.request(
                f"all {first.failures} points of the first block failed; if that is meant, the "
                "same command resumes",
                code=Exit.FAILED_POINTS,
            )

    def _judge(self, progress: Progress) -> None:
        """Say how long the rest takes and, where that is long, ask whether to continue."""
        left = self._counts.seconds_left or 0.0
        if left < _TELL_ABOVE:
            return
        progress.say(f"time left: about {duration(left)}")
        if left > _ASK_ABOVE and self._console.confirm is not None:
            progress.stop()
            if not self._console.confirm("Continue?"):
                self._stop.request("declined")
            progress.start()
