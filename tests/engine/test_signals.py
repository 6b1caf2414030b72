"""Ending early: durations, the first reason, signals, and work that a stop does not wait for."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import messages
from support.sweeps.processes import HANGS, Running, default_signals
from support.sweeps.sweeping import LOOSE, Shell, entries, hash_at_once, hash_of, write
from support.sweeps.watching import HIDDEN, VISIBLE, Clock, OnTerminal

from stickslip.dispatch import stop as stopping
from stickslip.dispatch import task as worker
from sweeps.engine.signals import Stop, interruptible, listening, parse_duration, wait_for
from sweeps.exits import Exit


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("45", 45),
        ("45s", 45),
        ("0.5", 0.5),
        ("1.5h", 5400),
        ("2h", 7200),
        ("90min", 5400),
        ("90 min", 5400),
        ("90m", 5400),
        ("1h30m", 5400),
        ("1h 30 min", 5400),
        ("1d2h3m4s", 93_784),
        ("1 d", 86_400),
        ("2h ", 7200),
    ],
)
def test_durations_are_read_as_people_write_them(text: str, seconds: float) -> None:
    assert parse_duration(text) == seconds


@pytest.mark.parametrize(
    "text",
    [
        *("", "  ", "h", "1x", "1h30", "-1h", "1 hour", "2H", "1e3", "inf", "nan", "1:30", "1,5h"),
        *(".5h", "1.h", "1.5.2", "h1", "2h, 3m", "0x10", "1h-30m"),
        *("30 1h", "1 2 3s", "1 30min"),  # a number without a unit before others
    ],
)
def test_other_texts_are_refused_with_examples_of_durations(text: str) -> None:
    with pytest.raises(ValueError, match="is not a duration; write, for example, 2h, 90min"):
        parse_duration(text)


@pytest.mark.parametrize("text", ["0", "0s", "0h0m", "0.0"])
def test_no_time_at_all_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="longer than 0"):
        parse_duration(text)


# --- the request ---


def test_nothing_stops_without_a_reason(clock: Clock) -> None:
    stop = Stop()
    clock.now += 1e9
    assert not stop.requested
    assert stop.reason == ""


def test_a_stop_is_requested_when_the_granted_time_is_over(clock: Clock) -> None:
    stop = Stop(10.0)
    clock.now += 9.9
    assert not stop.requested
    clock.now += 0.1
    assert stop.requested
    assert stop.reason == messages.TIME_OVER
    assert stop.code == Exit.STOPPED
    clock.now -= 5.0
    assert stop.requested  # for good


def test_the_first_reason_counts(clock: Clock) -> None:
    stop = Stop(10.0)
    stop.request("all points fail", code=Exit.FAILED_POINTS)
    stop.request("Ctrl-C", code=Exit.INTERRUPTED)
    clock.now += 20.0
    assert stop.requested
    assert (stop.reason, stop.code) == ("all points fail", Exit.FAILED_POINTS)


# --- signals ---


@pytest.mark.parametrize(
    ("number", "reason", "code"),
    [
        (signal.SIGINT, "Ctrl-C", Exit.INTERRUPTED),
        (signal.SIGTERM, "SIGTERM", Exit.STOPPED),
        (signal.SIGHUP, "SIGHUP", Exit.STOPPED),
    ],
)
def test_a_signal_requests_a_stop_and_the_next_one_ends_at_once(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: int,
    reason: str,
    code: int,
) -> None:
    ended: list[int | str] = []
    monkeypatch.setattr(os, "_exit", ended.append)
    before = [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    stop = Stop()
    stop.at_a_stop = lambda: "finishing 256 points in flight, the oldest for 0:12"
    stop.at_once += [lambda: ended.append("first"), lambda: ended.append("second")]
    with default_signals(), listening(stop):
        assert not stop.requested
        signal.raise_signal(number)
        assert (stop.requested, stop.reason, stop.code) == (True, reason, code)
        assert ended == []
        signal.raise_signal(number)
    assert ended == ["second", "first", code]
    again = "Ctrl-C" if number == signal.SIGINT else "signal"
    assert capsys.readouterr().err.startswith(
        f"\n{reason}: finishing 256 points in flight, the oldest for 0:12.\n"
        f"Another {again} ends the run at once and drops the points in flight.\n"
        "\nEnded at once; points in the journal are kept.\n"
    )
    assert [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_a_signal_with_nothing_in_flight_is_acknowledged(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with default_signals(), listening(Stop()):
        signal.raise_signal(signal.SIGINT)
    assert capsys.readouterr().err == "\nCtrl-C: ending\n"


def test_the_first_signal_after_the_granted_time_does_not_end_at_once(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], clock: Clock
) -> None:
    """Batch systems send one when the time is over, while the blocks in flight are finished."""
    ended: list[int] = []
    monkeypatch.setattr(os, "_exit", ended.append)
    stop = Stop(10.0)
    stop.at_a_stop = lambda: "finishing 256 points in flight"
    clock.now += 10.0
    assert stop.requested
    with default_signals(), listening(stop):
        signal.raise_signal(signal.SIGTERM)
        assert ended == []
        err = capsys.readouterr().err
        assert err.startswith(f"\n{messages.TIME_OVER}: finishing 256 points in flight.\n")
        signal.raise_signal(signal.SIGTERM)
    assert ended == [Exit.STOPPED]


def test_a_handler_that_is_not_pythons_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """R and Julia install such handlers, for which Python has no value."""
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(
        signal, "getsignal", lambda number: None if number == signal.SIGHUP else signal.SIG_DFL
    )
    changed: list[int] = []
    monkeypatch.setattr(signal, "signal", lambda number, _: changed.append(number))
    with listening(Stop()):
        pass
    assert signal.SIGHUP not in changed
    monkeypatch.undo()
    assert signal.getsignal(signal.SIGTERM) == before


def test_outside_the_main_thread_signal_handlers_stay() -> None:
    found = []
    before = signal.getsignal(signal.SIGINT)

    def listen() -> None:
        with listening(Stop()):
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=listen)
    thread.start()
    thread.join()
    assert found == [before]


# --- waiting ---


def test_work_is_done_in_another_thread() -> None:
    done = []
    assert wait_for(lambda: done.append(threading.current_thread()), Stop())
    assert done == [interruptible(lambda: done[0])]
    assert threading.main_thread() not in (*done, interruptible(threading.current_thread))


def test_a_requested_stop_does_not_wait_for_work() -> None:
    stop, begun, go_on = Stop(), threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        stop.request("enough")
        go_on.wait(60.0)

    assert not wait_for(work, stop)
    assert begun.is_set()
    go_on.set()


@pytest.mark.parametrize("waiting", [lambda work: wait_for(work, Stop()), interruptible])
@pytest.mark.parametrize("error", [ValueError("bad"), KeyboardInterrupt(), SystemExit(3)])
def test_errors_of_the_work_are_raised(
    waiting: Callable[[Callable[[], None]], object], error: BaseException
) -> None:
    def work() -> None:
        raise error

    with pytest.raises(type(error)) as caught:
        waiting(work)
    assert caught.value is error


# --- Ctrl-C during work that does not check for signals ---

# Minutes of work in blocks of one point: on any machine the signal comes while it runs.
LONG = """\
sweep:
  temperature: {linspace: [150, 320], num: 2000}
