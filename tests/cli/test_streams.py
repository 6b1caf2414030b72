"""Standard streams that are closed, full or without a reader decide nothing."""

from __future__ import annotations

import fcntl
import os
import pty
import subprocess
import sys
import termios
from pathlib import Path

import pytest
from support.marks import one_then
from support.sweeps.processes import HANGS, default_signals, wait_until
from support.sweeps.sweeping import LOOSE, hash_at_once, hash_of, write

SWEEP = "sweep: {temperature: [200, 250]}\n"
STICKSLIP = f"{sys.executable} -m sweeps.cli"

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write("a.yaml", SWEEP, LOOSE)


@pytest.mark.parametrize(
    "streams",
    one_then(
        "faults",
        [
            "<&- >&- 2>&-",
            "2>&-",
            "2>/dev/full",
            ">/dev/full 2>/dev/full",
            "2> >(true)",
            "> >(true)",
        ],
    ),
)
def test_a_sweep_comes_to_its_end_whoever_listens(streams: str) -> None:
    with default_signals():
        ended = subprocess.run(
            ["bash", "-c", f"{STICKSLIP} sweep a.yaml -o a.nc {streams}"], timeout=HANGS
        )
    assert ended.returncode == 0
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_a_terminal_that_is_closed_ends_a_sweep_like_a_signal() -> None:
    write("b.yaml", "sweep: {temperature: {linspace: [150, 320], num: 2000}}\n", LOOSE)
    ours, theirs = pty.openpty()

    def own_terminal() -> None:
        os.setsid()
        fcntl.ioctl(theirs, termios.TIOCSCTTY, 0)

    with default_signals():
        process = subprocess.Popen(
            [sys.executable, "-m", "sweeps.cli", "sweep", "b.yaml", "-o", "b.nc"],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            preexec_fn=own_terminal,
        )
    os.close(theirs)
    journal = Path("b.nc.run/journal")
    try:
        wait_until(
            lambda: journal.exists() and journal.stat().st_size > 20_000,
            lambda: process.poll() is None,
        )
        os.close(ours)
        assert process.wait(HANGS) == 4
    finally:
        process.kill()
        process.wait()
    assert journal.exists()


def test_without_a_home_code_is_compiled_and_not_kept() -> None:
    code = (
        "import pwd, os\n"
        "def nobody(*_): raise KeyError('no such user')\n"
        "pwd.getpwuid = nobody\n"
        "import stickslip.kernels.adaptive.driver\n"
        "from sweeps.cli import main\n"
        "main()\n"
    )
    bare = {k: v for k, v in os.environ.items() if k in ("PATH", "PYTHONPATH")}
    with default_signals():
        ended = subprocess.run(
            [sys.executable, "-c", code, "info"],
            env=bare,
            capture_output=True,
            text=True,
            timeout=HANGS,
        )
    assert ended.returncode == 0, ended.stderr
    assert "compiled code is not cached: there is no home folder" in ended.stdout
    assert ended.stderr.count("compiled code is not cached: there is no home folder") == 1
