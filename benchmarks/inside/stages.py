"""Where the time of a point goes: the stages of `compute_orbits`, each with its clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

from stickslip.compiled.simd import LANES
from stickslip.kernels.adaptive import driver, queues, tangents
from stickslip.kernels.adaptive.passes import ATTEMPTED

Seconds = dict[str, float]

# Attempts of all lanes at a time while they are counted: few against those of a pass.
_SLICE = 200

STAGES = {
    "search": (driver, "_settle"),
    "watch": (driver, "watch"),
    "measurements": (driver, "work_through"),
    "mirror image": (tangents, "symmetric"),
    "multiplier": (tangents, "neighbours_of"),
    "single periods": (driver, "_spreads"),
    "results": (driver, "_write_results"),
}
"""Functions by what they are for; one that another calls is taken out of the other's time."""


@contextmanager
def timed_stages() -> Iterator[Seconds]:
    """The seconds of each stage, filled in by all calls of the adaptive method meanwhile."""
    seconds: Seconds = dict.fromkeys(STAGES, 0.0)
    running: list[str] = []
    with ExitStack() as stack:
        for stage, (module, name) in STAGES.items():
            function = _clocked(getattr(module, name), stage, seconds, running)
            stack.enter_context(patch.object(module, name, function))
        yield seconds


def _clocked(
    function: Callable[..., Any], stage: str, seconds: Seconds, running: list[str]
) -> Callable[..., Any]:
    inner = stage == "measurements"  # the search and the watch go through the same queue

    def clocked(*arguments: Any, **options: Any) -> Any:
        if inner and running:
            return function(*arguments, **options)
        running.append(stage)
        begun = time.perf_counter()
        try:
            return function(*arguments, **options)
        finally:
            took = time.perf_counter() - begun
            running.pop()
            seconds[stage] += took
            if running:
                seconds[running[-1]] -= took

    return clocked


@dataclass
class LanesUsed:
    """Steps attempted in lanes, and those that full lanes would have attempted meanwhile."""

    attempted: int = 0
    possible: int = 0

    @property
    def fullness(self) -> float:
        """The part of the lanes that was at work."""
        return self.attempted / max(self.possible, 1)


@contextmanager
def lanes_used() -> Iterator[LanesUsed]:
    """Count the steps of all passes of the adaptive method meanwhile, to a slice of attempts."""
    used = LanesUsed()
    kernel_of = queues.pass_kernel

    def counted(family: Any) -> Callable[..., int]:
        kernel = kernel_of(family)

        def work(queue: Any, lanes: Any, task: Any, attempts: int) -> int:
            before = int(queue.counts[:, ATTEMPTED].sum())
            left = kernel(queue, lanes, task, attempts)
            used.attempted += int(queue.counts[:, ATTEMPTED].sum()) - before
            used.possible += attempts * LANES
            return left

        return work

    with patch.object(queues, "pass_kernel", counted), patch.object(queues, "_WORK", _SLICE):
        yield used
