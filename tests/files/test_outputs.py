"""Outputs that are not files, on a full disk, damaged, or in use: refused at once, and unharmed."""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from support import messages
from support.sweeps.processes import HANGS, wait_until
from support.sweeps.sweeping import (
    LOOSE,
    ONE_BY_ONE,
    Mishap,
    Shell,
    child,
    entries,
    fill_the_disk,
    hash_at_once,
    hash_of,
    write,
)

from sweeps.files import run_folder
from sweeps.files.netcdf import open_result
from sweeps.files.run_folder import InUseError, RunFolder

FOUR = "sweep: {temperature: [200, 210, 230, 250]}\n"
A_YAML = FOUR + LOOSE
FIVE = "sweep: {temperature: [200, 210, 230, 250, 270]}\n"
# Minutes of work in blocks of one point.
LONG = """\
sweep: {temperature: {linspace: [150, 320], num: 2000}}
integrator: {rtol: 1e-10}
stationary: {rtol: 1e-10}
execution: {block_points: 1}
"""


# --- no file, no room ---


NO_OUTPUTS = {
    "folder": (5, "folder is a folder; -o must name a file"),
    "pipe": (5, "pipe is not an ordinary file; -o must name one"),
    "full": (5, "full is not an ordinary file; -o must name one"),
    "loop": (5, "cannot write loop: (.*[Ll]oop|Too many levels)"),
    "nowhere": (
        5,
        "cannot write nowhere: it is a link to .*missing/a.nc, whose folder does not exist",
    ),
    "file/a.nc": (5, "cannot write file/a.nc: file is not a folder"),
    "taken.nc": (5, "cannot write into taken.nc.run: it is not a folder"),
    "linked.nc": (5, ".*linked.nc.run: it is not a folder"),
    "/proc/nowhere/a.nc": (5, ""),
    "a.yaml": (2, "a.yaml is the config itself; -o names the result"),
    "config.nc": (2, "config.nc is the config itself; -o names the result"),
}
"""Outputs that cannot be written: the exit code of a sweep, and its message."""


@pytest.mark.parametrize("option", [[], ["--overwrite"], ["--partial"]])
def test_an_impossible_output_is_refused_and_left_alone(shell: Shell, option: list[str]) -> None:
    Path("folder").mkdir()
    os.mkfifo("pipe")
    for file in ("file", "taken.nc.run"):
        Path(file).write_text("mine")
    for link, target in {
        "full": "/dev/full",  # were it replaced, only the link would be
        "loop": "loop",
        "nowhere": "missing/a.nc",
        "linked.nc.run": "folder",
        "config.nc": "a.yaml",
    }.items():
        Path(link).symlink_to(target)
    before = entries()
    for output, (code, words) in NO_OUTPUTS.items():
        found = shell("sweep", "a.yaml", "-o", output, *option)
        assert (found.code, found.out) == (code, ""), output
        assert re.match(words, found.err), found.err
        assert found.err.count("\n") == 1
        assert shell.computed == []
        assert (entries(), entries("folder")) == (before, [])
        assert Path("a.yaml").read_text() == A_YAML


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a disk of one MiB."""
    path = tmp_path / "disk"
    path.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "none", str(path)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("this user may not mount a disk")
    yield path
    # Lazily: the server that forks the children may stand in there.
    subprocess.run(["umount", "--lazy", str(path)], check=True)


FULL = {
    "before anything": None,
    "before the journal": Mishap("sweeps.files.journal", "begin", kills=False),
    "before the trial": Mishap("netCDF4", "Dataset", 1, of="'w'", kills=False),
    "before the first block": Mishap("os", "pwrite", 1, kills=False),
    "before the result": Mishap("netCDF4", "Dataset", 2, of="'w'", kills=False),
    "while the result is filled": Mishap("sweeps.files.sweep_file:Digests", "add", kills=False),
}


@pytest.mark.slow
def test_a_full_disk_costs_no_finished_points(
    shell: Shell, small_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(small_disk)
    write("a.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    old = Path("a.nc").read_bytes()
    write(
        "b.yaml",
        "sweep: {temperature: {linspace: [200, 250], num: 6}, K: [1e3, 2e3, 3e3]}\n",
        LOOSE,
    )
    expected = hash_at_once("b.yaml")
    for time_, mishap in FULL.items():
        for path in Path().glob("b.nc*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        shutil.copy("a.nc", "b.nc")
        command = ["sweep", "b.yaml", "-o", "b.nc", "--overwrite"]
        if mishap is None:
            fill_the_disk()
        process = child(command, *filter(None, [mishap]), log="../messages")
        process.join(HANGS)
        said = Path("../messages").read_text()
        assert process.exitcode == 5, (time_, said)
        assert "Traceback" not in said, time_
        assert re.search("cannot write .*b\\.nc|KiB left", said.splitlines()[-1]), (time_, said)
        assert re.search("[Nn]o space left|KiB left", said.splitlines()[-1]), (time_, said)
        assert Path("b.nc").read_bytes() == old, time_
        assert not list(Path().rglob("result.nc")), time_
        Path("filler").unlink()
        code, _, err = shell("sweep", "b.yaml", "-o", "b.nc", "--overwrite")
        assert code == 0, (time_, err)
        assert hash_of("b.nc") == expected, time_


# --- in use ---


@pytest.mark.slow
def test_a_second_sweep_to_an_output_names_the_first(shell: Shell) -> None:
    write("long.yaml", LONG)
    first = child(["sweep", "long.yaml", "-o", "a.nc"], log="first")
    wait_until(Path("a.nc.run/heartbeat.json").exists)
    for option in ([], ["--overwrite"], ["--partial"]):
        code, out, err = shell("sweep", "a.yaml", "-o", "a.nc", *option)
        assert (code, out, shell.computed) == (4, "", [])
        assert err.startswith(f"a.nc {messages.IN_USE} (process ")
        assert f"process {first.pid} on " in err
        assert err.endswith(": stickslip sweep long.yaml -o a.nc)\n")
        assert first.is_alive()
    os.kill(first.pid, signal.SIGKILL)
    first.join(HANGS)
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 2
    assert messages.OTHER_SETTINGS in err


@pytest.mark.slow
def test_a_sweep_that_has_just_begun_does_not_look_killed(shell: Shell) -> None:
    write("long.yaml", LONG)
    command = ["sweep", "long.yaml", "-o", "a.nc"]
    killed = child(command, log="killed")
    wait_until(Path("a.nc.run/heartbeat.json").exists)
    killed.kill()
    killed.join(HANGS)
    with RunFolder(Path("a.nc")).held():  # a sweep that still compiles
        code, _, err = shell(*command)
        assert code == 4
        assert f"process {killed.pid} " not in err


@pytest.mark.faults
@pytest.mark.parametrize("pairs", [3, 30])
def test_of_sweeps_begun_at_once_one_works_and_none_does_harm(shell: Shell, pairs: int) -> None:
    write("a.yaml", FOUR, LOOSE, ONE_BY_ONE)
    expected = hash_at_once("a.yaml")
    for number in range(pairs):
        command = ["sweep", "a.yaml", "-o", f"{number}.nc"]
        both = [child(command, log=f"{number}.{i}") for i in range(2)]
        for process in both:
            process.join(HANGS)
        said = [Path(f"{number}.{i}").read_text() for i in range(2)]
        assert sorted(process.exitcode for process in both) in ([0, 0], [0, 4]), said
        worked = [f"{number}.nc\n4 points in " in text for text in said]
        assert sum(worked) == 1, said
        for process, text, did in zip(both, said, worked, strict=True):
            if not did:
                done = process.exitcode == 0
                assert ("is complete: 4 points" if done else f"{number}.nc is ") in text
        assert hash_of(f"{number}.nc") == expected
        assert f"{number}.nc.run" not in entries()


def test_a_run_that_ends_leaves_the_lock_of_the_next_alone(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next run takes the output at the moment the lock is released."""
    output, next_run = Path("a.nc"), ExitStack()
    release = run_folder.FileLock.release

    def released(lock: run_folder.FileLock, *args: object, **kwargs: object) -> None:
        was_held = lock.is_locked
        release(lock, *args, **kwargs)
        if not was_held:  # one of an earlier test that is collected just now
            return
        monkeypatch.setattr(run_folder.FileLock, "release", release)
        next_run.enter_context(RunFolder(output).held())
        (RunFolder(output).path / "journal.new").write_text("begun")

    monkeypatch.setattr(run_folder.FileLock, "release", released)
    with next_run:
        with RunFolder(output).held():
            pass
        assert entries("a.nc.run") == ["heartbeat.json", "journal.new", "lock"]
        with pytest.raises(InUseError), RunFolder(output).held():
            pass


