"""Standard streams that are closed, full or without a reader do not affect a command."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from support import messages
from support.marks import one_then
from support.sweeps.processes import HANGS, Running, default_signals
from support.sweeps.sweeping import LOOSE, hash_at_once, hash_of, write
from support.sweeps.watching import OnTerminal

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
def test_a_sweep_finishes_with_any_streams(streams: str) -> None:
    with default_signals():
        ended = subprocess.run(
            ["bash", "-c", f"{STICKSLIP} sweep a.yaml -o a.nc {streams}"], timeout=HANGS
        )
    assert ended.returncode == 0
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_a_terminal_that_is_closed_ends_a_sweep_like_a_signal() -> None:
    write("b.yaml", "sweep: {temperature: {linspace: [150, 320], num: 2000}}\n", LOOSE)
    command = ["sweep", "b.yaml", "-o", "b.nc"]
    child = OnTerminal("from sweeps.cli import main; main()", *command, folder=Path())
    child.shows(" points/s")  # some are finished
    assert child.hung_up() == 4
    assert Path("b.nc.run/journal").exists()


def test_without_a_home_compiled_code_is_not_kept() -> None:
    code = (
        "import pwd, os\n"
        "def nobody(*_): raise KeyError('no such user')\n"
        "pwd.getpwuid = nobody\n"
        "import stickslip.kernels.adaptive.driver\n"
        "from sweeps.cli import main\n"
        "main()\n"
    )
    bare = {k: v for k, v in os.environ.items() if k in ("PATH", "PYTHONPATH")}
    ended, out, err = Running("-c", code, "info", env=bare).ended()
    assert ended == 0, err
    assert f"{messages.NOT_CACHED}there is no home folder" in out
    assert err.count(f"{messages.NOT_CACHED}there is no home folder") == 1
