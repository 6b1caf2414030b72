"""Progress: a bar on a terminal, plain lines in a log, nothing where it is not wanted."""

from __future__ import annotations

import io
import sys
import threading

import pytest
from support.sweeps.processes import wait_until
from support.sweeps.watching import (
    HIDDEN,
    VISIBLE,
    Clock,
    Log,
    Terminal,
    advanced,
    found,
    plain,
    task,
    terminal_of,
)

from sweeps.engine.progress import display
from sweeps.engine.progress.counts import Counts
from sweeps.engine.progress.display import make_progress

# --- lines in a log ---


class Schedule:
    """An event that is set after so many seconds; waiting for it moves the clock."""

    def __init__(self, clock: Clock, seconds: float) -> None:
        self._clock, self._end = clock, clock.now + seconds

    def wait(self, seconds: float) -> bool:
        self._clock.now += seconds
        return self._clock.now > self._end


def said_within(clock: Clock, counts: Counts, seconds: float) -> list[str]:
    """When lines come, as elapsed times."""
    shown, said = make_progress(counts), []
    shown.say = said.append
    shown._keep_saying(Schedule(clock, seconds))
    return [line.split(", ")[2].removesuffix(" elapsed") for line in said]


def test_while_nothing_is_done_lines_become_rare(clock: Clock) -> None:
    counts = Counts(100, found())
    times = ["0:05", "0:15", "0:35", "1:15", "2:15", "3:15", "4:15"]
    assert said_within(clock, counts, 300.0) == times


def test_lines_come_again_when_something_is_done(clock: Clock) -> None:
    statuses = found()
    counts = Counts(100, statuses)

    class Busy(Schedule):
        def wait(self, seconds: float) -> bool:
            if clock.now == 1040.0:
                advanced(counts, statuses, 1.0, ok=10)
            return super().wait(seconds)

    shown, said = make_progress(counts), []
    shown.say = said.append
    shown._keep_saying(Busy(clock, 60.0))
    assert [line[:2] for line in said] == ["0/", "0/", "0/", "10", "10", "10"]
    assert [line.split(", ")[2] for line in said][3:] == [
        "0:45 elapsed",
        "0:50 elapsed",
        "1:00 elapsed",
    ]


def test_a_log_gets_lines_without_control_characters(monkeypatch: pytest.MonkeyPatch) -> None:
    log = Log(2)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(display, "_SECONDS_BETWEEN_LINES", 0.005)
    with make_progress(Counts(100, found(ok=9, failed=1))):
        assert log.there.wait(60.0)
    assert all(line.startswith("10/100 points, 1 failed, ") for line in log.getvalue().splitlines())
    assert log.getvalue().replace("\n", "").isprintable()


@pytest.mark.parametrize("early", [True, False])
def test_after_the_end_no_line_comes(monkeypatch: pytest.MonkeyPatch, early: bool) -> None:
    log = Log(1)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(display, "_SECONDS_BETWEEN_LINES", 0.001)
    before = set(threading.enumerate())
    with make_progress(Counts(10, found())) as shown:
        (clockwork,) = set(threading.enumerate()) - before
        assert log.there.wait(60.0)
        if early:
            shown.stop()
    clockwork.join(60.0)
    assert not clockwork.is_alive()


def test_a_short_sweep_needs_no_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert display._SECONDS_BETWEEN_LINES >= 2.0
    with make_progress(Counts(10, found())) as shown:
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
    monkeypatch.setattr(display, "_SECONDS_BETWEEN_LINES", 0.001)
    before = threading.active_count()
    with make_progress(Counts(10, found()), wanted=False) as shown:
        assert threading.active_count() == before
        shown.say("a line")
        shown.stop()
        shown.start()
        shown.stop()
    assert sys.stderr.getvalue() == ""


def test_a_terminal_that_cannot_replace_lines_gets_those_of_a_log(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    terminal = terminal_of(monkeypatch)
    monkeypatch.setenv("TERM", "dumb")
    with make_progress(Counts(10, found())) as shown:
        shown.say("a line")
    assert terminal.getvalue() == "a line\n"


# --- the bar ---


def last_lines(text: str) -> list[str]:
    """The two lines of the bar as they stand in the end."""
    lines = plain(text).rstrip("\n").split("\n")[-2:]
    return [line.split("\r")[-1] for line in lines]


@pytest.mark.parametrize(
    ("total", "done", "elapsed", "flying", "age", "clock_shows", "expected"),
    [
        (4000, 2500, 10.0, 0, 0.0, "0:10", "250.0 points/s, 6.0 s left"),
        (2500, 2500, 1.0, 0, 0.0, "0:01", "2500.0 points/s"),
        (10**6, 2500, 3.0, 9999, 0.0, "0:03",
         "833.3 points/s, 19 min 57 s left, 9999 points in flight"),
        (10**6, 900_000, 36e3, 16_384, 599.0, "10:09:59",
         "24.6 points/s, 56 min 41 s left, 16384 points in flight, the oldest for 9:59"),
        (10**6, 900_000, 36e3, 64, 3600.0, "11:00:00",
         "no block has finished for 1:00:00, 64 points in flight, the oldest for 1:00:00"),
    ],
)  # fmt: skip
def test_a_terminal_gets_a_bar_that_fits_and_gives_the_cursor_back(
    clock: Clock,
    monkeypatch: pytest.MonkeyPatch,
    total: int,
    done: int,
    elapsed: float,
    flying: int,
    age: float,
    clock_shows: str,
    expected: str,
) -> None:
    terminal = terminal_of(monkeypatch)
    statuses = found()
    counts = Counts(total, statuses)
    with make_progress(counts):
        clock.now += elapsed
        advanced(counts, statuses, elapsed, ok=done - 3, diverged=3)
        counts.in_flight.end(0)
        if flying:
            counts.in_flight.begin(task(0, flying))
        clock.now += age
    text = terminal.getvalue()
    assert text.count(HIDDEN) == text.count(VISIBLE) == 1
    assert text.index(HIDDEN) < text.index(VISIBLE)
    bar, outlook = last_lines(text)
    assert bar.endswith(f" {done}/{total} points, 3 failed, {clock_shows} elapsed")
    assert bar.startswith("━" * 20)
    assert outlook.rstrip() == expected
    assert max(len(bar), len(outlook)) <= 80


def test_the_bar_goes_on_though_nothing_comes_back(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = terminal_of(monkeypatch)
    counts = Counts(10, found())
    with make_progress(counts):
        counts.in_flight.begin(task(0, 10))
        for seconds in (7, 8, 9):
            clock.now = 1000.0 + seconds
            wait_until(lambda s=seconds: f"0:0{s} elapsed" in plain(terminal.getvalue()))
            wait_until(lambda s=seconds: f"the oldest for 0:0{s}" in plain(terminal.getvalue()))


def test_the_bar_begins_with_what_was_found(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with make_progress(Counts(100, found(ok=30, failed=2))):
        pass
    assert " 32/100 points, 2 failed, 0:00 elapsed\n" in plain(terminal.getvalue())


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
        terminal.write("Continue? [Y/n]: y\n")
        shown.start()
        again = terminal.getvalue()[len(asked) :]
        assert HIDDEN in again
        assert "\x1b[1A" not in again.partition("0/10 points")[0]  # the answer stays
    assert terminal.getvalue().endswith(VISIBLE)


def test_what_is_said_stands_above_the_bar_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with make_progress(Counts(10, found())) as shown:
        shown.say("time left: [red] 3 min")
    assert "time left: [red] 3 min\n" in plain(terminal.getvalue())
    assert "0/10 points" in last_lines(terminal.getvalue())[0]
