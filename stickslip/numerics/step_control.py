"""Step control: the length of the next step, from the errors of the last two."""

from __future__ import annotations

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.compiled.fields import make_map
from stickslip.numerics.linear import larger

# The aim is below the tolerance, so that few steps are rejected. A step never changes by much more
# than an order of magnitude (Hairer & Wanner).
_SAFETY = 0.9
_GROWTH, _SHRINKAGE = 6.0, 0.1

# All errors below this fraction of the tolerance have the same effect, that the step may grow.
_SMALLEST = 1e-10

# All errors above this multiple make the step shrink; the roots below cannot handle infinity.
_LARGEST = 1e300

START = 1e-4 ** (1.0 / 16.0)
"""The memory of errors before the first step."""


@inline
def inverse_fourth_root(x: float) -> float:
    """x^(-1/4) to within 5e-5 for normal `x` > 0, which is enough for step control."""
    bits = np.float64(x).view(np.uint64)
    r = np.uint64(np.uint64(0x4FEB3FA8A5A9C1D4) - (bits >> np.uint64(2))).view(np.float64)
    for _ in range(2):
        square = r * r
        r = r * (1.25 - 0.25 * x * (square * square))
    return r


@inline
def _limited(factor: float) -> float:
    return larger(_GROWTH if factor > _GROWTH else factor, _SHRINKAGE)


@inline
def after_rejection(error: float) -> float:
    """Ratio of the next step to a rejected one, for an error estimate of fourth order in the step.

    It is a quarter after NaN, so that the next step may avoid an overflow.
    """
    finite = _LARGEST if error > _LARGEST else error
    factor = _limited(_SAFETY * inverse_fourth_root(finite))
    return factor if error == error else 0.25


@inline
def after_success(error: float, remembered: float) -> tuple[float, float]:
    """Ratio of the next step to an accepted one, and the memory for the step after it.

    A PI controller (Gustafsson), error^(-1/8) before^(1/16): the step responds to the error, at
    half the possible speed, and to its change. `remembered` is before^(1/16).
    """
    inverse = inverse_fourth_root(larger(error, _SMALLEST))
    return _limited(_SAFETY * np.sqrt(inverse) * remembered), inverse_fourth_root(inverse)


unlimited = make_map("unlimited", "p, y0, f0, y1, f1, h", ("1.0", "inf"), {"inf": np.inf})
"""No limits of steps: the whole step is allowed, and a step of any length after it."""
