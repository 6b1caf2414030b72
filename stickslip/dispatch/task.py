"""A worker's task, a block of points in which no point can harm another."""

from __future__ import annotations

import hashlib
import logging
import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.cache import processor, source_hash
from stickslip.dispatch.errors import WorkerMismatchError
from stickslip.dispatch.lines import follow
from stickslip.laws import LawError
from stickslip.measure.results import STATUS
from stickslip.model.laws import friction_law
from stickslip.options import Options
from stickslip.orbit import compute_orbits, failed_row
from stickslip.plausibility import are_possible, suspicious_balance, suspicious_stress
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """A block of points to compute: their numbers, parameters (n, parameters) and options.

    Each `line` of points belongs together, because every point starts from the one before; single
    points are lines of 1. Points that take longer than `patience` drive periods are left `pending`
    to be computed later, points that take longer than `limit` for good; 0 means no limit.
    """

    indices: NDArray[np.int64]
    points: NDArray[np.float64]
    options: Options
    code: str
    line: int = 1
    patience: int = 0
    limit: int = 0

    @property
    def is_unlimited(self) -> bool:
        """Whether the task may take minutes, like one of late points or a block full of them.

        The lines of a followed axis, which have no limit either, count as ordinary blocks.
        """
        return self.patience == self.limit == 0 and self.line == 1


@dataclass(frozen=True)
class Block:
    """Computed points: their numbers (n,), result rows (n, columns) and what happened to them.

    `suspicious` counts the points with a suspicious power balance, and with a suspicious stress;
    `messages` name the points that failed. A worker that has computed a block returns it `sealed`.
    """

    indices: NDArray[np.int64]
    results: NDArray[np.float64]
    seconds: float = 0.0
    processor: str = ""
    suspicious: tuple[int, int] = (0, 0)
    messages: tuple[str, ...] = ()
    checksum: bytes = b""

    def sealed(self) -> Block:
        """Return the block with a checksum, which reveals damage on the way."""
        return replace(self, checksum=self._digest())

    def is_undamaged(self) -> bool:
        """Return whether the checksum is that of the numbers and results."""
        return self.checksum == self._digest()

    def _digest(self) -> bytes:
        whole = self.indices.tobytes() + self.results.tobytes()
        return hashlib.blake2b(whole, digest_size=16).digest()

    def part(self, which: NDArray[np.bool_]) -> Block:
        """Return a block with some of the points (n,) only."""
        return replace(self, indices=self.indices[which], results=self.results[which])


def compute_block(task: Task) -> Block:
    """Compute a block; a point that raises an error gets the status `failed`.

    Raises WorkerMismatchError as `refuse_other_code` does.
    """
    refuse_other_code(task)
    messages: list[str] = []
    begun = time.monotonic()
    try:
        results = computed_results(task.points, task)
    except Exception:  # one point must not spoil the others
        log.debug("a block failed; its points are computed one by one", exc_info=True)
        parts = np.split(task.points, len(task.points) // task.line)
        results = np.concatenate([_alone(part, task, messages) for part in parts])
    seconds = time.monotonic() - begun
    suspicious = suspicious_balance(results), suspicious_stress(task.points, results)
    return Block(
        task.indices,
        results,
        seconds,
        processor(),
        (int(suspicious[0].sum()), int(suspicious[1].sum())),
        tuple(messages),
    ).sealed()


def refuse_other_code(task: Task) -> None:
    """Raise WorkerMismatchError unless we have the sources and the law of the sweep."""
    if task.code != source_hash():
        raise WorkerMismatchError(
            f"a worker's stickslip code ({source_hash()[:12]}) differs from this sweep's "
            f"({task.code[:12]}); install the same version everywhere"
        )
    try:
        friction_law(task.options.friction)
    except LawError as error:
        raise WorkerMismatchError(
            f"a worker lacks the friction law of this sweep: {error}"
        ) from error


def failed_block(task: Task, reason: str) -> Block:
    """Return the block of a task that no worker survives."""
    rows = np.tile(failed_row(), (len(task.indices), 1))
    messages = tuple(f"point {point.tolist()} failed: {reason}" for point in task.points)
    return Block(task.indices, rows, messages=messages)


def is_answer(answer: object, task: Task) -> bool:
    """Return whether an answer from elsewhere can be the block of a task."""
    if not (isinstance(answer, Block) and _has_its_types(answer)):
        return False
    results = answer.results
    if (
        not np.array_equal(answer.indices, task.indices)
        or results.shape != (len(task.indices), len(RESULT_COLUMNS))
        or results.dtype != np.float64
        or not answer.is_undamaged()
        or not are_possible(results)
    ):
        return False
    # No worker interpolates, and none leaves points pending without a limit to their periods.
    foreign = [Status.INTERPOLATED, *([] if task.patience or task.limit else [Status.PENDING])]
    return not np.isin(results[:, STATUS], foreign).any()


def _has_its_types(block: Any) -> bool:
    """Return whether each field of a block from elsewhere has its declared type."""
    return (
        type(block.indices) is type(block.results) is np.ndarray
        and block.indices.dtype == np.int64
        and type(block.seconds) is float
        and 0.0 <= block.seconds < math.inf
        and type(block.processor) is str
        and _is_tuple_of(int, block.suspicious)
        and len(block.suspicious) == 2
        and _is_tuple_of(str, block.messages)
        and type(block.checksum) is bytes
    )


def _is_tuple_of(kind: type, values: object) -> bool:
    return type(values) is tuple and all(type(value) is kind for value in values)


def computed_results(points: NDArray[np.float64], task: Task) -> NDArray[np.float64]:
    """Return the result rows (n, columns) of points, or whole lines of points, of a task."""
    if task.line > 1:
        return follow(points, task.line, task.options)
    return compute_orbits(points, task.options, patience=task.patience, limit=task.limit)[0]


def _alone(points: NDArray[np.float64], task: Task, messages: list[str]) -> NDArray[np.float64]:
    """Return the result rows of one point or line, even if it raises an error."""
    try:
        return computed_results(points, task)
    except Exception as error:  # recorded as the point's status
        what = "point" if task.line == 1 else "the line from point"
        messages.append(f"the computation of {what} {points[0].tolist()} failed: {error!r}")
        log.debug("the computation of a point failed", exc_info=True)
        return np.tile(failed_row(), (len(points), 1))
