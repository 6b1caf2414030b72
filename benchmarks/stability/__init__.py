"""Numerical stability, stress-tested: one module a question, each with `run(quick) -> dict`."""
