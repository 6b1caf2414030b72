"""Progress: a bar on a terminal, plain lines in a log, nothing if it is not wanted.

If compiling kernels takes long, a message says so until it is done.
"""

from __future__ import annotations

import contextlib
import io
import sys
import threading
from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest
from support.sweeps.processes import wait_until
from support.sweeps.watching import (
    HIDDEN,
    VISIBLE,
    Clock,
    Log,
    Terminal,
    advanced,
    block_of,
    found,
    plain,
    task,
    terminal_of,
)

from sweeps.engine import progress
from sweeps.engine.progress import Compiling, Counts, display_of

# --- lines in a log ---


class Schedule:
    """An event that is set after some seconds; waiting for it moves the clock."""

    def __init__(self, clock: Clock, seconds: float) -> None:
        self._clock, self._end = clock, clock.now + seconds
        self.on_the_way: dict[float, Callable[[], None]] = {}

    def wait(self, seconds: float) -> bool:
        self.on_the_way.pop(self._clock.now, lambda: None)()
        self._clock.now += seconds
        return self._clock.now > self._end


def test_lines_become_rare_until_the_next_block_is_finished(
    clock: Clock,
) -> None:
    store, schedule, log = found(), Schedule(clock, 360.0), io.StringIO()
    counts = Counts(100, store)
    schedule.on_the_way[1255.0] = lambda: advanced(counts, store, 1.0, ok=10)
    shown = display_of(counts)
    shown._over = schedule
    with contextlib.redirect_stderr(log):
        shown._keep_saying()
    said = [line.split(", ") for line in log.getvalue().splitlines()]
    idle = ["0:05", "0:15", "0:35", "1:15", "2:15", "3:15", "4:15"]
    busy = ["4:20", "4:25", "4:35", "4:55", "5:35"]
    assert [words[2] for words in said] == [f"{time} elapsed" for time in idle + busy]
    assert [words[0].split("/")[0] for words in said] == ["0"] * len(idle) + ["10"] * len(busy)


@pytest.mark.parametrize("terminal", [None, "dumb"])
def test_a_stream_that_cannot_replace_lines_gets_new_ones(
    monkeypatch: pytest.MonkeyPatch, terminal: str | None
) -> None:
    log = Log(2)
    log.isatty = lambda: terminal is not None
    monkeypatch.setenv("TERM", terminal or "xterm")
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.005)
    with display_of(Counts(100, found(ok=9, failed=1))):
        assert log.there.wait(60.0)
    assert all(line.startswith("10/100 points, 1 failed, ") for line in log.getvalue().splitlines())
    assert log.getvalue().replace("\n", "").isprintable()


@pytest.mark.parametrize("early", [True, False])
def test_no_line_comes_after_the_end(monkeypatch: pytest.MonkeyPatch, early: bool) -> None:
    log = Log(1)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.001)
    before = set(threading.enumerate())
    with display_of(Counts(10, found())) as shown:
        (clockwork,) = set(threading.enumerate()) - before
        assert log.there.wait(60.0)
        if early:
            shown.stop()
    clockwork.join(60.0)
    assert not clockwork.is_alive()


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_nothing_is_written_if_nothing_is_wanted(
    soon: None, monkeypatch: pytest.MonkeyPatch, stream: type[io.StringIO]
) -> None:
    monkeypatch.setattr(sys, "stderr", stream())
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.001)
    before = threading.active_count()
    with display_of(Counts(10, found()), wanted=False), Compiling(wanted=False):
        assert threading.active_count() == before
    assert sys.stderr.getvalue() == ""


# --- the bar ---


def last_lines(text: str) -> list[str]:
    """The last two lines of the bar."""
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
         "22.7 points/s, 1 h 6 min left, 64 points in flight, the oldest for 1:00:00"),
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
    store = found()
    counts = Counts(total, store)
    with display_of(counts):
        clock.now += elapsed
        advanced(counts, store, elapsed, ok=done - 3, diverged=3)
        counts.in_flight.end(block_of(task(0, 1)))
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


