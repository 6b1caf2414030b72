"""Sweeps on an existing dask cluster whose workers and scheduler join, die or do not fit."""

from __future__ import annotations

import logging
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pytest
from support import messages
from support.marks import marked, one_then
from support.sweeps.processes import wait_until
from support.sweeps.workers import (
    FREE,
    IMPATIENT,
    POINTS,
    ROOT,
    Cluster,
    command,
    doing,
    ended,
    hash_of_result,
    hash_without_backend,
    move_to,
    needs_dask,
    number_of_tasks,
    open_gate,
    poisoned_block,
    require_poison_alone,
    wait_for_blocks,
)

from stickslip import stationary_orbits
from stickslip.dispatch.errors import ExecutorError, WorkersLostError
from stickslip.dispatch.task import Task
from sweeps import fit
from sweeps.engine.executors import dask as dask_executor
from sweeps.engine.executors.dask import ClusterExecutor
from sweeps.engine.resume import state_of
from sweeps.engine.run import run
from sweeps.engine.settings import read_config
from sweeps.files.netcdf import content_hash

pytestmark = needs_dask


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    move_to(tmp_path, monkeypatch)
    return tmp_path


@pytest.fixture
def expected() -> str:
    return hash_without_backend(read_config("a.yaml"))


@pytest.fixture
def cluster(folder: Path) -> Iterator[Cluster]:
    made = Cluster(folder)
    yield made
    made.close()


@pytest.mark.slow
def test_a_cluster_gives_the_same_content_and_is_left_empty(
    cluster: Cluster, expected: str
) -> None:
    from distributed import Client

    cluster.worker(), cluster.worker()
    assert ended(command("--scheduler", cluster.address)) == (0, "")
    assert hash_of_result() == expected
    with Client(cluster.address, set_as_default=False) as client:
        tasks: Callable[[], int] = partial(client.run_on_scheduler, number_of_tasks)
        most = []
        there = f"execution={{backend: dask, scheduler: '{cluster.address}', block_points: 1}}"
        config = read_config("a.yaml", [there])
        ds = run(config, on_block=lambda _: most.append(tasks()))
        assert content_hash(ds) == expected
        assert max(most) <= 2 * 2 + 2  # in flight, and just being released
        wait_until(lambda: tasks() == 0)


