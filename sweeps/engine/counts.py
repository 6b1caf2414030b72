"""The progress of a sweep, its remaining time, and the blocks of its workers."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.blocks import Costs
from stickslip.dispatch.in_flight import InFlight
from stickslip.dispatch.stop import LONGEST_STOP, Stop
from stickslip.status import Status
from sweeps.engine.store import Store
from sweeps.files.columns import failures
from sweeps.human import clock, counted, duration, points_per_time

_SOON = 5.0  # seconds in flight that are not worth a word


def in_flight_text(in_flight: InFlight) -> str:
    """Return it as text, as in `512 points in flight, the oldest for 1:03`; nothing for none."""
    ages = in_flight.ages
    if not ages:
        return ""
    count, oldest = sum(points for points, _ in ages), ages[0][1]
    waited = f", the oldest for {clock(oldest)}" if oldest >= _SOON else ""
    return f"{counted(count, 'point')} in flight{waited}"


def stop_text(in_flight: InFlight) -> str:
    """Say what a stop waits for, and what it gives up; nothing where neither is."""
    awaited = in_flight.awaited
    lost = in_flight.points - awaited.points
    given_up = f"giving up {counted(lost, 'point')} that may take minutes, for the next run"
    longest = f"finishing {in_flight_text(awaited)}, for {LONGEST_STOP:.0f} s at most"
    finishing = longest if awaited.tasks else ""
    return "; ".join(filter(None, [finishing, given_up if lost else ""]))


class Counts:
    """The progress of a sweep of `total` points, and its remaining time.

    How many points are finished, and how they ended, is asked of the `store` that keeps them; here
    is counted what this run has added, and what it cost.
    """

    def __init__(self, total: int, store: Store) -> None:
        self.total = total
        self.goal = total  # of what is known to be needed: less while a grid is refined
        self.costs = Costs()
        self.in_flight = InFlight()
        self._store = store
        self._begun = time.monotonic()
        self._slots: Callable[[], int] = lambda: 1
        self._stop = Stop()

    def begin(self, slots: Callable[[], int], stop: Stop | None = None) -> None:
        """Start the clock, after compiling; `slots` tells how many workers there are now."""
        self._slots, self._stop = slots, stop or self._stop
        if not self.computed:
            self._begun = time.monotonic()

    @property
    def computed(self) -> int:
        """Points that this run has finished."""
        return self.costs.points

    @property
    def done(self) -> int:
        """Points that are finished, by this run or before."""
        return int(self._store.statuses.sum())

    @property
    def left(self) -> int:
        """Points that are not finished."""
        return self.total - self.done

    @property
    def failed(self) -> int:
        """Finished points that are not ok."""
        return failures(self._store.statuses)

    @property
    def seconds(self) -> float:
        """Seconds since this run began to compute."""
        return time.monotonic() - self._begun

    @property
    def rate(self) -> float:
        """Points a second, of this run."""
        return self.computed / max(self.seconds, 1e-9)

    @property
    def seconds_left(self) -> float | None:
        """The time until this run ends, on the workers of now.

        None while it is not known: before the first block is there, and where the last ones take
        longer than those before. Blocks in flight count as partly done: without news it falls, or
        stays.
        """
        if not self.computed:
            return None
        slots, cost = self._slots(), self.costs.seconds / self.computed
        running = self.in_flight.ages[:slots]
        rest = [max(cost * points - age, 0.0) for points, age in running]
        spent = sum(cost * points for points, _ in running) - sum(rest)
        ahead = self.in_flight.points if self._stop.reason else self.goal - self.done
        return max((cost * ahead - spent) / slots, *rest, 0.0) or None

    def as_dict(self) -> dict[str, Any]:
        """Return the same for a heartbeat."""
        statuses, left = self._store.statuses.copy(), self.seconds_left
        statuses[Status.PENDING] = self.total - statuses.sum()
        return tally(statuses) | {
            "computed": self.computed,
            "seconds": round(self.seconds, 3),
            "points_per_second": round(self.rate, 3),
            "seconds_left": None if left is None else round(left, 1),
            "slots": self._slots(),
        }

    @property
    def headline(self) -> str:
        """The state as text: `120/1200 points, 0 failed, 1:20 elapsed`."""
        return (
            f"{self.done}/{self.goal} points, {self.failed} failed, {clock(self.seconds)} elapsed"
        )

    @property
    def outlook(self) -> str:
        """Rate, remaining time and points in flight as text, as far as they are known."""
        in_flight = in_flight_text(self.in_flight)
        parts = ["stopping"] if self._stop.reason and in_flight else []
        if self.computed:
            parts.append(points_per_time(self.rate))
        if left := self.seconds_left:
            parts.append(f"about {duration(left)} left")
        return ", ".join([*parts, in_flight] if in_flight else parts)


def tally(statuses: NDArray[np.int64]) -> dict[str, Any]:
    """Count the points of each status by its name; `statuses` (128,) has how many there are."""
    named = {s.name.lower(): int(statuses[s]) for s in Status if statuses[s]}
    pending, points = named.pop("pending", 0), int(statuses.sum())
    return {
        "points": points,
        "done": points - pending,
        "failed": failures(statuses),
        "pending": pending,
        "statuses": named,
    }
