"""Threads, processes, clusters: the same content, and no process or message left over."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
from support.marks import one_then
from support.sweeps.processes import HANGS, Running
from support.sweeps.workers import (
    FREE,
    POINTS,
    command,
    doing,
    ended,
    hash_of_result,
    hash_without_backend,
    move_to,
    open_gate,
    poisoned_block,
    require_poison_alone,
    wait_for_blocks,
)

from stickslip.compiled.cache import source_hash
from stickslip.dispatch.ask import ask
from stickslip.dispatch.blocks import Blocks
from stickslip.dispatch.errors import ExecutorError, WorkersLostError
from stickslip.dispatch.task import Task
from stickslip.dispatch.workers import Executor
from sweeps.config.schema import Execution
from sweeps.engine.executors import dask, make_executor, processes
from sweeps.engine.run import run
from sweeps.engine.settings import options_of, read_config
from sweeps.engine.signals import Stop
from sweeps.executor_table import EXECUTORS
from sweeps.grid import Grid

CLUSTER = "tcp://127.0.0.1:8786"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    move_to(tmp_path, monkeypatch)
    return tmp_path


@pytest.fixture
def expected() -> str:
    return hash_without_backend(read_config("a.yaml"))


# --- the same content ---


@pytest.mark.slow
def test_processes_give_the_same_content_and_say_nothing_else(expected: str) -> None:
    assert ended(command("--backend", "loky", "--workers", "2")) == (0, "")
    assert hash_of_result() == expected


@pytest.mark.slow
@pytest.mark.parametrize("how", one_then("faults", ["command", "joblib"]))
def test_processes_import_nothing_from_the_current_folder(how: str, folder: Path) -> None:
    for name in ("numpy", "joblib", "multiprocessing", "queue"):
        (folder / f"{name}.py").write_text(f"open('ran-{name}', 'w')\n")
    (folder / "elsewhere").mkdir()
    script = folder / "elsewhere" / "script.py"
    script.write_text(BY_JOBLIB)
    stickslip = Path(sys.executable).with_name("stickslip")
    words = [stickslip, "sweep", "a.yaml", "-o", "a.nc", "--backend", "loky", "--set", "gamma=0"]
    done = subprocess.run(words if how == "command" else [sys.executable, script], timeout=HANGS)
    assert done.returncode == 0
    assert not list(folder.glob("ran-*"))


BY_JOBLIB = """\
import os
import joblib
import sweeps

if __name__ == "__main__":
    with joblib.parallel_config("loky", n_jobs=2):
        assert not sweeps.run({"sweep": {"T": [200, 300]}}).status.any()
    assert "PYTHONSAFEPATH" not in os.environ
