"""Where blocks are computed: threads, processes, or the workers of a dask cluster."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import multiprocessing
import os
import pickle
import queue
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from multiprocessing import resource_tracker
from typing import Any, Protocol, Self

from filelock import FileLock

from stickslip.compiled.cache import cache_folder, source_hash
from stickslip.orbit import prepare_kernels
from stickslip.parameters import Parameters
from sweeps.config.schema import Execution
from sweeps.engine.signals import Stop
from sweeps.engine.worker import Block, Task, WorkerMismatchError, compute_block

log = logging.getLogger(__name__)

Tasks = Iterator[Task]

# Handing a block to a worker over a network, and getting its result back, takes a tenth of a
# second: blocks that last longer make it vanish.
_BLOCK_SECONDS = {"threads": 1.0, "loky": 1.0, "dask": 3.0}

_ANSWER_SECONDS = 5.0  # for a scheduler to answer
_SILENCE_SECONDS = 5.0  # without a finished block, until it is asked why
_COUNT_SECONDS = 2.0  # between two looks at how many workers there are
_COMPILE_SECONDS = 300.0  # for another process of the machine to compile the kernels

_OF_A_TERMINAL = {signal.SIGINT, signal.SIGHUP}

_GAMMA = Parameters._fields.index("rheological_index")


class BackendError(RuntimeError):
    """The workers cannot be had, or were lost; what is finished is kept."""


class WorkersLostError(RuntimeError):
    """Workers died; any of the blocks that have not come back may have killed them.

    Each of those blocks has seen the end of `deaths` workers.
    """

    def __init__(self, reason: str, deaths: int = 1) -> None:
        super().__init__(reason)
        self.deaths = deaths


class Backend(Protocol):
    """Computes tasks: a context manager, from which finished blocks come in any order."""

    slots: int
    block_seconds: float

    def __enter__(self) -> Backend: ...

    def __exit__(self, *exception: object) -> None: ...

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        """The finished blocks of the tasks; a task is taken when it can be begun soon.

        After a request to stop, blocks that no worker is there for do not come.

        Raises WorkersLostError, when nothing else can come: what has not is to be given again.
        """

    def kill(self) -> None:
        """Leave no process behind, at once."""


def make_backend(execution: Execution) -> Backend:
    """The backend that a config asks for."""
    if execution.backend == "threads":
        return _Threads(execution.workers)
    if execution.backend == "loky":
        return _Processes(execution.workers)
    if execution.scheduler:
        return _Cluster(execution.scheduler)
    return _LocalCluster(execution.workers)


class _Pool:
    """What all backends have in common: some tasks in flight, and results as they come."""

    def __init__(self, name: str, slots: int) -> None:
        self.slots, self.block_seconds = slots, _BLOCK_SECONDS[name]

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        finished: queue.SimpleQueue[Future[Block]] = queue.SimpleQueue()
        flying, lost = 0, None
        while True:
            try:
                room = 0 if lost else self._most_in_flight() - flying
                for task in islice(tasks, max(room, 0)):
                    self._submit(task).add_done_callback(finished.put)
                    flying += 1
            except WorkersLostError as error:
                lost = error
            future = self._next(finished, stop) if flying else None
            if future is None:
                break
            flying -= 1
            try:
                block = self._result(future)
            except WorkersLostError as error:
                lost = error  # of the others in flight, some may still come
            else:
                yield block
        if lost:
            raise lost

    def kill(self) -> None:
        # Called by a signal handler, which can wait for no lock.
        for child in multiprocessing.active_children():
            with contextlib.suppress(OSError):
                os.kill(child.pid or 0, signal.SIGKILL)

    def _most_in_flight(self) -> int:
        """A task for each slot, and one that waits there."""
        return 2 * self.slots

    def _submit(self, task: Task) -> Future[Block]:
        raise NotImplementedError

    def _result(self, future: Future[Block]) -> Block:
        return future.result()

    def _next(self, finished: queue.SimpleQueue[Future[Block]], stop: Stop) -> Future[Block] | None:
        """The next finished one; None where nobody is there to finish one before the stop."""
        while True:
            with contextlib.suppress(queue.Empty):
                return finished.get(timeout=_SILENCE_SECONDS)
            if self._is_deserted() and stop.requested:
                return None

    def _is_deserted(self) -> bool:
        """Whether there is no worker at present."""
        return False


class _Threads(_Pool):
    """Threads of this process: kernels release the interpreter's lock.

    joblib's threads would begin the next block before the last one is journaled, however long the
    disk takes: a kill then costs more than the blocks in flight.
    """

    def __init__(self, workers: int) -> None:
        super().__init__("threads", workers)

    def __enter__(self) -> Self:
        self._executor = ThreadPoolExecutor(self.slots)
        return self

    def __exit__(self, *exception: object) -> None:
        self._executor.shutdown(wait=exception[0] is None, cancel_futures=True)

    def _most_in_flight(self) -> int:
        return self.slots  # handing over takes no time: blocks are cut as late as possible

    def _submit(self, task: Task) -> Future[Block]:
        return self._executor.submit(compute_block, task)


class _Processes(_Pool):
    """Processes of this machine, which joblib's loky starts without running `__main__` again."""

    def __init__(self, workers: int) -> None:
        super().__init__("loky", workers)
        self._executor: Any = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self._shut_down(kill=exception[0] is not None)

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        try:
            yield from super().blocks(tasks, stop)
        except WorkersLostError:
            self._shut_down(kill=True)
            raise

    def _shut_down(self, *, kill: bool) -> None:
        if self._executor is not None:
            self._executor.shutdown(wait=True, kill_workers=kill)
            self._executor = None

    def _submit(self, task: Task) -> Future[Block]:
        from joblib.externals.loky import ProcessPoolExecutor

        try:
            with _deaf_children():
                if self._executor is None:
                    self._executor = ProcessPoolExecutor(
                        self.slots, initializer=_end_with, initargs=(os.getpid(),)
                    )
                future: Future[Block] = self._executor.submit(compute_block, task)
        except BrokenProcessPool as error:
            raise WorkersLostError(_first_line(error)) from error
        return future

    def _result(self, future: Future[Block]) -> Block:
        try:
            return future.result()
        except BrokenProcessPool as error:
            raise WorkersLostError(_first_line(error)) from error


