"""Progress: a bar on a terminal, plain lines in a log, nothing where it is not wanted."""

from __future__ import annotations

import io
import re
import sys

import pytest

from sweeps import progress
from sweeps.progress import duration, make_progress


class Clock:
    """Monotonic time that goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(progress, "time", clock)
    return clock


def test_lines_come_every_few_seconds(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with make_progress(100) as shown:
        for _ in range(12):
            clock.now += 1.0
            shown.advance(5, 1)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [
        "25/100 points, 5 failed, 5.0 points/s, about 15.0 s left",
        "50/100 points, 10 failed, 5.0 points/s, about 10.0 s left",
    ]
    assert err.replace("\n", "").isprintable()


def test_a_short_sweep_needs_no_line(clock: Clock, capsys: pytest.CaptureFixture[str]) -> None:
    with make_progress(10) as shown:
        clock.now += 1.0
        shown.advance(10, 0)
        shown.stop()
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_nothing_where_nothing_is_wanted(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, stream: type[io.StringIO]
) -> None:
    monkeypatch.setattr(sys, "stderr", stream())
    with make_progress(10, wanted=False) as shown:
        clock.now += 100.0
        shown.advance(5, 5)
        shown.stop()
    assert sys.stderr.getvalue() == ""


def test_a_terminal_gets_a_bar_that_fits_and_gives_the_cursor_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setattr(sys, "stderr", Terminal())
    with make_progress(4000) as shown:
        shown.advance(2500, 3)
    text = sys.stderr.getvalue()
    hidden, visible = "\x1b[?25l", "\x1b[?25h"
    assert text.count(hidden) == text.count(visible) == 1
    assert text.index(hidden) < text.index(visible)
    last = re.sub(r"\x1b\[[\d;?]*\w", "", text).rstrip("\n").split("\n")[-1].split("\r")[-1]
    assert "2500/4000 points, 3 failed, " in last
    assert re.search(r"[\d.]+ points/s .* left", last)
    assert len(last) <= 80


def test_stopping_gives_the_terminal_back_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys, "stderr", Terminal())
    with make_progress(10) as shown:
        shown.stop()
        stopped = sys.stderr.getvalue()
        assert stopped.endswith("\n\x1b[?25h")
    assert sys.stderr.getvalue() == stopped


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.04, "0.0 s"),
        (8.42, "8.4 s"),
        (59.9, "59.9 s"),
        (60.0, "1 min 0 s"),
        (200.4, "3 min 20 s"),
        (3599.4, "59 min 59 s"),
        (3600.0, "1 h 0 min"),
        (7530.0, "2 h 5 min"),
    ],
)
def test_durations_read_as_they_are_said(seconds: float, text: str) -> None:
    assert duration(seconds) == text
