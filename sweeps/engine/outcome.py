"""What a sweep says: to the terminal on its way, and to its caller in the end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.status import Status


@dataclass(frozen=True)
class Outcome:
    """How a sweep ended.

    `statuses` counts the points of each status, `computed` those that this run added. `stopped` is
    the exit code where it ended early, with `reason`.
    """

    output: Path
    statuses: np.ndarray
    worst_error: float
    computed: int = 0
    seconds: float = 0.0
    kernel_seconds: float = 0.0
    doubts: tuple[int, int] = (0, 0)
    stopped: int | None = None
    reason: str = ""

    @property
    def points(self) -> int:
        """The number of points of the sweep."""
        return int(self.statuses.sum())

    @property
    def failures(self) -> int:
        """How many points ended, but not ok."""
        return self.points - int(self.statuses[Status.OK] + self.statuses[Status.PENDING])


@dataclass
class Console:
    """Where a sweep speaks: a line for each `say`; `confirm` asks, None where nobody can answer."""

    say: Callable[[str], None]
    confirm: Callable[[str], bool] | None = None
    progress: bool = True


def size_text(count: float) -> str:
    """A number of bytes as people say it."""
    for unit in ("bytes", "KiB", "MiB", "GiB"):
        if count < 1024 or unit == "GiB":
            break
        count /= 1024
    return f"{count:.0f} {unit}" if unit == "bytes" else f"{count:.1f} {unit}"
