"""Solvers, each bound to its points: a series of runs over the tolerances."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from inside.lanes import end_states
from inside.scalar import scalar_end, starting_state
from peers import LADDER, PEERS, Failure, Worker
from shared.points import parameter

from stickslip.options import Options
from stickslip.parameters import Parameters

PERIODS = 3
REFERENCE_RTOL = 1e-12

# Ours reaches an error of 1e-4 at tolerances that are looser than those of the peers.
OWN_LADDER = (1e-2, 3e-3, *LADDER)


class Run(NamedTuple):
    """End positions (n,) in X_m, NaN where a point failed; seconds per period; timings; why.

    `steps` are attempted ones, a period in the mean, of the code that works in lanes.
    """

    x: np.ndarray
    seconds: np.ndarray
    runs: int
    reason: str = ""
    out_of_time: bool = False
    steps: float | None = None


class Series(NamedTuple):
    """A solver bound to its points: their reference, the run at a tolerance, and tolerances."""

    reference: np.ndarray
    run: Callable[[float, int], Run]
    ladder: tuple[float, ...] = OWN_LADDER


def one_by_one(points: np.ndarray) -> Series:
    """Return the scalar code of this package as a series, one call a point."""

    def run(rtol: float, runs: int) -> Run:
        options = Options(rtol=rtol)
        x = [_end(row, options) for row in points]
        seconds, done = zip(
            *(_shortest(partial(_end, row, options), runs) for row in points), strict=True
        )
        return Run(_scaled(points, x), np.array(seconds) / PERIODS, min(done), "status not ok")

    return Series(reference(points.tobytes()), run)


@cache
def reference(rows: bytes) -> np.ndarray:
    """Return end positions in X_m of rows (n, parameters), by the scalar code at its tolerance."""
    points = np.frombuffer(rows).reshape(-1, len(Parameters._fields))
    return _scaled(points, [_end(row, Options(rtol=REFERENCE_RTOL)) for row in points])


def _end(row: np.ndarray, options: Options) -> float:
    """Return x after all periods by the scalar code, NaN where it fails."""
    x, status = scalar_end(row, options, PERIODS)
    return x if status == 0 else math.nan


def in_lanes(points: np.ndarray) -> Series:
    """Return the ensemble code of this package as a series, on one processor."""

    def end(rtol: float) -> tuple[np.ndarray, float]:
        states, steps, statuses = end_states(points, PERIODS, Options(rtol=rtol))
        return np.where(statuses == 0, states[:, 0], np.nan), float(np.mean(steps)) / PERIODS

    def run(rtol: float, runs: int) -> Run:
        x, steps = end(rtol)
        seconds, done = _shortest(lambda: end(rtol), runs)
        each = np.array([seconds / (len(points) * PERIODS)])
        return Run(_scaled(points, x), each, done, "status not ok", steps=steps)

    return Series(reference(points.tobytes()), run)


def by_peer(name: str, worker: Worker, points: np.ndarray, limit: float) -> Series:
    """Return a peer as a series, one call a point."""

    def run(rtol: float, runs: int) -> Run:
        ends, done, last = [], runs, Failure("")
        for row in points:
            p = Parameters(*row)
            answer = worker.measure(p, starting_state(row), PERIODS, rtol, limit=limit, runs=runs)
            if isinstance(answer, Failure):
                last = answer
                ends.append((math.nan, math.nan))
            else:
                ends.append((answer.state[0], answer.seconds / PERIODS))
                done = min(done, answer.runs)
        x, seconds = np.array(ends).T
        return Run(_scaled(points, x), seconds, done, last.reason, last.out_of_time)

    return Series(reference(points.tobytes()), run, PEERS[name].ladder)


def _scaled(points: np.ndarray, x: Any) -> np.ndarray:
    return np.asarray(x) / np.abs(parameter(points, "drive_amplitude"))


def _shortest(call: Callable[[], Any], runs: int) -> tuple[float, int]:
    """Return the shortest of up to `runs` timings [s], and how many fitted into two seconds."""
    shortest, done = math.inf, 0
    while done < runs and (done == 0 or done * shortest < 2.0):
        begun = time.perf_counter()
        call()
        shortest, done = min(shortest, time.perf_counter() - begun), done + 1
    return shortest, done
