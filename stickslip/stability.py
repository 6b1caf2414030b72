"""Is a fixed step stable? What is asked before anything is computed.

An explicit step beyond 2/(fastest rate) need not overflow: it gives finite, plausible and wrong
amplitudes. So the rates are bounded from the parameters alone, with the speed of a free slip
instead of the drive's, and an unstable step is refused. The infinite viscous slope of a
pseudoplastic fluid at V = v is left out: its chatter stays of the order of the step.
"""

from __future__ import annotations

from decimal import ROUND_FLOOR, Context

import numpy as np

from stickslip.kernels import fastest_rates
from stickslip.options import DEFAULTS

ACCURATE_PART = 0.25
"""Part of the largest stable step from which a fixed step is stable but inaccurate."""


def largest_stable_step(points: np.ndarray, law: str = DEFAULTS.friction) -> np.ndarray:
    """Largest fixed step [s] that is not refused, for each row of parameters (n, parameters)."""
    return fastest_rates.largest_stable_step(points, law)


def step_as_text(step: float) -> str:
    """Two digits of a largest step, rounded down: typed in, it is allowed."""
    return f"{Context(prec=2, rounding=ROUND_FLOOR).create_decimal_from_float(step):g}"


def static_strength(points: np.ndarray, strains: int = fastest_rates.STRAINS) -> np.ndarray:
    """Largest static elastic stress a phi_plus^2 eps [Pa] of a solid film, for each row.

    `points` (n, parameters) -> (n,). Looked for over so many strains: fewer give less, never more.
    """
    points = np.ascontiguousarray(np.atleast_2d(points), dtype=float)
    strengths = np.empty(len(points))
    fastest_rates.write_static_strengths(points, strains, strengths)
    return strengths
