"""Kills and failing files: finished points and an older result are kept, and the sweep resumes."""

from __future__ import annotations

import errno
import itertools
import os
import random
import shutil
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.marks import marked, one_then
from support.sweeps.processes import HANGS, Running, wait_until
from support.sweeps.sweeping import (
    LOOSE,
    ONE_BY_ONE,
    Mishap,
    Shell,
    child,
    entries,
    hash_at_once,
    hash_of,
    write,
)

from stickslip import Parameters
from sweeps.config.load import load
from sweeps.engine.existing import found_in_journal
from sweeps.files.journal import readable_manifest
from sweeps.files.run_folder import RunFolder
from sweeps.grid import Grid
from sweeps.identity import PointKeys

SMALL = "sweep: {temperature: [200, 250]}\n"
A_YAML = "sweep: {temperature: [200, 210, 230, 250, 270]}\n" + LOOSE + ONE_BY_ONE


@pytest.fixture
def shell(shell: Shell) -> Shell:
    """A folder with a good result, `old.nc`, and `a.yaml`, which extends it."""
    shell.ok("sweep", write("old.yaml", SMALL, LOOSE), "-o", "old.nc")
    return shell


@pytest.fixture
def expected(shell: Shell) -> str:
    return hash_at_once("a.yaml")


# --- kills ---


# Seconds of work in blocks of a few tenths, so that a kill finds some finished and some in flight.
RANDOM = """\
sweep:
  temperature: {linspace: [150, 320], num: 100}
  rheological_index: [-2/3, -1/3, 0, 2/3]
integrator: {rtol: 1e-9}
stationary: {rtol: 1e-9}
execution: {workers: 2, block_points: 10}
"""
# The command, noting the parameters of each block before it is computed.
NOTING = """\
import os, sys
import numpy as np
from stickslip.dispatch import task as worker
from sweeps.cli.app import main
log = os.open("begun", os.O_WRONLY | os.O_APPEND | os.O_CREAT)
compute_orbits = worker.compute_orbits
def noted(points, options, **how):
    os.write(log, np.ascontiguousarray(points).tobytes())
    return compute_orbits(points, options, **how)
worker.compute_orbits = noted
main()
"""


@pytest.mark.faults
def test_kills_at_random_times_lose_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    grid, draw = Grid.from_config(load(write("r.yaml", RANDOM))), random.Random(7)
    keys = PointKeys(grid, {}, alone=True)
    output, log, command = Path("r.nc"), Path("begun"), ["sweep", "r.yaml", "-o", "r.nc"]

    def begun() -> list[int]:
        rows = np.fromfile(log).reshape(-1, len(Parameters._fields)) if log.exists() else []
        return keys.numbers_of(rows).tolist() if len(rows) else []

    kept: dict[int, bytes] = {}  # the points of the journal after the last kill, and their rows
    for kill in range(7):
        log.unlink(missing_ok=True)
        sweep = Running("-c", NOTING, *command)
        if kill < 6:
            blocks, seconds = draw.randint(1, 5), draw.uniform(0.0, 0.1)
            wait_until(lambda n=10 * blocks: len(begun()) >= n, sweep.is_alive)
            time.sleep(seconds)
            sweep.process.kill()
        code, _, err = sweep.ended()
        points = begun()
        assert len(set(points)) == len(points)
        assert kept.keys().isdisjoint(points)
        if kill < 6:
            assert code == -signal.SIGKILL, err
            now = {
                int(index): row.tobytes()
                for indices, rows in found_in_journal_of(output)
                for index, row in zip(indices, rows, strict=True)
            }
            assert kept.items() <= now.items()
            assert len(set(points) - now.keys()) <= 2 * 10  # the points in flight
            kept = now
    assert code == 0, err
    assert entries() == ["begun", "r.nc", "r.nc.timing.json", "r.yaml"]
    assert hash_of("r.nc") == hash_at_once("r.yaml")


# The appends to the journal of this sweep, in order.
_APPEND = ("sweeps.files.journal:Journal", "append")
CARRIED, FIRST, LAST = ((*_APPEND, number) for number in (1, 2, 4))
RESULT = ("sweeps.engine.sweep:JournaledResult", "write", 1)

PLACES = {
    "before the journal is begun": Mishap("sweeps.files.journal", "begin"),
    "before its manifest is flushed": Mishap("os", "fsync", 1),
    "before the manifest has its name": Mishap("pathlib:Path", "replace", of="journal.json"),
    "after the manifest has its name": Mishap(
        "pathlib:Path", "replace", 1, "after", of="journal.json"
    ),
    "before the points of the old file": Mishap("os", "pwrite", within=CARRIED),
    "within the points of the old file": Mishap("os", "pwrite", 1, "half", within=CARRIED),
    "after the points of the old file": Mishap(*CARRIED, "after"),
    "before the manifest knows the old file": Mishap(
        "pathlib:Path", "replace", 2, of="journal.json"
    ),
    "after the manifest knows the old file": Mishap(
        "pathlib:Path", "replace", 2, "after", of="journal.json"
    ),
    "before the trial": Mishap("netCDF4", "Dataset", 1, of="'w'"),
    "within the trial": Mishap("netCDF4", "Dataset", 1, "after", of="'w'"),
    "before the first block": Mishap("os", "pwrite", within=FIRST),
    "within the first block": Mishap("os", "pwrite", 1, "half", within=FIRST),
    "after the first block": Mishap(*FIRST, "after"),
    "within the last block": Mishap("os", "pwrite", 1, "half", within=LAST),
    "before the result file": Mishap("netCDF4", "Dataset", 2, of="'w'"),
    "before the result is filled": Mishap("sweeps.files.sweep_file", "_fill"),
    "while the result is filled": Mishap("sweeps.files.sweep_file", "result_values", 6),
    "after the result is filled": Mishap("sweeps.files.sweep_file", "_fill", 1, "after"),
    "before the result is read back": Mishap("sweeps.files.sweep_file", "digests_of"),
    "before the result is flushed": Mishap("sweeps.files.atomic", "flush", of="result.nc"),
    "after the result is flushed": Mishap(
        "sweeps.files.atomic", "flush", 1, "after", of="result.nc"
    ),
    "before the result has its name": Mishap("pathlib:Path", "replace", of="result.nc"),
    "after the result has its name": Mishap("pathlib:Path", "replace", 1, "after", of="result.nc"),
    "after all is flushed": Mishap("sweeps.files.atomic", "flush", 2, "after", within=RESULT),
    "before the journal is taken away": Mishap("pathlib:Path", "unlink", 2, of="journal')"),
    "after the journal is taken away": Mishap("pathlib:Path", "unlink", 2, "after", of="journal')"),
}