# --- damaged ---


def test_damage_within_a_journal_costs_the_damaged_block_alone(shell: Shell) -> None:
    config = write("b.yaml", FOUR, LOOSE, ONE_BY_ONE)
    shell.interrupted("sweep", config, "-o", "b.nc", after=3)
    first = shell.values("temperature")
    journal = Path("b.nc.run/journal")
    damaged = bytearray(journal.read_bytes())
    damaged[-400] ^= 4  # the last block but one, or that before it
    journal.write_bytes(damaged)
    code, _, err = shell("sweep", config, "-o", "b.nc")
    assert code == 0
    assert re.search(r"\d+ damaged bytes .*were skipped", err)
    assert f"4 points: {len(first) - 1} in its journal" in err
    assert len(shell.computed) == 4 - len(first) + 1
    assert hash_of("b.nc") == hash_at_once(config)


@pytest.mark.slow
def test_a_damaged_byte_of_an_older_result_never_adds_a_wrong_number(shell: Shell) -> None:
    shell.ok("sweep", "a.yaml", "-o", "good.nc")
    good, draw = Path("good.nc").read_bytes(), random.Random(11)
    shell.ok("sweep", write("b.yaml", FIVE, LOOSE), "-o", "five.nc")
    expected = open_result(Path("five.nc"))
    # Places all over the file, and numbers that compression left as they are but for their order.
    # A bit is cleared: what is set may be the length of a list that netCDF walks to its end.
    places = [place for place in draw.sample(range(len(good)), 60) if good[place]]
    for variable in expected.data_vars.values():
        shuffled = np.ascontiguousarray(variable.values[:4]).view(np.uint8).reshape(4, -1).T
        found = good.find(shuffled.tobytes())
        places += [p for p in range(found, found + 16) if found >= 0 and good[p]]
    for place in places:
        damaged = bytearray(good)
        damaged[place] &= damaged[place] - 1
        Path("b.nc").write_bytes(damaged)
        code, _, err = shell("sweep", "b.yaml", "-o", "b.nc")
        if code == 0:
            found = open_result(Path("b.nc"))
            assert all(found[name].equals(expected[name]) for name in expected.variables), place
        else:
            assert code in (2, 5), (place, err)
            assert "b.nc" in err
            assert "--overwrite" in err
            assert Path("b.nc").read_bytes() == damaged, place
            assert "b.nc.run" not in entries(), place
