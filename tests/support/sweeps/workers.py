"""Helpers for tests of executors: commands in other processes, and functions for workers."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import sweeps
from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.orbit import compute_orbits
from stickslip.status import Status
from support.sweeps.processes import HANGS, Running, default_signals, wait_until
from sweeps.config.load import Config
from sweeps.engine.settings import options_of
from sweeps.files.attributes import result_dataset
from sweeps.files.netcdf import content_hash, open_result
from sweeps.grid import Grid

YAML = """\
sweep:
  temperature: [180, 200, 220, 240, 250, 260, 280, 300]
  rheological_index: [-2/3, 0, 2/3]
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
execution: {block_points: 1}
"""
POINTS, POISON = 24, 250.0  # the number of points, and the temperature [K] that kills
FREE = 8  # blocks that do not wait at the gate
ROOT = Path(sweeps.__file__).parents[1]
HERE = os.pathsep.join([str(ROOT / "tests"), str(ROOT)])

needs_dask = pytest.mark.skipif(find_spec("distributed") is None, reason="dask is not installed")


def hash_without_backend(config: Config) -> str:
    """The content hash of a config's points, computed together without workers."""
    grid = Grid.from_config(config)
    rows, _ = compute_orbits(grid.rows(np.arange(grid.size)), options_of(config))
    return content_hash(result_dataset(config, grid, rows))


def move_to(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder with a config; workers find this module, and leave their trace there."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("TRACE", str(folder / "trace"))
    monkeypatch.setenv("PYTHONPATH", HERE)
    (folder / "a.yaml").write_text(YAML)


# --- functions that workers call in place of `compute_block`; they import them from here ---


def gated_block(task: Task) -> Block:
    """Leave a trace; after the first `FREE` blocks, wait for `open_gate`."""
    path = Path(os.environ["TRACE"])
    with path.open("ab") as trace:
        trace.write(b".")
        number = trace.tell()
    latest = time.monotonic() + HANGS
    while number > FREE and not path.with_name("gate").exists() and time.monotonic() < latest:
        time.sleep(0.02)
    return compute_block(task)


def open_gate() -> None:
    """Let all blocks finish."""
    Path("gate").touch()


def stuck_block(task: Task) -> Block:
    """Never return."""
    Path(os.environ["TRACE"]).write_bytes(b"." * FREE)
    time.sleep(10 * HANGS)
    return compute_block(task)


def poisoned_block(task: Task) -> Block:
    """Kill the worker at a poisoned point."""
    if POISON in task.points[:, 0]:
        os.kill(os.getpid(), signal.SIGKILL)
    return compute_block(task)


def require_poison_alone(
    found: xr.Dataset, sound: xr.Dataset, caplog: pytest.LogCaptureFixture
) -> None:
    """Fail unless only the points that kill their workers have failed, and the log names them."""
    poison = found.temperature == POISON
    assert (found.status.where(poison, drop=True) == Status.FAILED).all()
    assert found.where(~poison, drop=True).equals(sound.where(~poison, drop=True))
    assert [r.message for r in caplog.records if "failed" in r.message and "250.0" in r.message]


# --- the command, and a cluster that a test starts ---


_MODULES = (
    "from support.sweeps import workers; from sweeps.engine.executors import dask, processes; "
    "from stickslip.dispatch import workers as base"
)


def command(*arguments: str, hook: str = "") -> Running:
    """Start `stickslip sweep a.yaml` in a new session, after the statements of the hook."""
    code = f"{_MODULES}\n{hook}\nfrom sweeps.cli import main; main()"
    sweep = ["sweep", "a.yaml", "-o", "a.nc", "--no-progress"]
    return Running("-c", code, *sweep, *arguments, session=True)


def doing(function: str) -> str:
    """A hook that makes workers call this function of this module."""
    return f"processes.compute_block = dask.compute_on_cluster = workers.{function}"


IMPATIENT = "dask.ANSWER_SECONDS = base.SILENCE_SECONDS = 1.0"


def ended(process: Running) -> tuple[int, str]:
    """Wait for the end; return the exit code and the standard error."""
    code, _, err = process.ended()
    assert "Traceback" not in err
    return code, err


def hash_of_result() -> str:
    return content_hash(open_result(Path("a.nc")))


def wait_for_blocks(count: int) -> None:
    """Wait until workers have begun `count` blocks, at most `FREE`."""
    trace = Path("trace")
    wait_until(lambda: trace.exists() and trace.stat().st_size >= count)


def number_of_tasks(dask_scheduler: Any) -> int:
    """The number of tasks that a scheduler knows; called in the scheduler."""
    return len(dask_scheduler.tasks)


_LOCAL = ["--host", "127.0.0.1", "--no-dashboard"]


class Cluster:
    """A dask scheduler and workers, each a process without a nanny that would restart it."""

    def __init__(self, folder: Path) -> None:
        self._file, self._log = folder / "scheduler.json", (folder / "log").open("w")
        self.processes: list[subprocess.Popen[bytes]] = []
        self._start("scheduler", "--port", "0", "--scheduler-file", str(self._file))
        wait_until(lambda: self._file.exists() and self._file.read_text().endswith("}"))
        self.address = json.loads(self._file.read_text())["address"]

    def worker(self, path: str = HERE) -> subprocess.Popen[bytes]:
        return self._start("worker", self.address, "--nthreads", "1", "--no-nanny", path=path)

    def _start(self, kind: str, *arguments: str, path: str = HERE) -> subprocess.Popen[bytes]:
        with default_signals():
            process = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments, *_LOCAL],
                env=os.environ | {"PYTHONPATH": path},
                stdout=self._log,
                stderr=self._log,
            )
        self.processes.append(process)
        return process

    def close(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait(HANGS)
        self._log.close()
