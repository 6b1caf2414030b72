"""Where the time of a point goes: the stages of `compute_orbits`, each with its clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any
from unittest.mock import patch

from stickslip.kernels.adaptive import conversion, driver, tangents

Seconds = dict[str, float]

STAGES = {
    "search": (driver, "_settle"),
    "watch": (driver, "_watch"),
    "measurements": (driver, "work_through"),
    "mirror image": (tangents, "symmetric"),
    "multiplier": (tangents, "multipliers_of"),
    "single periods": (driver, "_spreads"),
    "results": (conversion, "write_results"),
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
