"""Where the ticks of logarithmic axes are, of pages that are drawn in a browser."""

from __future__ import annotations

import math

_DECADES = 4  # of an axis on which 2 and 5 are named too


def round_numbers(low: float, high: float) -> list[float]:
    """1, 2, 5, 10 ... over a range; powers of ten where it is long."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    mantissas = (1, 2, 5) if last - first <= _DECADES else (1,)
    numbers = [mantissa * 10.0**power for power in range(first, last + 1) for mantissa in mantissas]
    return [number for number in numbers if low <= number <= high]
