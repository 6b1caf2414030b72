"""A task as it travels through a dask cluster, and its computation there."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from filelock import FileLock

from stickslip.compiled.cache import cache_folder, source_hash
from stickslip.kernels.families import KIND
from stickslip.orbit import prepare_kernels
from stickslip.parameters import Parameters
from sweeps.engine.executors.worker import Block, Task, compute_block

_COMPILE_SECONDS = 300.0  # for another process of the machine to compile the kernels

_KIND = [Parameters._fields.index(name) for name in KIND]


def compute_on_cluster(task: Task) -> Block:
    """The block of a task, on a machine where perhaps nobody has compiled the kernels yet."""
    if task.code == source_hash():
        with _alone_on_the_machine():
            prepare_kernels(task.options, task.points[:, _KIND])
    return compute_block(task)


class SealedTask:
    """A task whose pickled bytes become its block when a worker loads them.

    The scheduler never loads them and needs no stickslip; a worker without one fails in computing
    the task, with a message that comes back, rather than in reading a message of the scheduler.
    """

    def __init__(self, compute: Callable[[Task], Block], task: Task) -> None:
        self._compute, self._task = compute, task

    def __reduce__(self) -> tuple[Any, ...]:
        return self._compute, (self._task,)


@contextlib.contextmanager
def _alone_on_the_machine() -> Iterator[None]:
    """One process compiles, the others wait for it and load what it has cached."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError, RuntimeError):  # then each compiles for itself
            lock = FileLock(cache_folder().with_suffix(".lock"), timeout=_COMPILE_SECONDS)
            stack.enter_context(lock)
        yield
