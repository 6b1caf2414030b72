"""The workers of a dask cluster: one that is there already, or one of this machine."""

from __future__ import annotations

import contextlib
import logging
import pickle
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from typing import Any, Self

from sweeps.config.schema import Execution
from sweeps.engine.executors.base import Executor, ExecutorError, WorkersLostError, first_line
from sweeps.engine.executors.children import terminal_signals_blocked
from sweeps.engine.executors.cluster_task import SealedTask, compute_on_cluster
from sweeps.engine.executors.worker import Block, Task, WorkerMismatchError

log = logging.getLogger(__name__)

_ANSWER_SECONDS = 5.0  # for a scheduler to answer
_CONNECT_SECONDS = 15.0  # for a client to be ready
_COUNT_SECONDS = 2.0  # between two looks at how many workers there are


class ClusterExecutor(Executor):
    """Computes tasks on the workers of a cluster that is there already; they may come and go."""

    # Handing a block to a worker over a network, and getting its result back, takes a tenth of a
    # second: blocks that last longer make it vanish.
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
            self._client = self._connect()
        except Exception as error:
            raise ExecutorError(self._not_there(error)) from error
        self._count()
        return self

    def __exit__(self, *exception: object) -> None:
        with contextlib.suppress(Exception):
            self._client.close(timeout=_ANSWER_SECONDS)

    def most_in_flight(self) -> int:
        """Two tasks for each thread that the cluster has at present."""
        self._count()
        return super().most_in_flight()

    def submit(self, task: Task) -> Future[Block]:
        """Hand a task to the cluster.

        Not through `Client.get_executor()`: its futures never end when the result of a finished
        task cannot be fetched, as when the connection is lost at that moment.
        """
        import asyncio  # takes a hundredth of a second, of every command

        there = self._client.submit(
            pickle.loads, pickle.dumps(SealedTask(compute_on_cluster, task)), pure=False
        )
        fetched = self._client.gather(there, asynchronous=True)
        return asyncio.run_coroutine_threadsafe(fetched, self._client.loop.asyncio_loop)

    def is_deserted(self) -> bool:
        """Whether no worker is connected at present; warns when that begins."""
        deserted = self._count() == 0
        if deserted and not self._warned:
            log.warning("no worker is connected to %s; waiting for one", self._address)
            self._warned = True
        return deserted

    def result(self, future: Future[Block]) -> Block:
        """The block of a finished task.

        Raises WorkersLostError where the task has outlived as many workers as the scheduler allows,
        WorkerMismatchError, and ExecutorError where the connection was lost or the worker has no
        stickslip.
        """
        from distributed import KilledWorker

        try:
            block = future.result()
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise WorkersLostError("no dask worker survived it", deaths) from error
        except WorkerMismatchError:
            raise
        except (CancelledError, OSError) as error:
            raise ExecutorError(
                f"the connection to the dask scheduler at {self._address} was lost; what is "
                "finished is kept, and the same command resumes"
            ) from error
        except Exception as error:
            raise ExecutorError(
                f"the dask cluster at {self._address} cannot compute a block "
                f"({type(error).__name__}: {first_line(error)}); install the same version of "
                "stickslip for all its workers"
            ) from error
        self._warned = False
        return block

    def _connect(self) -> Any:
        from distributed import Client
        from distributed.comm.addressing import get_address_host_port

        # Raises here where the address is none: a client that fails over it cannot be closed.
        get_address_host_port(self._address)
        # The client's own limit ends with the connection: a frozen scheduler's system accepts one.
        return _within(
            _CONNECT_SECONDS,
            lambda: Client(self._address, timeout=_ANSWER_SECONDS, set_as_default=False),
        )

    def _count(self) -> int:
        """The threads of all workers, as last heard."""
        now = time.monotonic()
        if now - self._counted >= _COUNT_SECONDS:
            self._counted = now
            self._threads = 0  # for a scheduler that does not answer, too: it may be frozen
            with contextlib.suppress(OSError, TimeoutError):
                threads = self._client.sync(
                    self._client.scheduler.ncores, callback_timeout=_ANSWER_SECONDS
                )
                self._threads = sum(threads.values())
            self.slots = max(self._threads, 1)
        return self._threads

    def _not_there(self, error: Exception) -> str:
        return f"no dask scheduler answers at {self._address} ({first_line(error)})"


class LocalClusterExecutor(ClusterExecutor):
    """Computes tasks on a dask cluster of this machine, which ends with the sweep.

    Who reaches a scheduler makes its workers run code: other users of the machine are kept out by
    certificates that only this process and its workers have.
    """

    def __init__(self, workers: int) -> None:
        super().__init__("this machine")
        self._workers = workers
        self._cluster: Any = None

    def __exit__(self, *exception: object) -> None:
        super().__exit__(*exception)
        with contextlib.suppress(Exception):
            self._cluster.close(timeout=_ANSWER_SECONDS)

    def _connect(self) -> Any:
        import dask
        from distributed import Client, LocalCluster, Security

        # Schedulers and workers serve web pages even without a dashboard, to whoever asks.
        routes = [f"distributed.{kind}.http.routes" for kind in ("scheduler", "worker")]
        silent: dict[str, list[str]] = {name: [] for name in routes}
        with terminal_signals_blocked(), dask.config.set(silent):
            self._cluster = LocalCluster(
                n_workers=self._workers,
                threads_per_worker=1,
                memory_limit=None,  # a block needs little; shares of the memory stop large machines
                security=Security.temporary(),
                protocol="tls://",
                dashboard_address=None,
                silence_logs=logging.CRITICAL,
                scheduler_kwargs={
                    # A task that kills a worker comes back at once: the hand-out finds the point.
                    "allowed_failures": 0,
                    # Where its empty pages are: the usual port may be that of another sweep.
                    "dashboard_address": "127.0.0.1:0",
                },
            )
        return Client(self._cluster, set_as_default=False)

    def _not_there(self, error: Exception) -> str:
        return f"a dask cluster cannot be started on this machine ({first_line(error)})"


def executor_for(execution: Execution) -> Executor:
    """The workers of the scheduler that the config names, or of a cluster of this machine."""
    if execution.scheduler:
        return ClusterExecutor(execution.scheduler)
    return LocalClusterExecutor(execution.workers)


def _within(seconds: float, make: Callable[[], Any]) -> Any:
    """What `make` returns or raises; TimeoutError where it takes longer, and goes on unheeded."""
    made: Future[Any] = Future()

    def run() -> None:
        try:
            made.set_result(make())
        except Exception as error:  # noqa: BLE001
            made.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    try:
        return made.result(seconds)
    except TimeoutError as error:
        raise TimeoutError(f"no answer within {seconds:.0f} s") from error


def _import_distributed() -> None:
    """Import dask with its log silenced, because every failure it would log is raised here too.

    Where it was imported before, its log stays as it is. Raises ExecutorError.
    """
    try:
        import dask

        quiet = dict.fromkeys(("distributed", "distributed.client"), "critical")
        with dask.config.set({"logging": quiet}):
            import distributed  # noqa: F401
    except ImportError:
        raise ExecutorError("dask is not installed; try: pip install 'stickslip[dask]'") from None
