"""Ending early: durations as people write them, the first reason, work that nobody waits for."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.sweeps.processes import HANGS, Running, default_signals
from support.sweeps.sweeping import LOOSE, Shell, hash_at_once, hash_of, write

from stickslip.dispatch import stop as stopping
from stickslip.dispatch import task as worker
from sweeps.engine import signals
from sweeps.engine.signals import Stop, interruptible, listening, parse_duration, wait_for
from sweeps.exits import Exit


class Clock:
    """Monotonic time that goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    for module in (signals, stopping):
        monkeypatch.setattr(module, "time", clock)
    return clock


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
def test_durations_are_read_as_they_are_written(text: str, seconds: float) -> None:
    assert parse_duration(text) == seconds


@pytest.mark.parametrize(
    "text",
    [
        *("", "  ", "h", "1x", "1h30", "-1h", "1 hour", "2H", "1e3", "inf", "nan", "1:30", "1,5h"),
        *(".5h", "1.h", "1.5.2", "h1", "2h, 3m", "0x10", "1h-30m"),
    ],
)
def test_what_is_no_duration_is_refused_with_examples(text: str) -> None:
    with pytest.raises(ValueError, match="is no duration; write for example 2h, 90min"):
        parse_duration(text)


@pytest.mark.parametrize("text", ["30 1h", "1 2 3s", "1 30min"])
def test_a_number_without_a_unit_before_others_is_no_duration(text: str) -> None:
    with pytest.raises(ValueError, match="is no duration"):
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


def test_the_time_that_was_granted_ends(clock: Clock) -> None:
    stop = Stop(10.0)
    clock.now += 9.9
    assert not stop.requested
    clock.now += 0.1
    assert stop.requested
    assert stop.reason == "the time of --max-runtime is over"
    assert stop.code == Exit.STOPPED
    clock.now -= 5.0
    assert stop.requested  # once and for all


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
        f"Another {again} ends at once and gives up what is in flight.\n"
        "\nEnded at once; what was journaled is kept.\n"
    )
    assert [signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


def test_a_signal_while_nothing_is_in_flight_says_that_it_is_heard(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with default_signals(), listening(Stop()):
        signal.raise_signal(signal.SIGINT)
    assert capsys.readouterr().err == "\nCtrl-C: ending\n"


def test_elsewhere_than_in_the_main_thread_signals_are_left_alone() -> None:
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


def test_work_is_waited_for() -> None:
    done = []
    assert wait_for(lambda: done.append(threading.current_thread()), Stop())
    assert len(done) == 1
    assert done[0] is not threading.main_thread()


def test_work_is_not_waited_for_when_a_stop_is_requested() -> None:
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


# --- Ctrl-C during work that does not look for signals ---

# Minutes of work in blocks of one point: whatever the machine, the signal comes while it runs.
# Longer than anyone waits for a signal, but far from the hour above which a terminal is asked.
LONG = """\
sweep:
  temperature: {linspace: [150, 320], num: 2000}
integrator: {rtol: 1e-8}
stationary: {rtol: 1e-8}
execution: {block_points: 1}
"""


def test_work_is_done_in_another_thread_and_its_result_comes_back() -> None:
    assert interruptible(lambda: 42) == 42
    assert interruptible(threading.current_thread) is not threading.main_thread()


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


def left_over(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


@pytest.mark.parametrize("more", ["follow: omega\n", "execution: {block_points: 12}\n"])
def test_a_stop_gives_up_what_takes_longer_than_a_while(
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
    assert shell("sweep", "a.yaml", "-o", "a.nc").code == 0
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def in_run_folder(output: str) -> list[str]:
    names = ("heartbeat.json", "journal", "journal.json", "lock")
    return [f"{output}.run/{name}" for name in names]


@pytest.mark.slow
def test_ctrl_c_during_a_sweep(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(LONG)
    child = Running("-m", "sweeps.cli", "sweep", "a.yaml", cwd=tmp_path)
    child.says(" points/s, ")  # compiled and under way
    assert child.err.startswith("2000 points; 2000 to compute\n")
    child.signal(signal.SIGINT)
    code, out, err = child.ended()
    assert (code, out) == (130, "")
    heard, at_once, kept, again = err[err.index("\nCtrl-C") :].strip().splitlines()
    assert re.fullmatch(r"Ctrl-C: finishing [12] points? in flight.*\.", heard)
    assert at_once == "Another Ctrl-C ends at once and gives up what is in flight."
    assert re.fullmatch(
        r"Stopped: Ctrl-C\. \d+ of 2000 points are kept in results/a\.nc\.run\. To resume:", kept
    )
    assert again == "  stickslip sweep a.yaml"
    assert left_over(tmp_path) == ["a.yaml", *in_run_folder("results/a.nc")]


@pytest.mark.slow
def test_ctrl_c_on_a_terminal_shows_the_cursor_again(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(LONG)
    old = tmp_path / "a.nc"
    old.write_bytes(b"an older result")
    sweep = [sys.executable, "-m", "sweeps.cli", "sweep", "a.yaml", "-o", "a.nc", "--overwrite"]
    with default_signals():
        child, terminal = pty.fork()
        if child == 0:  # still within: what is ignored here would be ignored there
            os.chdir(tmp_path)
            os.environ["TERM"] = "xterm"
            os.execv(sys.executable, sweep)
    seen, sent = b"", False
    while select.select([terminal], [], [], HANGS)[0]:
        try:
            seen += os.read(terminal, 65536)
        except OSError:  # the other end has closed
            break
        if not sent and b"points/s" in seen:
            os.write(terminal, b"\x03")
            sent = True
    os.close(terminal)  # which ends a child that hangs
    assert sent
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 130
    tail = seen[seen.rindex(b"\x1b[?25l") :].decode()
    bar, message = tail.split("\x1b[?25h")
    assert "/2000" in bar
    assert re.search(r"Ctrl-C: finishing [12] points? in flight", bar)
    assert message.strip().startswith("Stopped: Ctrl-C. ")
    assert message.strip().endswith("To resume:\r\n  stickslip sweep a.yaml -o a.nc")
    assert old.read_bytes() == b"an older result"
    assert left_over(tmp_path) == ["a.nc", *in_run_folder("a.nc"), "a.yaml"]


@pytest.mark.slow
def test_ctrl_c_during_a_trajectory(tmp_path: Path) -> None:
    arguments = ["--periods", "1000", "--set", "integrator.rtol=1e-12", "-o", "a.nc"]
    code = (
        "from sweeps.engine import trajectories\n"
        "from sweeps.cli import main\n"
        "simulate = trajectories.simulate\n"
        "def announced(*a, **k):\n"
        "    print('ready', flush=True)\n"
        "    return simulate(*a, **k)\n"
        "trajectories.simulate = announced\n"
        "main()\n"
    )
    child = Running("-c", code, "simulate", *arguments, cwd=tmp_path)
    child.says("ready\n")
    child.signal(signal.SIGINT)
    code, out, err = child.ended()
    assert (code, out) == (130, "ready\n")
    assert err.endswith("\nInterrupted; nothing was kept.\n")
    assert left_over(tmp_path) == []