@contextlib.contextmanager
def _deaf_children() -> Iterator[None]:
    """Processes and threads that are started meanwhile leave Ctrl-C to the main thread.

    A terminal sends it, and the end of its session, to all processes. They are deaf from their
    first moment: handlers of their own would come too late for the second of their imports.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _OF_A_TERMINAL)
    try:
        resource_tracker.ensure_running()  # this may end with open ears
        signal.pthread_sigmask(signal.SIG_BLOCK, _OF_A_TERMINAL)
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with(parent: int) -> None:
    """In a process: do not outlive its parent, whatever ends that."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


class _Cluster(_Pool):
    """The workers of a dask cluster that is there already; they may come and go."""

    def __init__(self, address: str) -> None:
        super().__init__("dask", 1)
        self._address = address
        self._client: Any = None
        self._threads, self._counted = 0, -_COUNT_SECONDS
        self._told = False

    def __enter__(self) -> Self:
        _import_distributed()
        try:
            self._client = self._connect()
        except Exception as error:
            raise BackendError(self._not_there(error)) from error
        self._count()
        return self

    def __exit__(self, *exception: object) -> None:
        with contextlib.suppress(Exception):
            self._client.close(timeout=_ANSWER_SECONDS)

    def _connect(self) -> Any:
        from distributed import Client
        from distributed.comm.addressing import get_address_host_port

        get_address_host_port(self._address)  # a client that stumbles over it cannot be closed
        return Client(self._address, timeout=_ANSWER_SECONDS, set_as_default=False)

    def _not_there(self, error: Exception) -> str:
        return f"no dask scheduler answers at {self._address} ({_first_line(error)})"

    def _count(self) -> int:
        """The threads of all workers, as last heard."""
        now = time.monotonic()
        if now - self._counted >= _COUNT_SECONDS:
            self._counted = now
            with contextlib.suppress(OSError, TimeoutError):
                threads = self._client.sync(
                    self._client.scheduler.ncores, callback_timeout=_ANSWER_SECONDS
                )
                self._threads = sum(threads.values())
                self.slots = max(self._threads, 1)
        return self._threads

    def _most_in_flight(self) -> int:
        self._count()
        return super()._most_in_flight()

    def _submit(self, task: Task) -> Future[Block]:
        there = self._client.submit(pickle.loads, pickle.dumps(_Sealed(task)), pure=False)
        result = self._client.gather(there, asynchronous=True)
        return asyncio.run_coroutine_threadsafe(result, self._client.loop.asyncio_loop)

    def _is_deserted(self) -> bool:
        deserted = self._count() == 0
        if deserted and not self._told:
            log.warning("no worker is connected to %s; waiting for one", self._address)
            self._told = True
        return deserted

    def _result(self, future: Future[Block]) -> Block:
        from distributed import KilledWorker

        try:
            block = future.result()
        except KilledWorker as error:
            deaths = error.allowed_failures + 1
            raise WorkersLostError("no dask worker survived it", deaths) from error
        except WorkerMismatchError:
            raise
        except (CancelledError, OSError) as error:
            raise BackendError(
                f"the connection to the dask scheduler at {self._address} was lost; what is "
                "finished is kept, and the same command goes on from there"
            ) from error
        except Exception as error:
            raise BackendError(
                f"the dask cluster at {self._address} cannot compute a block "
                f"({type(error).__name__}: {_first_line(error)}); install the same version of "
                "stickslip for all its workers"
            ) from error
        self._told = False
        return block


