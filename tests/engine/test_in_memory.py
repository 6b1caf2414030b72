"""A sweep as a function: the same content however and wherever it is computed."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import joblib
import numpy as np
import pytest
import xarray as xr
from support.sweeps.processes import Running
from support.sweeps.workers import HERE, needs_dask, poisoned_block, require_poison_alone
from support.sweeps.writing import write_dataset

from stickslip import Parameters, stationary_orbit
from stickslip.dispatch import backend, thread_pool
from stickslip.dispatch.task import Block
from stickslip.dispatch.workers import Tasks
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.schema import Execution
from sweeps.engine import computing, executors
from sweeps.engine.run import run
from sweeps.engine.signals import Stop
from sweeps.files.netcdf import content_hash, open_result

CONFIG: dict[str, Any] = {
    "sweep": {"T": [200, 250, 300], "gamma": [-2 / 3, 0, 2 / 3]},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
}


def executed(**execution: Any) -> dict[str, Any]:
    return CONFIG | {"execution": execution}


@pytest.fixture(scope="module")
def reference() -> xr.Dataset:
    return run(CONFIG, workers=1)


@pytest.mark.parametrize("workers", [1, 2, 8])
@pytest.mark.parametrize("block_points", [1, 3, None])
def test_the_content_is_the_same_however_it_is_executed(
    reference: xr.Dataset, tmp_path: Path, workers: int, block_points: int | None
) -> None:
    execution = {} if block_points is None else {"block_points": block_points}
    ds = run(executed(workers=workers, **execution))
    assert content_hash(ds) == content_hash(reference)
    write_dataset(ds, tmp_path / "a.nc")
    assert content_hash(open_result(tmp_path / "a.nc")) == content_hash(reference)


def test_a_point_is_the_stationary_orbit_of_its_parameters(reference: xr.Dataset) -> None:
    for temperature in (200.0, 300.0):
        p = Parameters(temperature=temperature, rheological_index=0.0)
        orbit = stationary_orbit(p, rtol=1e-4)
        point = reference.sel(temperature=temperature, rheological_index=0.0)
        for name in RESULT_COLUMNS:
            np.testing.assert_equal(point[name].item(), getattr(orbit, name), err_msg=name)


@pytest.mark.parametrize("first", ["", "import sweeps.engine.run; "])
def test_the_documented_import_is_a_function(first: str) -> None:
    code = f"{first}from sweeps import run; assert callable(run), run"
    subprocess.run([sys.executable, "-c", code], check=True, stderr=subprocess.DEVNULL)


# --- where it is computed ---


class Watched(joblib.Parallel):
    """A joblib.Parallel that records its number of workers and its backend."""

    made: ClassVar[list[tuple[int, str]]] = []

    def __init__(self, n_jobs: int, **settings: Any) -> None:
        super().__init__(n_jobs, **settings)
        self.made.append((n_jobs, type(self._backend).__name__))


class ChosenError(Exception):
    """The executor of the config was asked for."""


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Records of each joblib.Parallel, and of the execution for which an executor was requested."""

    def refused(execution: Execution) -> None:
        Watched.made.append(execution)
        raise ChosenError

    Watched.made.clear()
    monkeypatch.setattr(joblib, "Parallel", Watched)
    monkeypatch.setattr(executors, "make_executor", refused)
    return Watched.made


@pytest.mark.parametrize("backend", ["threads", "loky"])
def test_parallel_config_wins_over_the_config(watched: list[Any], backend: str) -> None:
    with joblib.parallel_config("sequential", n_jobs=5):
        run(executed(workers=3, backend=backend))
    assert watched == [(5, "SequentialBackend")]


def test_workers_win_over_all(watched: list[Any]) -> None:
    with joblib.parallel_config("threading", n_jobs=5):
        run(executed(workers=3), workers=4)
    assert watched == [(4, "ThreadingBackend")]


