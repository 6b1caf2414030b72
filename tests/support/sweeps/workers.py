"""What the tests of executors share: the command in a process of its own, and what workers do."""

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

import sweeps
from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.orbit import compute_orbits
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
POINTS, POISON = 24, 250.0  # degrees
FREE = 8  # blocks that need not wait at the gate
ROOT = Path(sweeps.__file__).parents[1]
HERE = os.pathsep.join([str(ROOT / "tests"), str(ROOT)])

needs_dask = pytest.mark.skipif(find_spec("distributed") is None, reason="dask is not installed")


def hash_without_backend(config: Config) -> str:
    """The content hash of the points computed at once."""
    grid = Grid.from_config(config)
    rows, _ = compute_orbits(grid.rows(np.arange(grid.size)), options_of(config))
    return content_hash(result_dataset(config, grid, rows))


def move_to(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in this folder, with a config; workers find this module and leave their traces there."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("TRACE", str(folder / "trace"))
    monkeypatch.setenv("PYTHONPATH", HERE)
    (folder / "a.yaml").write_text(YAML)


# --- what workers do in place of `compute_block`; they find it in this module ---


def gated_block(task: Task) -> Block:
    """Leave a trace; but for the first `FREE` blocks, wait for `open_gate`."""
    path = Path(os.environ["TRACE"])
    with path.open("ab") as trace:
        trace.write(b".")
        number = trace.tell()
    latest = time.monotonic() + HANGS
    while number > FREE and not path.with_name("gate").exists() and time.monotonic() < latest:
        time.sleep(0.02)
    return compute_block(task)


def open_gate() -> None:
    """Let all blocks come to their end."""
    Path("gate").touch()


def stuck_block(task: Task) -> Block:
    """Never come back."""
    Path(os.environ["TRACE"]).write_bytes(b"." * FREE)
    time.sleep(10 * HANGS)
    return compute_block(task)


def poisoned_block(task: Task) -> Block:
    """Kill the worker."""
    if POISON in task.points[:, 0]:
        os.kill(os.getpid(), signal.SIGKILL)
    return compute_block(task)


# --- the command, and a cluster that is started by hand ---


_MODULES = (
    "from support.sweeps import workers; from sweeps.engine.executors import dask, processes; "
    "from stickslip.dispatch import workers as base"
)


def command(*arguments: str, hook: str = "") -> Running:
    """`stickslip sweep a.yaml` in a session of its own, after the statements of the hook."""
    code = f"{_MODULES}\n{hook}\nfrom sweeps.cli import main; main()"
    sweep = ["sweep", "a.yaml", "-o", "a.nc", "--no-progress"]
    return Running("-c", code, *sweep, *arguments, session=True)


def doing(function: str) -> str:
    """A hook: workers call this function of this module."""
    return f"processes.compute_block = dask.compute_on_cluster = workers.{function}"


IMPATIENT = "dask.ANSWER_SECONDS = base.SILENCE_SECONDS = 1.0"


def ended(process: Running) -> tuple[int, str]:
    """The exit code and what was said on the standard error."""
    code, _, err = process.ended()
    assert "Traceback" not in err
    return code, err


def hash_of_result() -> str:
    return content_hash(open_result(Path("a.nc")))


def wait_for_blocks(count: int) -> None:
    """Wait until workers have begun so many blocks, at most `FREE`."""
    trace = Path("trace")
    wait_until(lambda: trace.exists() and trace.stat().st_size >= count)


def number_of_tasks(dask_scheduler: Any) -> int:
    """What a scheduler knows of; called there."""
    return len(dask_scheduler.tasks)


_LOCAL = ["--host", "127.0.0.1", "--no-dashboard"]


class Cluster:
    """A dask scheduler and workers, each a process without a nanny that would start it anew."""

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
