"""Work of which only the latest counts."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest
from support.sweeps.processes import wait_until

from sweeps.views.explore import latest
from sweeps.views.explore.latest import Latest


class Desk:
    """Jobs that end when they are told to."""

    def __init__(self) -> None:
        self.begun: list[str] = []
        self.done: list[str] = []
        self._ends: dict[str, threading.Event] = {}
        self.latest: Latest[str, str] = Latest(self._work, self.done.append)

    def submit(self, job: str) -> None:
        self._ends[job] = threading.Event()
        self.latest.submit(job)

    def end(self, *jobs: str) -> None:
        for job in jobs:
            self._ends[job].set()

    def end_all(self) -> None:
        self.end(*self._ends)

    def _work(self, job: str) -> str:
        self.begun.append(job)
        assert self._ends[job].wait(60)
        return job.upper()


@pytest.fixture
def patience(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    return lambda seconds: monkeypatch.setattr(latest, "_PATIENCE", seconds)


@pytest.fixture
def desk() -> Iterator[Desk]:
    desk = Desk()
    yield desk
    desk.end_all()
    desk.latest.close()


def test_a_job_that_waits_is_passed_over_for_a_later_one(
    desk: Desk, patience: Callable[[float], None]
):
    patience(1e6)
    desk.submit("a")
    wait_until(lambda: desk.begun == ["a"])
    for job in "bcd":
        desk.submit(job)
    assert desk.latest.waiting is not None
    desk.end("a", "d")
    wait_until(lambda: desk.done == ["A", "D"])
    assert desk.begun == ["a", "d"]
    assert desk.latest.waiting is None


def test_a_long_job_does_not_keep_the_next_one_waiting(
    desk: Desk, patience: Callable[[float], None]
):
    patience(0.0)
    desk.submit("long")
    wait_until(lambda: desk.begun == ["long"])
    desk.submit("next")
    desk.end("next")
    wait_until(lambda: desk.done == ["NEXT"])
    assert desk.latest.waiting is None
    desk.end("long")  # too late: a newer result is there
    desk.submit("last")
    desk.end("last")
    wait_until(lambda: desk.done == ["NEXT", "LAST"])


def test_while_all_threads_are_busy_the_latest_waits(desk: Desk, patience: Callable[[float], None]):
    patience(0.0)
    jobs = [f"job {number}" for number in range(len(desk.latest.threads))]
    for number, job in enumerate(jobs, start=1):
        desk.submit(job)
        wait_until(lambda number=number: len(desk.begun) == number)
    desk.submit("more")
    desk.submit("last")
    desk.end("last", jobs[0])
    wait_until(lambda: "LAST" in desk.done)
    assert desk.begun == [*jobs, "last"]


def test_closing_frees_the_threads(desk: Desk, patience: Callable[[float], None]):
    patience(1e6)
    desk.submit("a")
    wait_until(lambda: desk.begun == ["a"])
    desk.submit("b")
    desk.latest.close()
    desk.end("a", "b")
    wait_until(lambda: not any(thread.is_alive() for thread in desk.latest.threads))
    assert desk.begun == ["a"]
    assert desk.done == []
