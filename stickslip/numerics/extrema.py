"""Extrema of an observable inside a step, found on the continuous extension."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit

# Where a step is looked at: evenly for the quadrature (Boole), and close to both ends so that an
# extremum just inside an end is noticed.
NODES = (0.0, 1.0 / 64.0, 0.25, 0.5, 0.75, 63.0 / 64.0, 1.0)
COUNT = len(NODES)
BOOLE_WEIGHTS = (7.0 / 90.0, 0.0, 32.0 / 90.0, 12.0 / 90.0, 32.0 / 90.0, 0.0, 7.0 / 90.0)

_GOLDEN = 0.3819660112501051
# The bracket shrinks by 0.618 each time: after 40 its width is 1e-9 of a step, and the value at
# a smooth maximum is then exact to rounding.
_SECTIONS = 40


def make_extremum(along: Callable[..., float]) -> Any:
    """The search for an extremum of along(p, step, theta) in a step, 0 <= theta <= 1.

    What comes back maps (p, step, sign, values, record) to the larger of `record` and the maximum
    of sign*along, where `values` holds along at NODES, shape (COUNT,). Only an interior best node
    that could beat the record is searched, by golden section between its neighbours.
    """

    @jit
    def maximum(p: Any, step: Any, sign: float, low: float, high: float) -> float:
        left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
        at_left, at_right = sign * along(p, step, left), sign * along(p, step, right)
        for _ in range(_SECTIONS):
            if at_left > at_right:
                high, right, at_right = right, left, at_left
                left = low + _GOLDEN * (high - low)
                at_left = sign * along(p, step, left)
            else:
                low, left, at_left = left, right, at_right
                right = high - _GOLDEN * (high - low)
                at_right = sign * along(p, step, right)
        return max(at_left, at_right)

    @jit
    def extremum(p: Any, step: Any, sign: float, values: np.ndarray, record: float) -> float:
        best = 0
        for node in range(1, COUNT):
            if sign * values[node] > sign * values[best]:
                best = node
        record = max(record, sign * values[best])
        if 0 < best < COUNT - 1:
            low, high = NODES[best - 1], NODES[best + 1]
            spread = abs(values[best] - values[best - 1]) + abs(values[best] - values[best + 1])
            if sign * values[best] + spread >= record:
                record = max(record, maximum(p, step, sign, low, high))
        return record

    return extremum


@inline
def vertex(x0: float, x1: float, x2: float, y0: float, y1: float, y2: float) -> float:
    """Where the parabola through three points has its vertex; NaN or inf for a straight line."""
    left, right = (y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1)
    return 0.5 * (x0 + x1) - 0.5 * left * (x2 - x0) / (right - left)