"""


@pytest.mark.parametrize("name", EXECUTORS)
def test_every_executor_of_the_table_is_there(name: str) -> None:
    scheduler = CLUSTER if name == "dask" else None
    assert isinstance(make_executor(Execution(backend=name, scheduler=scheduler)), Executor)


@pytest.mark.parametrize("missing", ["dask", "distributed"])
def test_a_missing_dask_is_reported_with_a_remedy(
    missing: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    with (
        pytest.raises(ExecutorError, match=r"try: pip install 'dask>=2024\.7'"),
        make_executor(Execution(backend="dask", scheduler=CLUSTER)),
    ):
        pass


@pytest.mark.faults
def test_a_point_that_kills_its_worker_costs_itself_alone(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    changes = ["gamma=0", "execution.block_points=2"]
    sound = run(read_config("a.yaml", changes)).squeeze()
    monkeypatch.setattr(processes, "compute_block", poisoned_block)
    found = run(read_config("a.yaml", [*changes, "execution.backend=loky"])).squeeze()
    require_poison_alone(found, sound, caplog)


# --- the end of the command ---


def begun(hook: str) -> tuple[Running, list[Any]]:
    """A sweep with workers at work, and its processes."""
    sweep = command("--backend", "loky", "--workers", "2", hook=hook)
    wait_for_blocks(FREE)
    return sweep, psutil.Process(sweep.pid).children(recursive=True)


def all_gone(processes: list[Any]) -> bool:
    assert len(processes) >= 2
    return not psutil.wait_procs(processes, timeout=HANGS)[1]


@pytest.mark.faults
def test_ctrl_c_keeps_finished_points_and_leaves_no_process() -> None:
    sweep, processes = begun(doing("gated_block"))
    os.killpg(sweep.pid, signal.SIGINT)  # as a terminal does
    sweep.says("drops the points in flight")
    open_gate()
    code, err = ended(sweep)
    assert code == 130
    assert all_gone(processes)
    said = re.fullmatch(
        r"\nCtrl-C: finishing \d points? in flight.*\.\n"
        r"Another Ctrl-C ends the run at once and drops the points in flight\.\n"
        r"Stopped: Ctrl-C\. (\d+) of 24 points are kept in a\.nc\.run\. To resume:\n.*\n",
        err,
    )
    assert said
    assert FREE <= int(said[1]) <= FREE + 2 * 2 < POINTS  # those in flight too


@pytest.mark.faults
def test_a_second_ctrl_c_waits_for_nobody() -> None:
    sweep, processes = begun(doing("stuck_block"))
    os.killpg(sweep.pid, signal.SIGINT)
    sweep.says("drops the points in flight")
    os.killpg(sweep.pid, signal.SIGINT)
    code, err = ended(sweep)
    assert code == 130
    assert "Ended at once; points in the journal are kept." in err
    assert all_gone(processes)


@pytest.mark.faults
def test_processes_do_not_outlive_the_command() -> None:
    sweep, processes = begun(doing("stuck_block"))
    sweep.process.kill()
    assert all_gone(processes)


# --- the pool alone ---


@pytest.fixture
def tasks() -> list[Task]:
    config = read_config("a.yaml")
    grid = Grid.from_config(config)
    options, code = options_of(config), source_hash()
    return [Task(np.array([i]), grid.points(i, i + 1), options, code) for i in range(6)]


class Scripted(Executor):
    """An executor in which tasks end as the test wants, one after another."""

    def __init__(self, slots: int, ends: list[Any]) -> None:
        super().__init__(slots)
        self._ends, self.taken = ends, 0

    def __exit__(self, *_: object) -> None: ...

    def submit(self, _: Task) -> Future[Any]:
        future: Future[Any] = Future()
        end = self._ends[self.taken]
        future.set_exception(end) if isinstance(end, Exception) else future.set_result(end)
        self.taken += 1
        return future


def test_a_task_is_taken_when_there_is_room_for_it(tasks: list[Task]) -> None:
    pool = Scripted(1, list("abcdef"))
    taken = [(block, pool.taken) for block in pool.blocks(iter(tasks), Stop())]
    assert taken == [("a", 2), ("b", 3), ("c", 4), ("d", 5), ("e", 6), ("f", 6)]


def test_after_a_death_the_others_in_flight_still_come(tasks: list[Task]) -> None:
    death = WorkersLostError("dead", 4)
    pool, found = Scripted(2, [death, "b", death, "d", "e", "f"]), deque[Any]()
    with pytest.raises(WorkersLostError) as caught:
        found.extend(pool.blocks(iter(tasks), Stop()))
    assert list(found) == ["b", "d"]
    assert pool.taken == 4  # nothing was begun after the first death
    assert caught.value.deaths == 4


def test_workers_that_cannot_begin_cost_no_point(tasks: list[Task]) -> None:
    config = read_config("a.yaml")
    grid, options = Grid.from_config(config), options_of(config)
    done = np.arange(grid.size) >= len(tasks)
    pool = Scripted(1, [WorkersLostError("no module named queue")] * 9)
    with pytest.raises(ExecutorError, match=r"die before computing anything \(no module named que"):
        list(ask(grid.rows, Blocks(done, pool.slots), options, pool))


def test_one_process_of_a_machine_compiles_at_a_time(
    tasks: list[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    inside, most = 0, 0

    def prepare(options: object, gammas: np.ndarray) -> None:
        nonlocal inside, most
        inside += 1
        most = max(most, inside)
        time.sleep(0.1)
        inside -= 1

    monkeypatch.setattr(dask, "prepare_kernels", prepare)
    monkeypatch.setattr(dask, "compute_block", lambda _: None)
    threads = [threading.Thread(target=dask.compute_on_cluster, args=(task,)) for task in tasks]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == 1