class _LocalCluster(_Cluster):
    """A dask cluster of this machine, which ends with the sweep."""

    def __init__(self, workers: int) -> None:
        super().__init__("this machine")
        self._workers = workers
        self._cluster: Any = None

    def __exit__(self, *exception: object) -> None:
        super().__exit__(*exception)
        with contextlib.suppress(Exception):
            self._cluster.close(timeout=_ANSWER_SECONDS)

    def _connect(self) -> Any:
        from distributed import Client, LocalCluster

        with _deaf_children():
            self._cluster = LocalCluster(
                n_workers=self._workers,
                threads_per_worker=1,
                memory_limit=None,  # a block needs little; shares of the memory stop large machines
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
                scheduler_kwargs={"allowed_failures": 0},  # who killed a worker is tried here
            )
        return Client(self._cluster, set_as_default=False)

    def _not_there(self, error: Exception) -> str:
        return f"a dask cluster cannot be started on this machine ({_first_line(error)})"


def _import_distributed() -> None:
    """What it would log is told by exceptions; whoever imported it before has it as wanted."""
    try:
        import dask

        quiet = dict.fromkeys(("distributed", "distributed.client"), "critical")
        with dask.config.set({"logging": quiet}):
            import distributed  # noqa: F401
    except ImportError:
        raise BackendError("dask is not installed; try: pip install 'stickslip[dask]'") from None


class _Sealed:
    """A task whose bytes become its block when they are read, by the worker in its own time.

    A worker that has no stickslip can so say it, rather than choke on a message of the scheduler,
    which needs none.
    """

    def __init__(self, task: Task) -> None:
        self._task = task

    def __reduce__(self) -> tuple[Any, ...]:
        return _compute_on_cluster, (self._task,)


def _compute_on_cluster(task: Task) -> Block:
    """The block of a task, on a machine where perhaps nobody has compiled the kernels yet."""
    if task.code == source_hash():
        with _alone_on_the_machine():
            prepare_kernels(task.options, task.points[:, _GAMMA])
    return compute_block(task)


@contextlib.contextmanager
def _alone_on_the_machine() -> Iterator[None]:
    """One process compiles, the others wait for it and load what it has cached."""
    lock = FileLock(cache_folder().with_suffix(".lock"), timeout=_COMPILE_SECONDS)
    with contextlib.suppress(OSError, RuntimeError):  # then each compiles for itself
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [repr(error)])[0]
