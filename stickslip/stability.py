"""Stability of a fixed step, checked before anything is computed.

An explicit step beyond 2/(fastest rate) need not overflow: it can give finite, plausible and wrong
amplitudes. So the rates are bounded from the parameters alone, with the speed of a free slip
instead of the drive's, and an unstable step is refused. The infinite viscous slope of a
pseudoplastic fluid at V = v is left out: the chatter it causes stays of the order of the step.
"""

from __future__ import annotations

from decimal import ROUND_FLOOR, Context

import numpy as np

from stickslip.kernels import fastest_rates
from stickslip.options import DEFAULTS

ACCURATE_PART = 0.25
"""Fraction of the largest stable step above which a fixed step is stable but inaccurate."""


def largest_stable_step(points: np.ndarray, law: str = DEFAULTS.friction) -> np.ndarray:
    """Return the largest fixed step [s] that is accepted, for each of `points` (n, parameters)."""
    return fastest_rates.largest_stable_step(points, law)


def step_as_text(step: float) -> str:
    """Return two digits of a largest step, rounded down, so that typed back in it is accepted."""
    return f"{Context(prec=2, rounding=ROUND_FLOOR).create_decimal_from_float(step):g}"


def static_strength(points: np.ndarray, strains: int = fastest_rates.STRAINS) -> np.ndarray:
    """Return the largest static elastic stress a phi_plus^2 eps [Pa] of solid films, (n,).

    `points` (n, parameters). The maximum over `strains` values: with fewer it is never larger.
    """
    points = np.ascontiguousarray(np.atleast_2d(points), dtype=float)
    strengths = np.empty(len(points))
    fastest_rates.write_static_strengths(points, strains, strengths)
    return strengths
