"""A word while kernels are compiled: only where that takes long, and gone afterwards."""

from __future__ import annotations

import sys
import threading

import pytest
from support.sweeps.processes import wait_until
from support.sweeps.watching import HIDDEN, VISIBLE, Clock, Log, plain, terminal_of

from sweeps.engine.progress import compiling
from sweeps.engine.progress.compiling import Compiling

WORD = "compiling for this processor: about a minute, and kept for later runs"


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiling, "_MOMENT", 0.0)


def test_what_takes_a_moment_is_not_worth_a_word(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    monkeypatch.setattr(compiling, "_MOMENT", 60.0)
    with Compiling():
        pass
    assert terminal.getvalue() == ""


def test_nothing_is_said_where_nothing_is_wanted(
    soon: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = terminal_of(monkeypatch)
    before = threading.active_count()
    with Compiling(wanted=False):
        assert threading.active_count() == before
    assert terminal.getvalue() == ""


def test_a_terminal_gets_a_spinner_that_counts_and_goes_away(
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


def test_a_log_gets_the_word_and_then_lines(
    soon: None, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = Log(3)
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(compiling, "_SECONDS_BETWEEN_LINES", 0.01)
    with Compiling():
        clock.now += 15.0
        assert log.there.wait(60.0)
    first, *others = log.getvalue().splitlines()
    assert first == WORD
    assert set(others) == {"compiling, 0:15 elapsed"}


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_it_goes_away_on_an_error(
    soon: None, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    terminal = terminal_of(monkeypatch)

    def failing() -> None:
        with Compiling():
            wait_until(lambda: WORD in terminal.getvalue())
            raise error

    before = threading.active_count()
    with pytest.raises(error):
        failing()
    assert terminal.getvalue().count(VISIBLE) == 1
    wait_until(lambda: threading.active_count() == before)


def test_it_can_be_taken_away_before_its_end(soon: None, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = terminal_of(monkeypatch)
    with Compiling() as sign:
        wait_until(lambda: WORD in terminal.getvalue())
        sign.stop()
        gone = terminal.getvalue()
        assert VISIBLE in gone
    assert terminal.getvalue() == gone
