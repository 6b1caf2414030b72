"""Derivatives by central differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def slope_of(function: Callable[[float], float], x: float, step: float) -> float:
    """Return the derivative at `x`, to fourth order in the step."""
    values = [function(x + times * step) for times in (-2, -1, 1, 2)]
    return float(np.dot([1, -8, 8, -1], values)) / (12 * step)
