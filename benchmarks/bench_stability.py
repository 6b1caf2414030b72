"""Numerical stability, stress-tested: one table and three pictures for `docs/stability.md`.

Half an hour on two cores. Each question is a module of `benchmarks/stability/`.
"""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any

from common import arguments, finish
from stability import (
    acceleration,
    extremes,
    fixed_step,
    ladder,
    locked,
    long_run,
    references,
    stated,
    step_map,
    stiff_problems,
    watched,
)

# Two at a time; the longest first, so that no process is left alone with it.
QUESTIONS = {
    "watched": watched,
    "extremes": extremes,
    "acceleration": acceleration,
    "step_map": step_map,
    "long_run": long_run,
    "locked": locked,
    "fixed_step": fixed_step,
    "ladder": ladder,
    "references": references,
    "stated": stated,
    "stiff_problems": stiff_problems,
}


def main() -> None:
    asked = arguments(__doc__)
    results: dict[str, Any] = {}
    with ProcessPoolExecutor(2) as pool:
        begun = {pool.submit(_answer, name, asked.quick): name for name in QUESTIONS}
        for future in as_completed(begun):
            name = begun[future]
            results[name] = future.result()
            print(f"{name}: {results[name]['seconds_taken']:.0f} s", flush=True)
    finish("stability", {name: results[name] for name in QUESTIONS}, quick=asked.quick)


def _answer(name: str, quick: bool) -> dict[str, Any]:
    begun = time.perf_counter()
    found: dict[str, Any] = QUESTIONS[name].run(quick)
    return found | {"seconds_taken": time.perf_counter() - begun}


if __name__ == "__main__":
    main()
