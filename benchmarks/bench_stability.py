"""Numerical stability, stress-tested: what is wrong and looks right.

Half an hour on two cores. Each question is a module of `benchmarks/stability/`.
"""

from __future__ import annotations

from importlib import import_module

from shared.measuring import measure

# Two at a time; the longest first, so that no process is left alone with it.
NAMES = (
    "watched", "extremes", "freezing", "acceleration", "step_map", "long_run", "locked",
    "fixed_step", "ladder", "references", "multipliers", "stated", "stiff_problems", "work",
)  # fmt: skip
QUESTIONS = {name: import_module(f"stability.{name}").run for name in NAMES}

if __name__ == "__main__":
    measure("stability", __doc__, QUESTIONS, processes=2)