@pytest.mark.stress
def test_a_fit_and_a_table_of_points_are_computed_on_a_cluster(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import Client

    cluster.worker(), cluster.worker()
    data = {"T": [200.0, 250.0, 300.0], "F_max": [3e-3, 1.5e-3, 1.2e-3]}
    loose = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
    execution = {"execution": {"backend": "dask", "scheduler": cluster.address}}
    submitted: list[Task] = []
    submit = ClusterExecutor.submit

    def watched(self: ClusterExecutor, task: Task) -> Any:
        submitted.append(task)
        return submit(self, task)

    monkeypatch.setattr(ClusterExecutor, "submit", watched)
    there, here = fit(data, "k", loose | execution), fit(data, "k", loose)
    assert len(submitted) > 10
    assert there.parameter_value.values.tobytes() == here.parameter_value.values.tobytes()
    assert content_hash(there) == content_hash(here)
    points = {"T": np.linspace(150.0, 320.0, 70)}
    with Client(cluster.address), joblib.parallel_config("dask"):
        table = stationary_orbits(points, rtol=1e-4)
    assert table.equals(stationary_orbits(points, rtol=1e-4))


# --- workers and schedulers that die ---


@pytest.mark.faults
def test_a_sweep_survives_the_death_of_a_worker(cluster: Cluster, expected: str) -> None:
    victim, _ = cluster.worker(), cluster.worker()
    sweep = command("--scheduler", cluster.address, hook=doing("gated_block"))
    wait_for_blocks(FREE)
    victim.kill()
    open_gate()
    assert ended(sweep) == (0, "")
    assert hash_of_result() == expected


@pytest.mark.faults
def test_a_point_that_kills_its_worker_costs_itself_alone(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from distributed import LocalCluster

    changes = ["gamma=0", "execution.block_points=2"]
    sound = run(read_config("a.yaml", changes)).squeeze()
    monkeypatch.setattr(dask_executor, "compute_on_cluster", poisoned_block)
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address=None,
        silence_logs=logging.CRITICAL,
        scheduler_kwargs={"allowed_failures": 0},  # a task that kills a worker comes back at once
    ) as cluster:
        there = f"execution={{backend: dask, scheduler: '{cluster.scheduler_address}'}}"
        found = run(read_config("a.yaml", [there, *changes])).squeeze()
    require_poison_alone(found, sound, caplog)


@pytest.mark.faults
def test_a_sweep_without_workers_waits_for_new_ones(cluster: Cluster, expected: str) -> None:
    hook = f"{IMPATIENT}; {doing('gated_block')}"
    sweep = command("--scheduler", cluster.address, hook=hook)
    waiting = f"WARNING: no worker is connected to {cluster.address}; waiting for one\n"
    sweep.says(waiting)  # there were none from the start
    victim = cluster.worker()
    wait_for_blocks(FREE)
    victim.kill()
    sweep.says(waiting, times=2)
    open_gate()
    cluster.worker()
    assert ended(sweep) == (0, 2 * waiting)
    assert hash_of_result() == expected


@pytest.mark.faults
def test_the_granted_time_ends_without_workers_too(cluster: Cluster) -> None:
    sweep = command("--scheduler", cluster.address, "--max-runtime", "2s", hook=IMPATIENT)
    code, err = ended(sweep)
    assert code == 4
    assert f"Stopped: {messages.TIME_OVER}. 0 of 24 points are kept" in err


@pytest.mark.faults
def test_finished_points_survive_the_death_of_the_scheduler(
    cluster: Cluster, expected: str
) -> None:
    cluster.worker(), cluster.worker()
    sweep = command("--scheduler", cluster.address, hook=doing("gated_block"))
    wait_for_blocks(FREE)
    cluster.processes[0].kill()
    code, err = ended(sweep)
    assert code == 4
    assert f"the connection to the dask scheduler at {cluster.address} was lost" in err
    assert err.count("\n") == 1
    assert 0 < state_of(Path("a.nc"))["done"] < POINTS
    assert ended(command())[0] == 0  # on the threads of this machine
    assert hash_of_result() == expected


@pytest.mark.faults
def test_a_scheduler_that_is_frozen_from_the_start_is_not_waited_for(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sweeps.engine.executors.dask.CONNECT_SECONDS", 1.0)
    scheduler = cluster.processes[0]
    scheduler.send_signal(signal.SIGSTOP)  # its system still accepts connections
    try:
        with pytest.raises(ExecutorError, match="no answer in 1 s"):
            ClusterExecutor(cluster.address).__enter__()
    finally:
        scheduler.send_signal(signal.SIGCONT)


@pytest.mark.faults
def test_a_frozen_scheduler_is_not_waited_for_after_a_signal(cluster: Cluster) -> None:
    cluster.worker()
    hook = f"{IMPATIENT}; {doing('gated_block')}"
    sweep = command("--scheduler", cluster.address, hook=hook)
    wait_for_blocks(FREE)
    scheduler = cluster.processes[0]
    scheduler.send_signal(signal.SIGSTOP)
    try:
        os.kill(sweep.pid, signal.SIGTERM)
        code, err = ended(sweep)
    finally:
        scheduler.send_signal(signal.SIGCONT)
    assert code == 4
    assert "Stopped: SIGTERM" in err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("tls://127.0.0.1:1", "needs certificates in dask's configuration"),
        *marked(
            "faults",
            [
                ("inproc://x", "a cluster inside another process"),
                ("wss://127.0.0.1:1", "needs certificates in dask's configuration"),
                ("inproc://192.0.2.1/1/1", "a cluster inside another process"),
            ],
        ),
    ],
)
def test_an_address_that_never_answers_is_a_usage_error(address: str, message: str) -> None:
    """Otherwise a script that repeats failed commands would repeat this one forever."""
    code, err = ended(command("--scheduler", address))
    assert code == 2
    assert err.startswith(address)
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("scheme", one_then("faults", ["tcp", "ws"]))
def test_a_scheduler_that_is_not_there_is_named(scheme: str) -> None:
    address = f"{scheme}://127.0.0.1:1"
    code, err = ended(command("--scheduler", address, hook=IMPATIENT))
    assert code == 4
    assert err.startswith(f"no dask scheduler answers at {address} (")
    assert err.count("\n") == 1
    assert not Path("a.nc").exists()


@pytest.mark.parametrize(
    ("problem", "message"),
    [
        ("other sources", "a worker's stickslip code ("),
        ("none", "cannot compute a block (ModuleNotFoundError: not here)"),
    ],
)
@pytest.mark.faults
def test_a_worker_with_other_sources_or_none_is_reported(
    cluster: Cluster, folder: Path, problem: str, message: str
) -> None:
    path = folder / "packages"
    if problem == "none":
        (path / "sweeps").mkdir(parents=True)
        (path / "sweeps" / "__init__.py").write_text("raise ModuleNotFoundError('not here')")
    else:
        for name in ("stickslip", "sweeps"):
            shutil.copytree(ROOT / name, path / name)
        with (path / "stickslip" / "status.py").open("a") as source:
            source.write("# changed\n")
    cluster.worker(str(path))
    code, err = ended(command("--scheduler", cluster.address))
    assert code == 4
    assert message in err
    assert "install the same version" in err
    assert err.count("\n") == 1


def test_a_killed_task_tells_how_many_workers_it_has_cost() -> None:
    from distributed import KilledWorker

    future: Future[Any] = Future()
    future.set_exception(KilledWorker("task", None, 3))
    with pytest.raises(WorkersLostError) as caught:
        ClusterExecutor("tcp://127.0.0.1:1").result(future)
    assert caught.value.deaths == 4
