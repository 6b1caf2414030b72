"""Points that take far longer than most are left out of blocks and computed together later."""

from __future__ import annotations

import json
import os
import re
import signal
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.marks import one_then
from support.sweeps.processes import HANGS, default_signals
from support.sweeps.sweeping import Shell, hash_at_once, hash_of

from stickslip import Status
from stickslip.dispatch import task as worker
from stickslip.dispatch.stragglers import Stragglers
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS
from sweeps import run
from sweeps.config.load import from_mapping
from sweeps.files.netcdf import content_hash, open_result
from sweeps.files.result_rows import STATUS
from sweeps.grid import Grid

# Some of these points wander for hundreds of periods, and two never close.
ODD = {
    "model": {"k": 22802, "K": 2349.9, "T": 205.9},
    "sweep": {"omega": {"linspace": [34, 37], "num": 7}},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4, "window": 40},
}

A_YAML = json.dumps(ODD | {"output": "a.nc"})  # JSON is YAML, too


def rows_with(*statuses: Status) -> np.ndarray:
    rows = np.zeros((len(statuses), len(RESULT_COLUMNS)))
    rows[:, STATUS] = statuses
    return rows


def test_pending_points_are_left_out_and_come_later() -> None:
    stragglers = Stragglers(most=2)
    rows = rows_with(Status.OK, Status.PENDING, Status.DIVERGED)
    np.testing.assert_array_equal(
        stragglers.finished(np.array([7, 3, 9]), rows), [True, False, True]
    )
    assert stragglers.together() is None
    stragglers.finished(np.array([8, 1]), rows_with(Status.PENDING, Status.PENDING))
    np.testing.assert_array_equal(stragglers.together(), [3, 8])
    assert [part.tolist() for part in stragglers.rest(4)] == [[1]]
    assert stragglers.rest(4) == []


@pytest.mark.parametrize(("seconds_per_point", "together"), [(1.0, 256), (0.02, 500), (1e-3, 1024)])
def test_a_group_takes_ten_seconds(seconds_per_point: float, together: int) -> None:
    stragglers = Stragglers()
    waiting = np.arange(2000)
    stragglers.finished(waiting, rows_with(*[Status.PENDING] * len(waiting)))
    assert stragglers.together() is not None
    stragglers.learn(256, 256 * seconds_per_point)
    group = stragglers.together()
    assert group is not None
    assert len(group) == together


@pytest.mark.parametrize(
    ("waiting", "slots", "sizes"),
    [(11, 5, [11]), (94, 2, [94]), (130, 2, [65, 65]), (300, 5, [75, 75, 75, 75]), (3000, 1, 3)],
)
def test_the_rest_is_shared_out_so_that_lanes_stay_busy(
    waiting: int, slots: int, sizes: list[int] | int
) -> None:
    stragglers = Stragglers()
    stragglers.finished(np.arange(waiting), rows_with(*[Status.PENDING] * waiting))
    parts = stragglers.rest(slots)
    assert sorted(np.concatenate(parts)) == list(range(waiting))
    assert sizes in ([len(part) for part in parts], len(parts))


def test_if_many_points_are_late_none_is_left_out() -> None:
    stragglers = Stragglers()
    assert stragglers.patience > 0
    stragglers.finished(np.arange(100), rows_with(*[Status.PENDING] * 100))
    assert stragglers.patience == 0
    assert Stragglers(ever=False).patience == 0


def test_patience_does_not_change_the_results_of_other_points() -> None:
    grid = Grid.from_config(from_mapping(ODD))
    points, options = grid.rows(np.arange(grid.size)), Options(rtol=1e-4, stationary_rtol=1e-4)
    whole, finals = compute_orbits(points, options)
    some, their_finals = compute_orbits(points, options, patience=64)
    late = some[:, STATUS] == Status.PENDING
    assert 0 < late.sum() < len(late)
    assert some[~late].tobytes() == whole[~late].tobytes()
    assert their_finals[~late].tobytes() == finals[~late].tobytes()


@pytest.mark.parametrize("max_error", [1e-3, 1e-6])
def test_a_limit_does_not_change_the_results_of_other_points(max_error: float) -> None:
    """This includes points that need finer tolerances."""
    grid = Grid.from_config(from_mapping(ODD))
    points = grid.rows(np.arange(grid.size))
    options = Options(rtol=1e-4, stationary_rtol=1e-4, max_error=max_error)
    whole, _ = compute_orbits(points, options)
    some, _ = compute_orbits(points, options, limit=64)
    kept = np.isin(some[:, STATUS], [status for status in Status if status.is_result])
    assert 0 < kept.sum() < len(points)
    assert some[kept].tobytes() == whole[kept].tobytes()
    assert set(some[~kept, STATUS]) <= {Status.PENDING, Status.INACCURATE}


@pytest.mark.parametrize(
    "execution", one_then("stress", [{"block_points": 1}, {"workers": 2}, {"backend": "loky"}])
)
def test_a_sweep_computes_late_points_together(
    execution: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = run(ODD | {"execution": {"workers": 1}})
    patiences: list[int] = []

    def watched(points: np.ndarray, options: Options, **limits: int) -> Any:
        patiences.append(limits["patience"])
        return compute_orbits(points, options, **limits)

    monkeypatch.setattr(worker, "compute_orbits", watched)
    ds = run(ODD | {"execution": execution})
    assert content_hash(ds) == content_hash(whole)
    assert not (ds.status == Status.PENDING).any()
    assert (ds.status == Status.APERIODIC).any()
    if execution.get("backend") != "loky":  # its workers are not watched
        assert 0 in patiences
        assert max(patiences) > 0


def test_a_stop_does_not_wait_for_late_points_and_the_next_run_computes_them(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    hanging = threading.Event()

    def watched(points: np.ndarray, options: Options, **limits: int) -> Any:
        if not limits["patience"] and not hanging.is_set():
            os.kill(os.getpid(), signal.SIGTERM)
            hanging.wait(HANGS)
        return compute_orbits(points, options, **limits)

    with monkeypatch.context() as patch, default_signals():
        patch.setattr(worker, "compute_orbits", watched)
        code, _, err = shell("sweep", "a.yaml")
        hanging.set()
    assert code == 4
    late = re.search(r"SIGTERM: leaving (\d) points?, which may take minutes, for the next", err)
    assert late is not None
    assert f"Stopped: SIGTERM. {7 - int(late[1])} of 7 points are kept in a.nc.run" in err
    code, out, err = shell("sweep", "a.yaml")
    assert code == 0
    assert f"7 points: {7 - int(late[1])} in its journal; {late[1]} to compute\n" in err
    assert hash_of("a.nc") == hash_at_once("a.yaml")
    ds = open_result(Path("a.nc"))
    wanders = ds.status == Status.APERIODIC
    mean, orbit = (float(ds.amplitude_error.where(some).max()) for some in (wanders, ~wanders))
    aperiodic = f"{int(wanders.sum())} aperiodic with a statistical error of up to {mean:.1e}"
    assert f", 0 failed, {aperiodic}, largest amplitude error of the others {orbit:.1e}\n" in out
