"""The output of a sweep whose kernels or blocks take long, on a terminal and in a log."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.marks import one_then
from support.sweeps.commands import FOUR_POINTS, entries
from support.sweeps.processes import Running
from support.sweeps.watching import HIDDEN, VISIBLE, OnTerminal, plain

pytestmark = pytest.mark.slow

# The command, in which seconds are short.
HASTY = """\
import time
from pathlib import Path
from sweeps.engine import computing, plan, progress, trajectories
from stickslip.dispatch import thread_pool
from sweeps.cli import main
progress.SOON = 0.1
progress.MOMENT = 0.0
progress.SECONDS_BETWEEN_LINES = 0.1
def waiting_for_gate(function):
    def waiting(*arguments):
        while not Path("gate").exists():
            time.sleep(0.01)
        return function(*arguments)
    return waiting
"""
SLOW_BLOCKS = HASTY + (
    "thread_pool.compute_block = waiting_for_gate(thread_pool.compute_block)\n"
    "progress.MOMENT = 1000.0\n"
    "main()\n"
)
SLOW_COMPILER = HASTY + (
    "computing.compile_kernels = waiting_for_gate(computing.compile_kernels)\n"
    "plan.compile_kernels = waiting_for_gate(plan.compile_kernels)\n"
    "begin = trajectories.compile_trajectory_kernels\n"
    "trajectories.compile_trajectory_kernels = waiting_for_gate(begin)\n"
    "main()\n"
)

WORD = "compiling for this processor: up to a minute; the code is kept"
SWEEP = ["sweep", "a.yaml", "-o", "a.nc", "--set", "execution.block_points=4"]
SIMULATE = ["simulate", "-o", "a.nc", "--periods", "1"]
COMMANDS = [SWEEP, ["plan", "a.yaml"], SIMULATE]
STUCK = "4 points in flight, the oldest for 0:"
FINISHING = "Ctrl-C: finishing 4 points in flight, the oldest for 0:"
AT_ONCE = "Another Ctrl-C ends the run at once and drops the points in flight."


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.yaml").write_text(FOUR_POINTS)
    return tmp_path


def open_gate(folder: Path) -> None:
    (folder / "gate").touch()


# --- blocks that take long ---


def test_a_terminal_shows_the_blocks_in_flight_and_the_effect_of_ctrl_c(folder: Path) -> None:
    child = OnTerminal(SLOW_BLOCKS, *SWEEP, folder=folder)
    child.shows(STUCK)
    child.types(b"\x03")
    child.shows(FINISHING)
    child.shows(AT_ONCE)
    child.shows(f"stopping, {STUCK}")
    open_gate(folder)
    assert child.ended() == 0  # nothing was missing in the end
    assert child.text.count(HIDDEN) == child.text.count(VISIBLE) == 1
    assert "4/4 points, 0 failed, " in plain(child.text)


@pytest.mark.faults
def test_another_ctrl_c_gives_the_terminal_back_and_the_points_up(folder: Path) -> None:
    child = OnTerminal(SLOW_BLOCKS, *SWEEP, folder=folder)
    child.shows(STUCK)
    child.types(b"\x03")
    child.shows(FINISHING)
    child.types(b"\x03")
    assert child.ended() == 130
    assert child.text.count(HIDDEN) == child.text.count(VISIBLE) == 1
    assert plain(child.text).endswith("Ended at once; points in the journal are kept.\r\n")


# --- kernels that take long ---


@pytest.mark.parametrize("command", one_then("faults", COMMANDS), ids=lambda command: command[0])
def test_a_log_says_that_kernels_are_compiled(folder: Path, command: list[str]) -> None:
    child = Running("-c", SLOW_COMPILER, *command, cwd=folder)
    child.says(f"{WORD} (0:", times=2)
    open_gate(folder)
    code, _, err = child.ended()
    assert code == 0
    assert err.replace("\n", "").isprintable()


@pytest.mark.parametrize("command", one_then("faults", COMMANDS), ids=lambda command: command[0])
def test_ctrl_c_while_compiling_leaves_a_clean_terminal(folder: Path, command: list[str]) -> None:
    child = OnTerminal(SLOW_COMPILER, *command, folder=folder)
    child.shows(WORD)
    child.types(b"\x03")
    assert child.ended() == 130
    assert child.text.count(HIDDEN) == child.text.count(VISIBLE) == 1
    last = plain(child.text.rpartition("\x1b[2K")[2])
    assert WORD not in last
    if command == SWEEP:
        assert "Stopped: Ctrl-C. 0 of 4 points" in last
    else:
        assert "Interrupted; nothing was kept." in last
        assert entries(folder) == ["a.yaml"]
