"""A peer in a process of its own: pinned, silent, and killed when it takes too long."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from shared.timing import pin

from peers.solvers import PEERS, PeerFailed, State
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
    """Why there is no measurement, and the seconds until that was known."""

    reason: str
    out_of_time: bool = False
    seconds: float = 0.0


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
        self, p: Parameters, start: State, periods: int, rtol: float, *, limit: float, runs: int
    ) -> Measurement | Failure:
        """Time the integration of so many drive periods; `limit` [s] is for one run.

        Slow runs are repeated less often: what fits into two seconds, at least once.
        """
        prepared = self._ask("prepare", p, start, rtol, limit=PREPARATION_LIMIT)
        if isinstance(prepared, Failure):
            return prepared
        shortest, done = math.inf, 0
        while done < runs and (done == 0 or done * shortest < 2.0):
            answer = self._ask("end_state", p, start, periods, rtol, limit=limit)
            if isinstance(answer, Failure):
                return answer
            state, seconds = answer
            shortest, done = min(shortest, seconds), done + 1
        return Measurement(state, shortest, done)

    def stationary(
        self, p: Parameters, rtol: float, max_periods: int, stationary_rtol: float, *, limit: float
    ) -> StationaryOrbit | Failure:
        """Return stationary amplitudes by plain iteration, by numbalsoda whichever peer this is.

        `limit` [s] bounds the search; the first one of a process, which compiles, comes untimed.
        """
        if self._connection is None:
            first = self._ask("stationary", Parameters(), 1e-4, 1, 1e-2, limit=PREPARATION_LIMIT)
            if isinstance(first, Failure) and self._connection is None:
                return first
        answer = self._ask("stationary", p, rtol, max_periods, stationary_rtol, limit=limit)
        return answer if isinstance(answer, Failure) else answer[0]

    def _ask(self, order: str, p: Parameters, *task: Any, limit: float) -> Any:
        """Return what the process answers, and its seconds; or a Failure."""
        connection, begun = self._started(), time.perf_counter()
        try:
            connection.send((order, tuple(p), task))
            if not connection.poll(limit):
                self.close()
                return Failure(f"did not finish in {limit:g} s", out_of_time=True, seconds=limit)
            answer = connection.recv()
        except (EOFError, OSError):
            self.close()
            answer = "its process died"
        seconds = time.perf_counter() - begun
        return Failure(answer, seconds=seconds) if isinstance(answer, str) else answer

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
    """Answer orders with a result and its seconds, or with why there is none, until the end."""
    from peers.stationary import numbalsoda_stationary

    pin()
    peer, connection = PEERS[name], Connection(descriptor)
    calls: dict[str, Any] = {
        "prepare": peer.prepare,
        "end_state": peer.end_state,
        "stationary": numbalsoda_stationary,
    }
    with tempfile.TemporaryDirectory() as folder:  # for whatever a peer leaves where it stands
        os.chdir(folder)
        while True:
            try:
                order, values, task = connection.recv()
            except EOFError:
                return
            begun = time.perf_counter()
            try:
                answer = calls[order](Parameters(*values), *task)
                connection.send((answer, time.perf_counter() - begun))
            except PeerFailed as failure:
                connection.send(str(failure))
            except Exception as error:  # noqa: BLE001 - whatever a peer raises is its result
                connection.send(f"{type(error).__name__}: {error}"[:200])