@pytest.mark.parametrize("backend", ["threads", "loky", "dask"])
@pytest.mark.parametrize(("jobs", "workers"), [(None, 3), (5, 5), (-1, joblib.cpu_count())])
def test_without_a_joblib_backend_the_config_decides(
    watched: list[Any], backend: str, jobs: int | None, workers: int
) -> None:
    number = {} if jobs is None else {"n_jobs": jobs}
    where = {"scheduler": "tcp://localhost:8786"} if backend == "dask" else {}
    with joblib.parallel_config(**number), pytest.raises(ChosenError):
        run(executed(workers=3, backend=backend, **where))
    assert [(made.backend, made.workers) for made in watched] == [(backend, workers)]


@pytest.mark.slow
def test_the_content_is_the_same_on_the_processes_of_joblib(reference: xr.Dataset) -> None:
    with joblib.parallel_config("loky", n_jobs=2):
        assert content_hash(run(executed(block_points=2))) == content_hash(reference)


@needs_dask
@pytest.mark.stress
def test_the_content_is_the_same_on_a_cluster_of_the_person(
    reference: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    from distributed import Client

    with (
        Client(n_workers=2, threads_per_worker=1, dashboard_address=":0") as client,
        joblib.parallel_config("dask"),
    ):
        assert content_hash(run(executed(block_points=2))) == content_hash(reference)
        assert len(client.ncores()) == 2


@pytest.mark.faults
def test_a_point_that_kills_a_process_of_joblib_costs_itself_alone(
    reference: xr.Dataset,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setenv("PYTHONPATH", HERE)
    monkeypatch.setattr(backend, "compute_block", poisoned_block)
    with joblib.parallel_config("loky", n_jobs=2):
        ds = run(executed(block_points=2))
    require_poison_alone(ds, reference, caplog)
    assert len([r for r in caplog.records if "250.0" in r.message]) == 3


def test_late_points_are_computed_on_a_backend_of_joblib_too() -> None:
    odd = {
        "model": {"k": 22802, "K": 2349.9, "T": 205.9},
        "sweep": {"omega": {"linspace": [34, 37], "num": 7}},
        "integrator": {"rtol": 1e-4},
        "stationary": {"rtol": 1e-4, "window": 40},
    }
    expected = content_hash(run(odd))
    with joblib.parallel_config("threading", n_jobs=2):
        assert content_hash(run(odd | {"execution": {"block_points": 1}})) == expected


class Careless(thread_pool.ThreadExecutor):
    """Loses the first block."""

    def blocks(self, tasks: Tasks, stop: Stop) -> Iterator[Block]:
        found = super().blocks(tasks, stop)
        next(found, None)
        yield from found


def test_lost_blocks_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executors, "make_executor", lambda execution: Careless(execution.workers))
    with pytest.raises(RuntimeError, match="only 7 of 9 points"):
        run(executed(workers=1, block_points=2))


def test_the_kernels_are_compiled_before_the_workers_begin(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    order: list[str] = []

    def watched(module: Any, name: str) -> None:
        function = getattr(module, name)
        call = lambda *arguments: (order.append(name), function(*arguments))[1]  # noqa: E731
        monkeypatch.setattr(module, name, call)

    watched(computing, "compile_kernels")
    watched(thread_pool, "compute_block")
    run(executed(workers=2, block_points=5))
    assert order == ["compile_kernels", "compute_block", "compute_block"]


@pytest.mark.slow
def test_ctrl_c_does_not_wait_for_blocks_in_flight() -> None:
    code = (
        "import time\n"
        "from sweeps import run\n"
        "from stickslip.dispatch import thread_pool\n"
        "def stuck(task):\n"
        "    print('ready', flush=True)\n"
        "    time.sleep(1000)\n"
        "thread_pool.compute_block = stuck\n"
        "run({})\n"
    )
    child = Running("-c", code)
    child.says("ready\n")
    child.signal(signal.SIGINT)
    ended, _, err = child.ended()
    assert ended == -signal.SIGINT
    assert err.endswith("KeyboardInterrupt\n")


# --- blocks ---


def test_each_block_is_passed_to_the_caller() -> None:
    seen: list[list[int]] = []
    run(executed(workers=2, block_points=4), on_block=lambda b: seen.append(b.indices.tolist()))
    assert sorted(map(len, seen)) == [1, 4, 4]
    assert sorted(point for block in seen for point in block) == list(range(9))
