"""The workers of a dask cluster, which may come and go."""

from __future__ import annotations

import contextlib
import logging
import pickle
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from functools import partial
from typing import Any, Self

from filelock import FileLock

from stickslip.compiled.cache import cache_folder
from stickslip.dispatch.errors import ExecutorError, WorkerMismatchError, WorkersLostError
from stickslip.dispatch.stop import in_thread
from stickslip.dispatch.task import Block, Task, compute_block, refuse_other_code
from stickslip.dispatch.workers import Executor, first_line
from stickslip.kernels.families import KIND
from stickslip.orbit import prepare_kernels
from stickslip.parameters import Parameters
from sweeps.config.schema import Execution
from sweeps.exits import ExpectedError

log = logging.getLogger(__name__)


class AddressError(ExpectedError, ExecutorError):
    """An address at which no scheduler can ever answer this process."""


ANSWER_SECONDS = 5.0  # for a scheduler to answer
CONNECT_SECONDS = 15.0  # for a client to be ready
_COUNT_SECONDS = 2.0  # between two counts of the workers
_COMPILE_SECONDS = 300.0  # for another process of the machine to compile the kernels

_ENCRYPTED = ("tls:", "wss:")

_KIND = [Parameters._fields.index(name) for name in KIND]


class ClusterExecutor(Executor):
    """Computes tasks on the workers of a cluster."""

    # Sending a block to a worker and getting its result back takes a tenth of a second. Longer
    # blocks make that negligible.
    block_seconds = 3.0

    def __init__(self, address: str) -> None:
        super().__init__(slots=1)
        self._address = address
        self._client: Any = None
        self._threads, self._counted = 0, -_COUNT_SECONDS
        self._warned = False

    def __enter__(self) -> Self:
        _import_distributed()
        try:
            # The client's own time limit covers only the connection, which the operating system
            # accepts even for a frozen scheduler. So a thread makes the client, and we wait for
            # the thread only so long.
            self._client = in_thread(partial(_connected, self._address)).result(CONNECT_SECONDS)
        except AddressError:
            raise
        except Exception as error:
            # An error without text is the TimeoutError of the thread.
            problem = first_line(error) if str(error) else f"no answer in {CONNECT_SECONDS:g} s"
            raise ExecutorError(
                f"no dask scheduler answers at {self._address} ({problem})"
            ) from error
        self._count()
        return self

    def __exit__(self, *exception: object) -> None:
        with contextlib.suppress(Exception):
            self._client.close(timeout=ANSWER_SECONDS)

    def most_in_flight(self) -> int:
        """Return two tasks for each thread that the cluster has now."""
        self._count()
        return super().most_in_flight()

    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to the cluster.

        `Client.get_executor()` will not do: if the connection is lost just before the result of a
        finished task is fetched, its future never completes.
        """
        import asyncio  # here, since the import would cost every command a hundredth of a second

        handle = self._client.submit(
            pickle.loads, pickle.dumps(SealedTask(compute_on_cluster, task)), pure=False
        )
        fetched = self._client.gather(handle, asynchronous=True)
        return asyncio.run_coroutine_threadsafe(fetched, self._client.loop.asyncio_loop)

    def is_deserted(self) -> bool:
        """Return whether no worker is connected now; warn when the last one leaves."""
        deserted = self._count() == 0
        if deserted and not self._warned:
            log.warning("no worker is connected to %s; waiting for one", self._address)
            self._warned = True
        return deserted

    def result(self, future: Future[Block]) -> Block:
        """Return the block of a finished task.

        Raises WorkersLostError if the task has cost as many workers as the scheduler allows,
        WorkerMismatchError, and ExecutorError if the connection is lost or the worker lacks
        stickslip.
        """
        from distributed import KilledWorker

        try:
            block = future.result()
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise WorkersLostError("no dask worker survived", deaths) from error
        except WorkerMismatchError:
            raise
        except (CancelledError, OSError) as error:
            raise ExecutorError(
                f"the connection to the dask scheduler at {self._address} was lost; finished "
                "points are kept; run the same command to resume"
            ) from error
        except Exception as error:
            raise ExecutorError(
                f"the dask cluster at {self._address} cannot compute a block "
                f"({type(error).__name__}: {first_line(error)}); install the same version of "
                "stickslip on all its workers"
            ) from error
        self._warned = False
        return block

    def _count(self) -> int:
        """Return the number of threads of all workers, counted at most two seconds ago."""
        now = time.monotonic()
        if now - self._counted >= _COUNT_SECONDS:
            self._counted = now
            self._threads = 0  # also if the scheduler does not answer: it may be frozen
            with contextlib.suppress(OSError, TimeoutError):
                threads = self._client.sync(
                    self._client.scheduler.ncores, callback_timeout=ANSWER_SECONDS
                )
                self._threads = sum(threads.values())
            self.slots = max(self._threads, 1)
        return self._threads


def _connected(address: str) -> Any:
    """Return a client of a scheduler; raises the error of a failed connection."""
    import asyncio

    from distributed import Client
    from distributed.comm.core import connect

    arguments = _certified(address)

    async def reach() -> None:
        try:
            comm = await connect(address, timeout=ANSWER_SECONDS, **arguments)
        except Exception as error:
            if address.startswith("inproc:"):
                raise AddressError(
                    f"{address} belongs to a cluster inside another process, or to no "
                    "cluster; an address that other processes can reach begins with tcp://"
                ) from error
            raise
        await comm.close()

    asyncio.run(reach())  # first, since a client that fails to connect cannot be closed
    return Client(address, timeout=ANSWER_SECONDS, set_as_default=False)


def _certified(address: str) -> dict[str, Any]:
    """Return arguments for connecting; raises AddressError if needed certificates are missing."""
    from distributed.security import Security

    why = "there are none"
    try:
        arguments: dict[str, Any] = Security().get_connection_args("client")
    except Exception as error:  # noqa: BLE001 - files that are no certificates, in any way
        arguments, why = {}, first_line(error)
    if address.startswith(_ENCRYPTED) and arguments.get("ssl_context") is None:
        raise AddressError(
            f"{address} needs certificates in dask's configuration, such as "
            f"distributed.comm.tls.ca-file and .client.cert ({why})"
        )
    return arguments


class SealedTask:
    """A task whose pickled bytes become its block when a worker loads them.

    The scheduler never loads the bytes, so it does not need stickslip. A worker without stickslip
    fails while computing the task, and its error comes back; it would otherwise fail while reading
    a message of the scheduler.
    """

    def __init__(self, compute: Callable[[Task], Block], task: Task) -> None:
        self._compute, self._task = compute, task

    def __reduce__(self) -> tuple[Any, ...]:
        return self._compute, (self._task,)


def compute_on_cluster(task: Task) -> Block:
    """Compute a task on a machine where the kernels may not have been compiled yet.

    One process compiles them; the others wait, and load them from the cache.
    """
    refuse_other_code(task)
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError, RuntimeError):  # then each compiles for itself
            lock = FileLock(cache_folder().with_suffix(".lock"), timeout=_COMPILE_SECONDS)
            stack.enter_context(lock)
        prepare_kernels(task.options, task.points[:, _KIND])
    return compute_block(task)


def executor_for(execution: Execution) -> Executor:
    """Return the executor of the scheduler that the config names; raises ExecutorError."""
    if execution.scheduler is None:
        raise ExecutorError("`backend: dask` needs the address of a scheduler")
    return ClusterExecutor(execution.scheduler)


def _import_distributed() -> None:
    """Import dask with its log silenced, since this module raises every failure that it logs.

    If dask was imported before, its log stays as it is. Raises ExecutorError.
    """
    try:
        import dask

        quiet = dict.fromkeys(("distributed", "distributed.client"), "critical")
        with dask.config.set({"logging": quiet}):
            import distributed  # noqa: F401
    except ImportError:
        remedy = "pip install 'dask>=2024.7' 'distributed>=2024.7'"
        raise ExecutorError(f"dask is not installed; try: {remedy}") from None
