"""The end of a sweep: its result file, and its outcome for the caller."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip.status import Status
from sweeps.engine.existing import Target
from sweeps.engine.part import Part
from sweeps.exits import Exit
from sweeps.files.atomic import StorageError, fingerprint
from sweeps.files.attributes import breaks_of, global_attributes
from sweeps.files.columns import failures
from sweeps.files.journal import Journal
from sweeps.files.results import Written, try_writing, write_result
from sweeps.files.run_folder import RunFolder


@dataclass(frozen=True)
class Outcome:
    """The outcome of a sweep, or of a part of one.

    `statuses` (128,) counts the points of each status, `computed` those that this run added;
    `worst_error` and `statistical_error` are those of `Written`.
    `suspicious` counts points whose power balance, and whose stress, looks wrong without being
    impossible. `stopped` is the exit code where it ended early, with `reason`.
    """

    output: Path
    statuses: np.ndarray
    worst_error: float
    computed: int = 0
    seconds: float = 0.0
    kernel_seconds: float = 0.0
    suspicious: tuple[int, int] = (0, 0)
    stopped: Exit | None = None
    reason: str = ""
    part: Part | None = None
    statistical_error: float = math.nan

    @property
    def points(self) -> int:
        """The number of points of the sweep."""
        return int(self.statuses.sum())

    @property
    def failures(self) -> int:
        """The number of points that ended, but not ok."""
        return failures(self.statuses)


@dataclass
class Console:
    """The function with which a sweep prints a line, and whether it shows progress."""

    say: Callable[[str], None]
    progress: bool = True


@dataclass(frozen=True)
class JournaledResult:
    """The result file that a journal makes; its methods raise StorageError.

    `before` is the fingerprint of the output when the sweep began.
    """

    target: Target
    journal: Journal
    folder: RunFolder
    before: list[int] | None

    def try_writing(self) -> None:
        """Write it without its numbers, and take it away: better to fail before the sweep."""
        try_writing(
            self.target.grid,
            self.target.chunks,
            self.attributes(),
            self.folder.result,
        )

    def write(self, path: Path | None = None) -> Written:
        """Write it with what the journal holds, the rest `pending`; to `path` if it is made aside.

        An output that has changed since the sweep began is left alone.
        """
        output = path or self.folder.output
        if path is None and fingerprint(output) != self.before:
            raise StorageError(
                f"{output} was made or changed by somebody else while the sweep ran, and is left "
                f"alone; what is computed is kept in {self.folder.path}. Move {output.name} away "
                "and give the same command again, or choose another -o"
            )
        statuses = self.journal.statuses.copy()
        statuses[Status.PENDING] = self.target.grid.size - statuses.sum()
        return write_result(
            self.target.grid,
            self.target.chunks,
            self.journal.chunk,
            statuses,
            self.attributes(),
            self.folder.result,
            output,
        )

    def attributes(self) -> dict[str, str]:
        """Return the global attributes."""
        manifest = self.journal.manifest
        config = self.target.config
        attributes = global_attributes(config) | breaks_of(config, self.journal.statuses)
        if earlier := manifest.get("history"):
            attributes["history"] += "\n" + earlier
        if sample := manifest.get("sample"):
            attributes["sample"] = sample
        if manifest.get("processors"):
            attributes["processor"] = ", ".join(manifest["processors"])
        if self.target.part and np.array_equal(self.journal.done, self.target.needed):
            attributes["part"] = str(self.target.part)
        return attributes
