"""Ctrl-C ends a sweep, which can be gone on with, and a trajectory, of which nothing is kept."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from sweeps.engine.signals import interruptible

# Minutes of work in blocks of one point: whatever the machine, the signal comes while it runs.
LONG = """\
sweep:
  temperature: {linspace: [150, 320], num: 2000}
integrator: {rtol: 1e-10}
stationary: {rtol: 1e-10}
execution: {block_points: 1}
"""
COMMAND = [sys.executable, "-m", "sweeps.cli"]
ENDED = 120.0  # seconds: a hang, on any machine


def test_work_is_done_in_another_thread_and_its_result_comes_back() -> None:
    assert interruptible(lambda: 42, "never said") == 42
    assert interruptible(lambda: None, "never said") is None
    assert interruptible(threading.current_thread, "never said") is not threading.main_thread()


@pytest.mark.parametrize("error", [ValueError("mine"), SystemExit(4), KeyboardInterrupt()])
def test_what_work_raises_is_raised(error: BaseException) -> None:
    def fail() -> None:
        raise error

    with pytest.raises(type(error)) as caught:
        interruptible(fail, "never said")
    assert caught.value is error


@pytest.mark.parametrize("stubborn", ["time.sleep(1000)", "while_true()"])
def test_ctrl_c_does_not_wait_for_the_work(stubborn: str) -> None:
    code = (
        "import sys, time\n"
        "from sweeps.engine.signals import interruptible\n"
        "def while_true():\n"
        "    while True: pass\n"
        f"def work(): print('ready', flush=True); {stubborn}\n"
        "try: interruptible(work, 'the message')\n"
        "finally: print('too late')\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout.readline() == "ready\n"
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=ENDED)
    assert child.returncode == 130
    assert (out, err) == ("", "\nthe message\n")


def left_over(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def in_run_folder(output: str) -> list[str]:
    return [f"{output}.run/{name}" for name in ("heartbeat.json", "journal", "lock")]


@pytest.mark.slow
def test_ctrl_c_during_a_sweep(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(LONG)
    with subprocess.Popen(
        [*COMMAND, "sweep", "a.yaml"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stderr.readline() == "2000 points; 2000 to compute\n"
        for line in child.stderr:
            if "/2000 points, 0 failed, " in line:  # compiled and under way
                break
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=ENDED)
    assert child.returncode == 130
    assert out == ""
    heard, kept, again = err.strip().splitlines()
    assert heard == "Ctrl-C: finishing the blocks in flight; a second signal ends at once"
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
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(tmp_path)
        os.environ["TERM"] = "xterm"
        os.execv(sys.executable, [*COMMAND, "sweep", "a.yaml", "-o", "a.nc", "--overwrite"])
    seen, sent = b"", False
    while select.select([terminal], [], [], ENDED)[0]:
        try:
            seen += os.read(terminal, 65536)
        except OSError:  # the other end has closed
            break
        if not sent and b"points/s" in seen:
            os.write(terminal, b"\x03")
            sent = True
    os.close(terminal)
    assert sent
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 130
    tail = seen[seen.rindex(b"\x1b[?25l") :].decode()
    bar, message = tail.split("\x1b[?25h")
    assert "/2000" in bar
    assert "Ctrl-C: finishing the blocks in flight" in bar
    assert message.strip().startswith("Stopped: Ctrl-C. ")
    assert message.strip().endswith("To resume:\r\n  stickslip sweep a.yaml -o a.nc")
    assert old.read_bytes() == b"an older result"
    assert left_over(tmp_path) == ["a.nc", *in_run_folder("a.nc"), "a.yaml"]


@pytest.mark.slow
def test_ctrl_c_during_a_trajectory(tmp_path: Path) -> None:
    arguments = ["--periods", "1000", "--set", "integrator.rtol=1e-12", "-o", "a.nc"]
    code = (
        "import sys, threading, os, signal\n"
        "from sweeps.engine import trajectories\n"
        "from sweeps.cli import main\n"
        "simulate = trajectories.simulate\n"
        "def announced(*a, **k):\n"
        "    print('ready', flush=True)\n"
        "    return simulate(*a, **k)\n"
        "trajectories.simulate = announced\n"
        "main()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, "simulate", *arguments],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        assert child.stdout.readline() == "ready\n"
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=ENDED)
    assert child.returncode == 130
    assert (out, err) == ("", "\nInterrupted; nothing was kept.\n")
    assert left_over(tmp_path) == []
