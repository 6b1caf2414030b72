"""Seconds of calls, by medians and minima."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any


def pin() -> None:
    """Keep this process on one processor, where the system allows it."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """Return the value of a call, and its seconds."""
    begun = time.perf_counter()
    value = call()
    return value, time.perf_counter() - begun


def median_seconds(call: Callable[[], Any], runs: int) -> float:
    """Return median of so many timings [s]."""
    return statistics.median(timed(call)[1] for _ in range(runs))


def medians_in_turn(calls: Sequence[Callable[[], Any]], runs: int) -> list[float]:
    """Return medians of timings [s] of each call, in turn: what disturbs one disturbs all."""
    rounds = [[timed(call)[1] for call in calls] for _ in range(runs)]
    return [statistics.median(times) for times in zip(*rounds, strict=True)]


def fastest(run: Callable[[], object], count: float, repeats: int = 7) -> float:
    """Return nanoseconds of CPU time for each of `count` items: the least of several runs."""
    times = []
    for _ in range(repeats):
        begun = time.thread_time_ns()
        run()
        times.append(time.thread_time_ns() - begun)
    return min(times) / count