def test_the_bar_goes_on_while_no_block_comes_back(
    clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = terminal_of(monkeypatch)
    counts = Counts(10, found())
    with display_of(counts):
        counts.in_flight.begin(task(0, 10))
        for seconds in (7, 8, 9):
            clock.now = 1000.0 + seconds
            wait_until(lambda s=seconds: f"0:0{s} elapsed" in plain(terminal.getvalue()))
            wait_until(lambda s=seconds: f"the oldest for 0:0{s}" in plain(terminal.getvalue()))


@pytest.mark.parametrize("shown", [lambda: display_of(Counts(10, found())), Compiling])
def test_stopping_gives_the_terminal_back_once(
    soon: None, monkeypatch: pytest.MonkeyPatch, shown: Callable[[], Any]
) -> None:
    terminal = terminal_of(monkeypatch)
    with shown() as display:
        wait_until(lambda: HIDDEN in terminal.getvalue())
        display.stop()
        stopped = terminal.getvalue()
        assert VISIBLE in stopped
    assert terminal.getvalue() == stopped


def test_messages_appear_above_the_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with display_of(Counts(10, found())):
        sys.stderr.write("warning: [red] 3 points\n")
    assert "warning: [red] 3 points\n" in plain(terminal.getvalue())
    assert "0/10 points" in last_lines(terminal.getvalue())[0]


# --- streams that are gone ---


class Gone(Terminal):
    """A terminal that is closed, or a log on a full disk, after a number of writes."""

    def __init__(self, after: int, *, is_terminal: bool) -> None:
        super().__init__()
        self._left, self._is_terminal, self.failed = after, is_terminal, threading.Event()

    def isatty(self) -> bool:
        return self._is_terminal

    def write(self, text: str) -> int:
        self._left -= 1
        if self._left < 0:
            self.failed.set()
            raise OSError(5, "Input/output error")
        return super().write(text)


@pytest.mark.parametrize("is_terminal", [True, False])
@pytest.mark.parametrize("after", [0, 1, 4])
def test_text_that_cannot_be_written_is_lost(
    monkeypatch: pytest.MonkeyPatch, after: int, is_terminal: bool
) -> None:
    terminal_of(monkeypatch)
    gone = Gone(after, is_terminal=is_terminal)
    monkeypatch.setattr(sys, "stderr", gone)
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.01)
    with display_of(Counts(10, found())):
        assert gone.failed.wait(60.0)


# --- kernels that are compiled ---

WORD = "compiling for this processor: up to a minute; the code is kept"


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "MOMENT", 0.0)


def test_compiling_for_a_moment_shows_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    monkeypatch.setattr(progress, "MOMENT", 60.0)
    with Compiling():
        pass
    assert terminal.getvalue() == ""


def test_a_terminal_gets_a_spinner_that_counts_and_disappears(
    soon: None, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = terminal_of(monkeypatch)
    with Compiling():
        for seconds in ("0:00", "0:12", "1:05"):
            clock.now = 1000.0 + 60 * int(seconds[0]) + int(seconds[2:])
            shown = f" {WORD} ({seconds})"
            wait_until(lambda s=shown: s in plain(terminal.getvalue()))
            assert len(shown) + 1 <= 80
    text = terminal.getvalue()
    assert text.count(HIDDEN) == text.count(VISIBLE) == 1
    after = text[text.rindex(WORD) :]
    assert "\x1b[2K" in after[after.index(VISIBLE) :]  # the line is erased
    assert not plain(after.rpartition("\x1b[2K")[2]).strip()


def test_a_log_gets_the_message_at_once(
    soon: None, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = Log(3)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.01)
    with Compiling():
        assert log.there.wait(60.0)
    assert set(log.getvalue().splitlines()) == {f"{WORD} (0:00)"}


def test_the_message_disappears_on_an_error(soon: None, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)

    def failing() -> None:
        with Compiling():
            wait_until(lambda: WORD in terminal.getvalue())
            raise KeyboardInterrupt

    before = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        failing()
    assert terminal.getvalue().count(VISIBLE) == 1
    wait_until(lambda: threading.active_count() == before)


# --- a notebook ---


class Cell:
    """An IPython display handle that keeps the pictures shown under a notebook cell."""

    def __init__(self) -> None:
        self.shown: list[str] = []

    def update(self, picture: Any) -> None:
        self.shown.append(picture)


@pytest.fixture
def cell(monkeypatch: pytest.MonkeyPatch) -> Cell:
    """Make this process look like the kernel of a notebook."""
    cell = Cell()

    def display(picture: str, *, display_id: bool) -> Cell:
        assert display_id
        cell.update(picture)
        return cell

    notebook: Any = ModuleType("IPython")
    notebook.get_ipython = lambda: SimpleNamespace(kernel=None)
    notebook.display = ModuleType("IPython.display")
    notebook.display.display, notebook.display.HTML = display, str
    monkeypatch.setitem(sys.modules, "IPython", notebook)
    monkeypatch.setitem(sys.modules, "IPython.display", notebook.display)
    return cell


def test_a_notebook_gets_a_bar_that_ends_with_the_last_state(clock: Clock, cell: Cell) -> None:
    store = found(ok=1)
    counts = Counts(4, store)
    with display_of(counts):
        assert len(cell.shown) >= 1
        wait_until(lambda: len(cell.shown) > 2)
        advanced(counts, store, ok=3)
    bar = '<progress value="{}" max="4" style="width: 20em"></progress>'
    assert cell.shown[0] == f"{bar.format(1)} 1/4 points, 0 failed, 0:00 elapsed<br>"
    assert cell.shown[-1].startswith(f"{bar.format(4)} 4/4 points, 0 failed, 0:00 elapsed<br>")


def test_a_notebook_shows_that_kernels_are_compiled(soon: None, cell: Cell) -> None:
    with Compiling():
        wait_until(lambda: bool(cell.shown))
    assert cell.shown[0].startswith(WORD)
    assert cell.shown[-1] == ""  # it is over
