"""Numerical stability, stress-tested: what is wrong and looks right.

Half an hour on two cores. Each question is a module of `benchmarks/stability/`.
"""

from __future__ import annotations

from shared.measuring import measure
from stability import (
    acceleration,
    extremes,
    fixed_step,
    freezing,
    ladder,
    locked,
    long_run,
    multipliers,
    references,
    stated,
    step_map,
    stiff_problems,
    watched,
    work,
)

# Two at a time; the longest first, so that no process is left alone with it.
QUESTIONS = {
    "watched": watched.run,
    "extremes": extremes.run,
    "freezing": freezing.run,
    "acceleration": acceleration.run,
    "step_map": step_map.run,
    "long_run": long_run.run,
    "locked": locked.run,
    "fixed_step": fixed_step.run,
    "ladder": ladder.run,
    "references": references.run,
    "multipliers": multipliers.run,
    "stated": stated.run,
    "stiff_problems": stiff_problems.run,
    "work": work.run,
}

if __name__ == "__main__":
    measure("stability", __doc__, QUESTIONS, processes=2)
