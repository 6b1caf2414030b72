"""A peer in a process of its own: pinned, silent, and killed when it takes too long."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from shared.timing import pin

from peers.base import PeerFailed, State
from stickslip.parameters import Parameters

if TYPE_CHECKING:
    from peers.stationary import StationaryOrbit

PREPARATION_LIMIT = 180.0
"""Seconds for the imports and the compilation of a peer."""


class Measurement(NamedTuple):
    """The end of a run, and the shortest of so many timings [s]."""

    state: State
    seconds: float
    runs: int


class Failure(NamedTuple):
    """Why there is no measurement."""

    reason: str
    out_of_time: bool = False


class Worker:
    """Measures one peer; `close` it, or leave its context, so that no process stays behind."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def measure(
        self,
        parameters: Parameters,
        start: State,
        periods: int,
        rtol: float,
        *,
        limit: float,
        runs: int = 5,
    ) -> Measurement | Failure:
        """Time the integration of so many drive periods; `limit` [s] is for one run.

        Slow runs are repeated less often: what fits into two seconds, at least once.
        """
        task = (tuple(parameters), start, periods, rtol)
        prepared = self._ask(("prepare", task), PREPARATION_LIMIT)
        if isinstance(prepared, Failure):
            return prepared
        best, done = self._ask(("run", task), limit), 1
        if isinstance(best, Failure):
            return best
        state, shortest = best
        while done < runs and done * shortest < 2.0:
            again = self._ask(("run", task), limit)
            if isinstance(again, Failure):
                return again
            shortest, done = min(shortest, again[1]), done + 1
        return Measurement(state, shortest, done)

    def stationary(
        self,
        parameters: Parameters,
        rtol: float,
        max_periods: int,
        stationary_rtol: float,
        *,
        limit: float,
    ) -> StationaryOrbit | Failure:
        """Return stationary amplitudes by plain iteration, by numbalsoda whichever peer this is.

        `limit` [s] bounds the search; the first one of a process, which compiles, comes untimed.
        """
        if self._connection is None:
            task = (tuple(Parameters()), 1e-4, 1, 1e-2)
            prepared = self._ask(("stationary", task), PREPARATION_LIMIT)
            if isinstance(prepared, Failure) and self._connection is None:
                return prepared
        task = (tuple(parameters), rtol, max_periods, stationary_rtol)
        return self._ask(("stationary", task), limit)

    def _ask(self, message: tuple, limit: float) -> Any:
        """Return the answer of the process, a Failure for a reason in words or for none."""
        connection = self._started()
        try:
            connection.send(message)
            if not connection.poll(limit):
                self.close()
                return Failure(f"did not finish in {limit:g} s", out_of_time=True)
            answer = connection.recv()
        except (EOFError, OSError):
            self.close()
            return Failure("its process died")
        return Failure(answer) if isinstance(answer, str) else answer

    def _started(self) -> Connection:
        if self._connection is None:
            # Not a process of multiprocessing, which would import the calling script again.
            self._connection, theirs = Pipe()
            call = f"from peers.worker import serve; serve({self._name!r}, {theirs.fileno()})"
            self._process = subprocess.Popen(
                [sys.executable, "-c", call],
                cwd=Path(__file__).parent.parent,
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,  # solvers write to the terminal from C
                stderr=subprocess.DEVNULL,
            )
            theirs.close()
        return self._connection

    def close(self) -> None:
        """End the process; the next measurement starts another."""
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        self._connection = self._process = None


def serve(name: str, descriptor: int) -> None:
    """Answer tasks until the connection closes.

    ("prepare" or "run", task) with (state, seconds), ("stationary", task) with a StationaryOrbit,
    any with the reason of a failure.
    """
    from peers import PEERS
    from peers.stationary import numbalsoda_stationary

    pin()
    peer, connection = PEERS[name], Connection(descriptor)
    with tempfile.TemporaryDirectory() as folder:  # for whatever a peer leaves where it stands
        os.chdir(folder)
        while True:
            try:
                order, (values, *task) = connection.recv()
            except EOFError:
                return
            calls = {"prepare": peer.prepare, "run": peer.end_state}
            begun = time.perf_counter()
            try:
                if order == "stationary":
                    answer = numbalsoda_stationary(Parameters(*values), *task)
                else:
                    state = calls[order](Parameters(*values), *task)
                    answer = state, time.perf_counter() - begun
            except PeerFailed as failure:
                answer = (None, 0.0) if order == "prepare" else str(failure)
            except Exception as error:  # noqa: BLE001 - whatever a peer raises is its result
                answer = f"{type(error).__name__}: {error}"[:200]
            connection.send(answer)