_CARRIED = list(PLACES).index("after the points of the old file")


@pytest.mark.slow
@pytest.mark.parametrize(
    "places",
    one_then("faults", [[*PLACES][3::14], [*PLACES]]),
    ids=["some places", "every place"],
)
def test_a_kill_at_any_place_loses_nothing(shell: Shell, expected: str, places: list[str]) -> None:
    for number, place in enumerate(places):
        mishap = PLACES[place]
        output = f"{number}.nc"
        shutil.copy("old.nc", output)
        command = ["sweep", "a.yaml", "-o", output]
        process = child(command, mishap)
        process.join(HANGS)
        assert process.exitcode == -9, place
        renamed = hash_of(output) != hash_of("old.nc")
        assert not renamed or hash_of(output) == expected, place
        assert renamed == (place in list(PLACES)[-4:]), place
        kept = journaled(Path(output))
        code, _, err = shell(*command)
        assert code == 0, (place, err)
        assert not kept & set(shell.values("temperature")), place
        if not renamed:  # the old file has two points, whatever became of the journal
            assert len(shell.computed) == 5 - len(kept | {200.0, 250.0}), place
        if place in list(PLACES)[_CARRIED:-1]:
            assert {200.0, 250.0} <= kept, place
        assert hash_of(output) == expected, place
        assert not [name for name in entries() if name.startswith((f"{output}.run", f".{output}"))]


def found_in_journal_of(output: Path) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The numbers and the rows of the points in the journal of an output."""
    journal = RunFolder(output).journal
    manifest = readable_manifest(journal)
    return iter(()) if manifest is None else found_in_journal(journal, manifest).points()


def journaled(output: Path) -> set[float]:
    """The temperatures of the points in the journal of an output."""
    grid = Grid.from_config(load("a.yaml"))
    return {T for indices, _ in found_in_journal_of(output) for T in grid.rows(indices)[:, 0]}


# --- files that fail ---

ERRORS = (errno.ENOSPC, errno.EIO, errno.EACCES)
CALLS = [
    (os, "pwrite"),
    (os, "fsync"),
    *marked("faults", [((os, "open"),), ((os, "ftruncate"),), ((Path, "replace"),)]),
]


class Failing:
    """A function whose call `number`, from 1, fails; if it writes, half of the data is written."""

    def __init__(self, call: tuple[Any, str], number: int, error: int) -> None:
        self._function, self._number, self._error = getattr(*call), number, error
        self.calls = 0

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        self.calls += 1
        if self.calls == self._number:
            if self._function.__name__ == "pwrite":
                self._function(args[0], bytes(args[1])[: len(args[1]) // 2], args[2])
            raise OSError(self._error, os.strerror(self._error))
        return self._function(*args, **kwargs)


@pytest.fixture(params=["resumed", pytest.param("grown", marks=pytest.mark.faults)])
def beginning(request: pytest.FixtureRequest, shell: Shell) -> str:
    """The folder holds an older result, alone or with the journal of an interrupted sweep."""
    if request.param == "resumed":
        shell.interrupted("sweep", "a.yaml", "-o", "old.nc", after=1)
    return str(request.param)


@pytest.mark.slow
@pytest.mark.parametrize("error", one_then("faults", ERRORS), ids=errno.errorcode.get)
@pytest.mark.parametrize("call", CALLS, ids=lambda call: call[1])
def test_a_failing_call_ends_with_a_message_and_the_same_command_resumes(
    shell: Shell, expected: str, beginning: str, call: tuple[Any, str], error: int
) -> None:
    old = Path("old.nc").read_bytes()
    for number in itertools.count(1):
        output = f"{number}.nc"
        shutil.copy2("old.nc", output)  # with its time, by which a journal knows it
        if beginning == "resumed":
            shutil.copytree("old.nc.run", f"{output}.run")
        command = ("sweep", "a.yaml", "-o", output)
        with pytest.MonkeyPatch.context() as patch:
            failing = Failing(call, number, error)
            patch.setattr(*call, lambda *a, failing=failing, **more: failing(*a, **more))
            code, out, err = shell(*command)
        if failing.calls < number:
            break
        if code == 0:
            assert hash_of(output) == expected, number
        else:
            assert (code, out) == (5, ""), (number, err)
            assert output in err.splitlines()[-1], (number, err)
            assert Path(output).read_bytes() == old or hash_of(output) == expected, number
        code, _, err = shell(*command)
        assert code == 0, (number, err)
        assert hash_of(output) == expected, number
        assert f"{output}.run" not in entries(), number
    assert number > 1 or (beginning, call[1]) == ("grown", "ftruncate")
