"""How long a sweep takes: from the cost of some blocks, with the interval that they allow."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sweeps.engine.progress import duration

# Two-sided 95 % quantiles of Student's distribution, by the degrees of freedom.
_STUDENT = (12.7, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23)
_NORMAL = 1.96


@dataclass(frozen=True)
class Estimate:
    """A time in seconds with its 95 % interval."""

    seconds: float
    low: float
    high: float

    def __str__(self) -> str:
        """As it is printed: `1 min 35 s (1 min 20 s to 1 min 50 s)`."""
        if math.isinf(self.high):
            return f"about {duration(self.seconds)}"
        return f"about {duration(self.seconds)} ({duration(self.low)} to {duration(self.high)})"


class Costs:
    """The cost of a point as seen in finished blocks, and how much it differs between them."""

    def __init__(self) -> None:
        self.blocks = 0
        self.seconds = 0.0
        self.points = 0
        self._squares = [0.0, 0.0, 0.0]  # of seconds, of both, of points

    def learn(self, points: int, seconds: float) -> None:
        """Take in a finished block."""
        self.blocks += 1
        self.seconds += seconds
        self.points += points
        for i, product in enumerate((seconds**2, seconds * points, points**2)):
            self._squares[i] += product

    def estimate(self, points: int, slots: int) -> Estimate:
        """The time for so many points on so many cores; a ratio estimate over the blocks seen."""
        mean = self.seconds / max(self.points, 1)
        time = mean * points / slots
        if self.blocks < 2:
            return Estimate(time, 0.0, math.inf)
        # Variance of a ratio of totals: the residuals of the blocks about the common ratio.
        ss, sp, pp = self._squares
        residuals = max(ss - 2.0 * mean * sp + mean**2 * pp, 0.0)
        spread = math.sqrt(residuals * self.blocks / (self.blocks - 1)) / self.points
        freedom = self.blocks - 2
        quantile = _STUDENT[freedom] if freedom < len(_STUDENT) else _NORMAL
        margin = quantile * spread * points / slots
        return Estimate(time, max(time - margin, 0.0), time + margin)
