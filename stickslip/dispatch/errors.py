"""What can befall workers."""

from __future__ import annotations


class ExecutorError(RuntimeError):
    """The workers cannot be had, or were lost; what is finished is kept."""


class WorkerMismatchError(ExecutorError):
    """A worker runs other sources than the one who asks: its numbers would not be the same."""


class WorkersLostError(RuntimeError):
    """Workers died; any of the blocks that have not come back may have killed them.

    Each of those blocks has seen the end of `deaths` workers.
    """

    def __init__(self, reason: str, deaths: int = 1) -> None:
        super().__init__(reason)
        self.deaths = deaths
