"""Progress: a bar on a terminal, plain lines in a log, nothing where it is not wanted."""

from __future__ import annotations

import io
import re
import sys
import threading

import numpy as np
import pytest

from stickslip import Status
from sweeps.engine import progress
from sweeps.engine.progress import Counts, make_progress


class Clock:
    """Monotonic time that goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Log(io.StringIO):
    """Tells when so many lines are there."""

    def __init__(self, wanted: int) -> None:
        super().__init__()
        self._wanted, self.there = wanted, threading.Event()

    def write(self, text: str) -> int:
        written = super().write(text)
        if self.getvalue().count("\n") >= self._wanted:
            self.there.set()
        return written


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(progress, "time", clock)
    return clock


def found(**by_status: int) -> np.ndarray:
    statuses = np.zeros(128, dtype=np.int64)
    for name, count in by_status.items():
        statuses[Status[name.upper()]] = count
    return statuses


def advanced(counts: Counts, statuses: np.ndarray, seconds: float = 0.0, **by_status: int) -> None:
    """As a sweep does it: the journal counts in the statuses, then a block is told."""
    statuses += found(**by_status)
    counts.costs.learn(sum(by_status.values()), seconds)


# --- the numbers ---


def test_what_was_found_and_what_this_run_adds_is_counted(clock: Clock) -> None:
    statuses = found(ok=30, diverged=2)
    counts = Counts(100, statuses)
    clock.now += 77.0  # compiling
    workers = 1
    counts.begin(lambda: workers)
    assert (counts.total, counts.found, counts.computed) == (100, 32, 0)
    assert (counts.done, counts.left, counts.failed) == (32, 68, 2)
    assert (counts.seconds, counts.rate, counts.seconds_left) == (0.0, 0.0, None)
    clock.now += 2.0
    advanced(counts, statuses, 3.4, ok=13, not_stationary=4)
    assert (counts.found, counts.computed, counts.done, counts.left) == (32, 17, 49, 51)
    assert (counts.failed, counts.seconds, counts.rate) == (6, 2.0, 8.5)
    assert counts.seconds_left == pytest.approx(51 * 3.4 / 17)
    workers = 2  # one more has come
    assert counts.seconds_left == pytest.approx(51 * 3.4 / 17 / 2)
    assert str(counts) == "49/100 points, 6 failed, 8.5 points/s, about 5.1 s left"
    advanced(counts, statuses, ok=51)
    assert (counts.left, counts.seconds_left) == (0, 0.0)


def test_a_heartbeat_tells_the_same_numbers(clock: Clock) -> None:
    statuses = found(ok=1)
    counts = Counts(10, statuses)
    assert counts.as_dict()["seconds_left"] is None
    clock.now += 4.0
    advanced(counts, statuses, 4.0, ok=1, step_limit=1)
    assert counts.as_dict() == {
        "points": 10,
        "done": 3,
        "failed": 1,
        "pending": 7,
        "computed": 2,
        "statuses": {"ok": 2, "step_limit": 1},
        "seconds": 4.0,
        "points_per_second": 0.5,
        "seconds_left": 14.0,
        "slots": 1,
    }


def test_without_a_computed_point_no_time_is_promised(clock: Clock) -> None:
    assert str(Counts(10, found(ok=4))) == "4/10 points, 0 failed, 0.0 points/s"


# --- lines in a log ---


def test_lines_come_every_few_seconds_whether_a_point_is_done_or_not(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = Log(3)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN_LINES", 0.005)
    statuses = found()
    counts = Counts(100, statuses)
    clock.now += 2.0
    advanced(counts, statuses, 2.0, ok=9, failed=1)
    with make_progress(counts):
        assert log.there.wait(60.0)
    lines = log.getvalue().splitlines()
    assert len(lines) >= 3
    assert set(lines) == {"10/100 points, 1 failed, 5.0 points/s, about 18.0 s left"}
    assert log.getvalue().replace("\n", "").isprintable()


@pytest.mark.parametrize("early", [True, False])
def test_after_the_end_no_line_comes(monkeypatch: pytest.MonkeyPatch, early: bool) -> None:
    log = Log(1)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN_LINES", 0.001)
    before = set(threading.enumerate())
    with make_progress(Counts(10, found())) as shown:
        (clockwork,) = set(threading.enumerate()) - before
        assert log.there.wait(60.0)
        if early:
            shown.stop()
    clockwork.join(60.0)
    assert not clockwork.is_alive()


def test_a_short_sweep_needs_no_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert progress._SECONDS_BETWEEN_LINES >= 2.0
    with make_progress(Counts(10, found())) as shown:
        shown.refresh()
        shown.stop()
        shown.start()
        shown.stop()
    assert capsys.readouterr() == ("", "")


def test_what_is_said_is_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    with make_progress(Counts(10, found())) as shown:
        shown.say("time left: [about] 3 min")
    assert capsys.readouterr() == ("", "time left: [about] 3 min\n")


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_nothing_where_nothing_is_wanted(
    monkeypatch: pytest.MonkeyPatch, stream: type[io.StringIO]
) -> None:
    monkeypatch.setattr(sys, "stderr", stream())
    monkeypatch.setattr(progress, "_SECONDS_BETWEEN_LINES", 0.001)
    before = threading.active_count()
    with make_progress(Counts(10, found()), wanted=False) as shown:
        assert threading.active_count() == before
        shown.refresh()
        shown.say("a line")
        shown.stop()
        shown.start()
        shown.stop()
    assert sys.stderr.getvalue() == ""


# --- the bar ---

HIDDEN, VISIBLE = "\x1b[?25l", "\x1b[?25h"


def terminal_of(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    return terminal


def last_line(text: str) -> str:
    plain = re.sub(r"\x1b\[[\d;?]*\w", "", text)
    return plain.rstrip("\n").split("\n")[-1].split("\r")[-1]


@pytest.mark.parametrize(
    ("total", "seconds", "expected"),
    [
        (4000, 10.0, "2500/4000 points, 3 failed, 250.0 points/s, 6.0 s left"),
        (20_000, 3.0, "2500/20000 points, 3 failed, 833.3 points/s, 21.0 s left"),
        (1_000_000, 3.0, "2500/1000000 points, 3 failed, 833.3 points/s, 19 min 57 s left"),
        (2500, 1.0, "2500/2500 points, 3 failed, 2500.0 points/s, 0.0 s left"),
    ],
)
def test_a_terminal_gets_a_bar_that_fits_and_gives_the_cursor_back(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, total: int, seconds: float, expected: str
) -> None:
    terminal, statuses = terminal_of(monkeypatch), found()
    counts = Counts(total, statuses)
    with make_progress(counts) as shown:
        clock.now += seconds
        advanced(counts, statuses, seconds, ok=2497, diverged=3)
        shown.refresh()
    text = terminal.getvalue()
    assert text.count(HIDDEN) == text.count(VISIBLE) == 1
    assert text.index(HIDDEN) < text.index(VISIBLE)
    assert expected in last_line(text)
    assert len(last_line(text)) <= 80


def test_the_bar_begins_with_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with make_progress(Counts(100, found(ok=30, failed=2))):
        pass
    assert "32/100 points, 2 failed," in last_line(terminal.getvalue())


def test_stopping_gives_the_terminal_back_once(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with make_progress(Counts(10, found())) as shown:
        shown.stop()
        stopped = terminal.getvalue()
        assert stopped.endswith("\n" + VISIBLE)
    assert terminal.getvalue() == stopped


def test_a_question_has_the_terminal_for_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with make_progress(Counts(10, found())) as shown:
        shown.stop()
        asked = terminal.getvalue()
        assert asked.endswith("\n" + VISIBLE)
        shown.refresh()
        assert HIDDEN not in terminal.getvalue()[len(asked) :]
        shown.start()
        assert HIDDEN in terminal.getvalue()[len(asked) :]
    assert terminal.getvalue().endswith(VISIBLE)


def test_what_is_said_stands_above_the_bar_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with make_progress(Counts(10, found())) as shown:
        shown.say("time left: [red] 3 min")
    plain = re.sub(r"\x1b\[[\d;?]*\w", "", terminal.getvalue())
    assert "time left: [red] 3 min\n" in plain
    assert "0/10 points" in last_line(terminal.getvalue())
