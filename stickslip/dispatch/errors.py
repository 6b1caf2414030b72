"""The errors of workers."""

from __future__ import annotations


class ExecutorError(RuntimeError):
    """There are no workers, or they were lost; finished points are kept."""


class WorkerMismatchError(ExecutorError):
    """The sources of a worker differ from those of this process, and so might its numbers."""


class WorkersLostError(RuntimeError):
    """Workers died, and any block that has not come back may have killed them.

    Each such block has cost `deaths` workers.
    """

    def __init__(self, reason: str, deaths: int = 1) -> None:
        super().__init__(reason)
        self.deaths = deaths
