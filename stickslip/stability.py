"""Stability of a fixed step, checked before a computation starts.

An explicit step beyond 2/(fastest rate) need not overflow: it can give finite, plausible and wrong
amplitudes. So the rates are bounded from the parameters alone, with the speed of a free slip
instead of the drive's, and an unstable step is refused. The bound ignores the infinite
viscous slope of a pseudoplastic fluid at V = v, because the chatter there stays of the order of the
step.
"""

from __future__ import annotations

from decimal import ROUND_FLOOR, Context

from stickslip.kernels.fastest_rates import largest_stable_step, static_strength

__all__ = ["ACCURATE_PART", "largest_stable_step", "static_strength", "step_as_text"]

ACCURATE_PART = 0.25
"""Fraction of the largest stable step above which a fixed step is stable but inaccurate."""


def step_as_text(step: float) -> str:
    """Return the largest step to two digits, rounded down so that a user can type it."""
    return f"{Context(prec=2, rounding=ROUND_FLOOR).create_decimal_from_float(step):g}"