integrator: {rtol: 1e-8}
stationary: {rtol: 1e-8}
execution: {block_points: 1}
"""


@pytest.mark.parametrize("stubborn", ["time.sleep(1000)", "while_true()"])
def test_ctrl_c_does_not_wait_for_the_work(stubborn: str) -> None:
    code = (
        "import sys, time\n"
        "from sweeps.engine.signals import interruptible\n"
        "def while_true():\n"
        "    while True: pass\n"
        f"def work(): print('ready', flush=True); {stubborn}\n"
        "try: interruptible(work, lambda: print('tidied'), message='the message')\n"
        "finally: print('too late')\n"
    )
    child = Running("-c", code)
    child.says("ready\n")
    child.signal(signal.SIGINT)
    assert child.ended() == (130, "ready\ntidied\n", "\nthe message\n")


@pytest.mark.parametrize("more", ["follow: omega\n", "execution: {block_points: 12}\n"])
def test_a_stop_gives_up_blocks_that_take_too_long(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, more: str
) -> None:
    monkeypatch.setattr(stopping, "LONGEST_STOP", 0.2)
    write("a.yaml", "sweep: {omega: [10, 11, 12, 13, 14, 15]}\n", LOOSE, more)
    released, results = threading.Event(), worker.computed_results

    def slow(*block: Any) -> np.ndarray:
        os.kill(os.getpid(), signal.SIGTERM)
        released.wait(HANGS)
        return results(*block)

    with monkeypatch.context() as patch, default_signals():
        patch.setattr(worker, "computed_results", slow)
        code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 4
    assert re.search(r"\n(Stopped: SIGTERM\. 0 of \d+ points are kept in a\.nc\.run)", err)
    released.set()
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    assert hash_of("a.nc") == hash_at_once("a.yaml")


@pytest.mark.slow
def test_ctrl_c_on_a_terminal_shows_the_cursor_again(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(LONG)
    old = tmp_path / "a.nc"
    old.write_bytes(b"an older result")
    sweep = ["sweep", "a.yaml", "-o", "a.nc", "--overwrite"]
    child = OnTerminal("from sweeps.cli import main; main()", *sweep, folder=tmp_path)
    child.shows("points/s")
    child.types(b"\x03")
    assert child.ended() == 130
    bar, message = child.text[child.text.rindex(HIDDEN) :].split(VISIBLE)
    assert "/2000" in bar
    assert re.search(r"Ctrl-C: finishing [12] points? in flight", bar)
    assert message.strip().startswith("Stopped: Ctrl-C. ")
    assert message.strip().endswith("To resume:\r\n  stickslip sweep a.yaml -o a.nc")
    assert old.read_bytes() == b"an older result"
    assert entries(tmp_path) == ["a.nc", "a.nc.run", "a.yaml"]
    assert entries(tmp_path / "a.nc.run") == ["heartbeat.json", "journal", "journal.json", "lock"]
