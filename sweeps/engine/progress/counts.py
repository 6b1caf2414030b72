"""How far a sweep is, and how long the rest takes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from sweeps.engine.order.product import Costs
from sweeps.engine.progress.in_flight import InFlight
from sweeps.engine.signals import Stop
from sweeps.files.columns import failures
from sweeps.human import clock, duration, points_per_time

_LONG_SILENCE = 10.0  # seconds without a finished block

# A block that takes so many times what was expected makes the time left a guess.
_OVERDUE = 2.0


class Counts:
    """How far a sweep of `total` points is, by status, and how long the rest takes.

    `statuses` (128,), the journal's own, which counts along, has the points finished before.
    """

    def __init__(self, total: int, statuses: NDArray[np.int64]) -> None:
        self.total = total
        self.found = int(statuses.sum())
        self.costs = Costs()
        self.in_flight = InFlight()
        self.goal = total  # of what is known to be needed: less while a grid is refined
        self._statuses = statuses
        self._begun = time.monotonic()
        self._slots: Callable[[], int] = lambda: 1
        self._stop = Stop()

    def begin(self, slots: Callable[[], int], stop: Stop | None = None) -> None:
        """Start the clock, after compiling; `slots` tells how many workers there are now."""
        self._slots, self._stop = slots, stop or self._stop
        if not self.computed:
            self._begun = time.monotonic()

    def expect(self, points: int) -> None:
        """Say how many points are to be computed next."""
        self.goal = self.done + points

    def fill(self, points: int) -> None:
        """Count so many points as there without having been computed."""
        self.found += points
        self.goal = self.total

    def lose(self, points: int) -> None:
        """Count so many finished points as not there any more."""
        self.found -= points

    @property
    def computed(self) -> int:
        """Points that this run has finished."""
        return self.costs.points

    @property
    def done(self) -> int:
        """Points that are finished, by this run or before."""
        return self.found + self.computed

    @property
    def left(self) -> int:
        """Points that are not finished."""
        return self.total - self.done

    @property
    def failed(self) -> int:
        """Finished points that are not ok."""
        return failures(self._statuses)

    @property
    def seconds(self) -> float:
        """Since this run began to compute."""
        return time.monotonic() - self._begun

    @property
    def rate(self) -> float:
        """Points a second, of this run."""
        return self.computed / max(self.seconds, 1e-9)

    @property
    def seconds_left(self) -> float | None:
        """The time until this run ends, on the workers of now; None while nothing is known.

        Blocks in flight count as partly done: without news it falls, or stays.
        """
        if not self.computed:
            return None
        slots, cost = self._slots(), self.costs.seconds / self.computed
        running = self.in_flight.ages[:slots]
        rest = [max(cost * points - age, 0.0) for points, age in running]
        spent = sum(cost * points for points, _ in running) - sum(rest)
        ahead = self.in_flight.points if self._stop.reason else self.goal - self.done
        return max((cost * ahead - spent) / slots, *rest, 0.0)

    @property
    def is_silent(self) -> bool:
        """Whether no block has come back for so long that the time left cannot be told."""
        ages = self.in_flight.ages
        if not ages:
            return False
        points, age = ages[0]
        expected = points * self.costs.seconds / max(self.computed, 1)
        return min(age, self.in_flight.silence) >= _LONG_SILENCE and age > _OVERDUE * expected

    def as_dict(self) -> dict[str, Any]:
        """The same for a heartbeat."""
        statuses, left = self._statuses.copy(), None if self.is_silent else self.seconds_left
        statuses[Status.PENDING] = self.total - statuses.sum()
        counted = tally(statuses)
        return counted | {
            "computed": counted["done"] - self.found,  # of the same moment
            "seconds": round(self.seconds, 3),
            "points_per_second": round(self.rate, 3),
            "seconds_left": None if left is None else round(left, 1),
            "slots": self._slots(),
        }

    @property
    def so_far(self) -> str:
        """`120/1200 points, 0 failed, 1:20 elapsed`."""
        return (
            f"{self.done}/{self.goal} points, {self.failed} failed, {clock(self.seconds)} elapsed"
        )

    @property
    def outlook(self) -> str:
        """How fast it goes, how long the rest takes and what is in flight, as far as is known."""
        in_flight = str(self.in_flight)
        parts = ["stopping"] if self._stop.reason and in_flight else []
        if self.is_silent:
            since = f"for {clock(self.in_flight.silence)}" if self.computed else "yet"
            parts.append(f"no block has finished {since}")
        elif self.computed:
            parts.append(points_per_time(self.rate))
            if left := self.seconds_left:
                parts.append(f"about {duration(left)} left")
        return ", ".join([*parts, in_flight] if in_flight else parts)

    def __str__(self) -> str:
        """A line of a log."""
        return ", ".join(filter(None, [self.so_far, self.outlook]))


def tally(statuses: NDArray[np.int64]) -> dict[str, Any]:
    """How many points of which status there are, by name; `statuses` (128,) counts them."""
    named = {s.name.lower(): int(statuses[s]) for s in Status if statuses[s]}
    pending, points = named.pop("pending", 0), int(statuses.sum())
    return {
        "points": points,
        "done": points - pending,
        "failed": failures(statuses),
        "pending": pending,
        "statuses": named,
    }
