"""`status`, `plan` and signals: the state of a sweep, its estimate, and its end."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.marks import one_then
from support.sweeps.processes import HANGS, Running, wait_until
from support.sweeps.sweeping import (
    LOOSE,
    ONE_BY_ONE,
    Shell,
    child,
    entries,
    everything,
    hash_at_once,
    hash_of,
    write,
)

from stickslip.dispatch.thread_pool import ThreadExecutor
from sweeps.engine import plan, resume, sweep
from sweeps.engine.sweep import JournaledResult
from sweeps.exits import StorageError

A_YAML = "sweep: {temperature: [200, 210, 230, 250]}\noutput: a.nc\n" + LOOSE + ONE_BY_ONE
# Minutes of work, in blocks of one point or all at once.
LONG = """\
sweep: {temperature: {linspace: [150, 320], num: 2000}}
integrator: {rtol: 1e-10}
stationary: {rtol: 1e-10}
output: a.nc
"""
IN_ONE = "execution: {workers: 1, block_points: 2000}\n"


# --- status ---


def state_of(shell: Shell, target: str) -> dict[str, Any]:
    """The output of `status --json`, which changes nothing."""
    before = everything()
    code, out, err = shell("status", target, "--json")
    assert (code, err) == (0, "")
    assert out.count("\n") == 1
    assert everything() == before
    return dict(json.loads(out))


def test_status_of_nothing(shell: Shell) -> None:
    for target in ("a.nc", "a.yaml"):
        assert state_of(shell, target) == {"output": "a.nc", "state": "absent"}
        code, out, err = shell("status", target)
        assert (code, out) == (5, "")
        assert err == "a.nc does not exist, and no sweep was ever started for it\n"
    assert entries() == ["a.yaml"]


def test_status_of_another_file_names_no_option_that_it_lacks(shell: Shell) -> None:
    shell.ok("simulate", "a.yaml", "--set", "T=200", "-o", "t.nc")
    said = "t.nc exists but is not the result of a sweep\n"
    assert shell("status", "t.nc") == (2, "", said)


def test_status_of_an_interrupted_a_partial_and_a_complete_sweep(shell: Shell) -> None:
    def poison(rows: np.ndarray) -> None:
        if rows[0, 0] == 230.0:
            raise ValueError("poison")

    shell.interrupted("sweep", "a.yaml", after=2)
    done = len(shell.computed)
    expected = {
        "output": "a.nc",
        "state": "interrupted",
        "points": 4,
        "done": done,
        "failed": 0,
        "pending": 4 - done,
        "statuses": {"ok": done},
    }
    assert state_of(shell, "a.yaml") == state_of(shell, "a.nc") == expected
    assert shell("status", "a.nc").out.splitlines()[:2] == [
        "a.nc: interrupted",
        f"{done} of 4 points done, 0 failed",
    ]
    for verb in ("plot", "export", "replay", "info"):
        code, out, err = shell(verb, "a.nc")
        assert (code, out) == (5, "")
        assert err.startswith("a.nc does not exist yet: its sweep is not finished; run the command")
        assert "--partial to write the points finished so far" in err
    shell("sweep", "a.yaml", "--partial")
    shell.ok("export", "a.nc")
    assert state_of(shell, "a.nc") == expected
    shutil.rmtree("a.nc.run")
    assert state_of(shell, "a.nc") == expected | {"state": "partial"}
    shell.disturb = poison
    shell("sweep", "a.yaml", "--overwrite")
    complete = {"state": "complete", "done": 4, "failed": 1, "pending": 0}
    assert state_of(shell, "a.nc") == expected | complete | {"statuses": {"ok": 3, "failed": 1}}
    code, out, err = shell("status", "a.yaml")
    assert (code, err) == (0, "")
    assert out.splitlines()[:2] == ["a.nc: complete", "4 of 4 points done, 1 failed"]
    assert "  1 failed: The computation raised an exception" in out
    shell("sweep", "a.yaml", "-o", "b.nc", "--keep-journal")
    assert state_of(shell, "b.nc")["state"] == "complete"


def test_a_sweep_is_not_complete_before_its_result_is_written(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    def poison(rows: np.ndarray) -> None:
        if rows[0, 0] == 230.0:
            raise ValueError("poison")

    def fail(_: JournaledResult) -> None:
        raise StorageError("no room")

    shell.disturb = poison
    assert shell("sweep", "a.yaml", "--keep-journal").code == 3
    assert state_of(shell, "a.nc")["state"] == "complete"
    shell.disturb = None
    grown = ("sweep", write("b.yaml", A_YAML.replace("250]", "250, 260]")))
    for command in (("sweep", "a.yaml", "--retry-failed"), grown):
        with monkeypatch.context() as patch:
            patch.setattr(JournaledResult, "write", fail)
            assert shell(*command).code == 5
        state = state_of(shell, "a.nc")
        assert (state["state"], state["pending"], state["failed"]) == ("interrupted", 0, 0)
    shell.ok(*grown)
    assert state_of(shell, "a.nc")["state"] == "complete"


def test_status_of_what_cannot_be_read(shell: Shell) -> None:
    Path("a.nc").write_bytes(b"no result")
    Path("folder").mkdir()
    assert shell("status", "a.nc").code == 5
    assert shell("status", "folder").code == 5
    assert shell("status", "missing.yaml").code == 2


def test_status_of_a_running_part_names_it(shell: Shell) -> None:
    said: list[dict[str, Any]] = []
    shell.disturb = lambda _: said.append(resume.state_of(Path("a.nc")))
    shell.ok("sweep", "a.yaml", "-o", "a.nc", "--part", "1/2")
    shell.disturb = None
    assert {(state["state"], state["part"], state["points"]) for state in said} == {
        ("running", "1/2", 2)
    }


@pytest.mark.slow
def test_status_of_a_running_sweep_does_not_disturb_it(shell: Shell) -> None:
    write("long.yaml", LONG, "execution: {block_points: 1}\n")
    running = child(["sweep", "long.yaml"])
    wait_until(lambda: running_state(shell).get("done", 0) > 0, running.is_alive)
    state = running_state(shell)
    assert state["state"] == "running"
    assert state["points"] == 2000
    assert state["pid"] == running.pid
    assert state["command"] == "stickslip sweep long.yaml"
    assert 0 < state["done"] == 2000 - state["pending"]
    # A heartbeat may fall between the moment a block of one point is back and the one it is kept.
    assert state["computed"] - state["done"] in (0, 1)
    assert state["points_per_second"] > 0.0
    assert state["seconds_left"] > 0.0
    assert {"host", "started", "updated", "backend", "slots", "statuses"} <= state.keys()
    lines = shell("status", "long.yaml").out.splitlines()
    assert lines[0] == "a.nc: running"
    assert re.fullmatch(r"\d+ of 2000 points done, 0 failed", lines[1])
    assert re.fullmatch(r"[\d.]+ points/s, about .* left", lines[2])
    assert lines[3].startswith(f"process {running.pid} on ")
    os.kill(running.pid, signal.SIGTERM)
    running.join(HANGS)
    assert running.exitcode == 4
    assert state_of(shell, "a.nc")["done"] >= state["done"]


def running_state(shell: Shell) -> dict[str, Any]:
    """The output of `status --json` for a sweep that is running."""
    return dict(json.loads(shell("status", "a.nc", "--json").out))


# --- plan ---


def test_plan_prints_points_blocks_bytes_and_time_and_writes_nothing(shell: Shell) -> None:
    write("b.yaml", "sweep: {T: {linspace: [150, 320], num: 200}, gamma: [0, 2/3]}\n", LOOSE)
    code, out, err = shell("plan", "b.yaml", "--workers", "3")
    assert (code, err) == (0, "")
    points, blocks, size, duration = out.splitlines()
    assert points == "points: 400"
    assert int(blocks.removeprefix("blocks: ")) >= 1
    pattern = r"bytes: up to [\d.]+ KiB for the result, 96.9 KiB for the journal while it runs"
    assert re.fullmatch(pattern, size)
    pattern = r"time: .* s on 3 workers \(threads\), from a sample of (\d+); rare slow points .*"
    found = re.fullmatch(pattern, duration)
    assert found is not None
    assert 0 < int(found[1]) <= 400
    assert entries() == ["a.yaml", "b.yaml"]


@pytest.mark.parametrize(
    "axes",
    [
        "sweep: {T: [200, 250]}",
        "sweep: {T: {linspace: [150, 320], num: 8}, K: {linspace: [500, 6000], num: 8}}",
        "sample: {sobol: 64, seed: 1, T: [150, 320], K: [500, 6000]}",
    ],
)
def test_a_result_is_hardly_smaller_than_plan_says_and_not_larger(shell: Shell, axes: str) -> None:
    write("b.yaml", axes, "\n", LOOSE)
    _, _, size, _ = shell.ok("plan", "b.yaml").out.splitlines()
    most = float(size.removeprefix("bytes: up to ").partition(" KiB")[0])
    shell.ok("sweep", "b.yaml", "-o", "b.nc")
    assert 0.9 * most < Path("b.nc").stat().st_size / 1024 <= most


def test_plan_counts_existing_points(shell: Shell) -> None:
    shell.interrupted("sweep", "a.yaml", after=2)
    there = len(shell.computed)
    before = everything()
    assert shell("plan", "a.yaml").out.startswith(f"points: 4, {there} already computed\n")
    assert everything() == before
    shell("sweep", "a.yaml")
    before = everything()
    code, out, _ = shell("plan", "a.yaml", "--set", "gamma=[-2/3, 0]")
    assert (code, out.splitlines()[0]) == (0, "points: 8, 4 already computed")
    assert {point.rheological_index for point in shell.computed} == {0.0}
    code, out, _ = shell("plan", "a.yaml")
    assert (code, shell.computed) == (0, [])
    assert out.splitlines()[:2] == ["points: 4, 4 already computed", "blocks: 0"]
    assert everything() == before


def test_a_plan_samples_the_few_points_that_are_left(shell: Shell) -> None:
    axis = "sweep: {{T: {{linspace: [200, {}], num: {}}}}}\noutput: b.nc\n"
    shell.ok("sweep", write("b.yaml", axis.format(349, 150), LOOSE))
    for length in range(151, 155):  # of 128 strata, which hardly ever meet the last points
        out = shell.ok("plan", write("b.yaml", axis.format(199 + length, length), LOOSE)).out
        assert f"from a sample of {length - 150};" in out
        assert shell.values("temperature")[0] > 349


def test_workers_are_counted_where_the_points_are_computed(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (plan, sweep):  # as on a cluster, which has its own number
        monkeypatch.setattr(module, "make_executor", lambda _: ThreadExecutor(5))
    assert " on 5 workers (threads), from a sample " in shell.ok("plan", "a.yaml").out
    shell.ok("sweep", "a.yaml")
    assert json.loads(Path("a.nc.timing.json").read_text())["workers"] == 5


# --- signals ---

SIGNALS = [(signal.SIGINT, 130), (signal.SIGTERM, 4), (signal.SIGHUP, 4)]
"""Signals and the exit codes of what they end."""


def begun(*parts: str) -> Any:
    """A sweep in another process, which is computing its first block."""
    process = child(["sweep", write("long.yaml", LONG, *parts)], begun="begun")
    wait_until(Path("begun").exists, process.is_alive)
    return process


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), one_then("faults", SIGNALS))
def test_a_signal_finishes_blocks_in_flight_and_prints_how_to_resume(
    shell: Shell, number: signal.Signals, code: int
) -> None:
    process = begun("execution: {block_points: 1}\n")
    os.kill(process.pid, number)
    process.join(HANGS)
    said = Path("messages").read_text()
    assert process.exitcode == code, said
    name = "Ctrl-C" if number == signal.SIGINT else number.name
    assert re.search(rf"\n{name}: finishing [12] points? in flight.*\.\n", said)
    again = "Ctrl-C" if number == signal.SIGINT else "signal"
    assert f"Another {again} ends the run at once and drops the points in flight.\n" in said
    kept = re.search(rf"Stopped: {name}\. (\d+) of 2000 points are kept in a\.nc\.run\.", said)
    assert kept
    assert said.endswith("To resume:\n  stickslip sweep long.yaml\n")
    state = state_of(shell, "a.nc")
    assert (state["state"], state["done"]) == ("interrupted", int(kept[1]))
    shell.interrupted("sweep", "long.yaml", after=1)
    more = len(shell.computed)
    assert state_of(shell, "a.nc")["done"] == int(kept[1]) + more > int(kept[1])


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), one_then("faults", SIGNALS))
def test_a_second_signal_ends_at_once(shell: Shell, number: signal.Signals, code: int) -> None:
    process = begun(IN_ONE)
    os.kill(process.pid, number)
    wait_until(lambda: "drops the points" in Path("messages").read_text(), process.is_alive)
    os.kill(process.pid, number)
    process.join(HANGS)
    said = Path("messages").read_text()
    assert process.exitcode == code, said
    assert said.endswith("\nEnded at once; points in the journal are kept.\n")
    shell.ok("sweep", "a.yaml", "--overwrite")
    assert hash_of("a.nc") == hash_at_once("a.yaml")


@pytest.mark.faults
def test_a_hangup_that_is_ignored_as_under_nohup_ends_no_sweep(shell: Shell) -> None:
    few = write("few.yaml", LONG.replace("2000", "8"), "execution: {block_points: 1}\n")
    ignoring = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)"
    running = Running("-c", f"{ignoring}\nfrom sweeps.cli import main; main()", "sweep", few)
    wait_until(Path("a.nc.run/heartbeat.json").exists, running.is_alive)
    running.signal(signal.SIGHUP)
    code, _, err = running.ended()
    assert code == 0, err
    assert Path("a.nc").exists()
