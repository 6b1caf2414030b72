"""Numerical stability, stress-tested: one table and three pictures for `docs/stability.md`.

Twenty minutes or so on two cores. Each question is a module of `benchmarks/stability/`.
"""

from __future__ import annotations

import time
from typing import Any

from common import arguments, finish
from stability import (
    acceleration,
    extremes,
    ladder,
    locked,
    long_run,
    references,
    step_map,
    stiff_problems,
)

QUESTIONS = {
    "ladder": ladder,
    "references": references,
    "locked": locked,
    "step_map": step_map,
    "extremes": extremes,
    "acceleration": acceleration,
    "long_run": long_run,
    "stiff_problems": stiff_problems,
}


def main() -> None:
    asked = arguments(__doc__)
    results: dict[str, Any] = {}
    for name, module in QUESTIONS.items():
        begun = time.perf_counter()
        results[name] = module.run(asked.quick)
        results[name] |= {"seconds_taken": time.perf_counter() - begun}
        print(f"{name}: {results[name]['seconds_taken']:.0f} s", flush=True)
    finish("stability", results, quick=asked.quick)


if __name__ == "__main__":
    main()
