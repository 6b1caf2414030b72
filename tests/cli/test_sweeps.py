"""`stickslip sweep`: its files and its messages."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.sweeps.commands import FOUR_POINTS, Command, entries

from sweeps.engine.run import run
from sweeps.files.netcdf import content_hash, open_result


def test_sweep_names_its_result_after_the_config(command: Command) -> None:
    code, out, err = command("sweep", "a.yaml")
    assert code == 0
    path, summary = out.splitlines()
    assert path == "results/a.nc"
    assert summary.startswith("4 points in ")
    assert "points/s), 0 failed, largest amplitude error " in summary
    assert err == "4 points (2 x 2); 4 to compute\n"
    assert entries("results") == ["a.nc", "a.nc.timing.json"]
    ds = open_result(Path(path))
    assert f"{float(ds.amplitude_error.max()):.1e}" in summary
    assert content_hash(ds) == content_hash(run("a.yaml"))
    assert ds.attrs["history"].endswith(" stickslip sweep a.yaml")


def test_workers_and_blocks_leave_the_hash_and_are_noted_in_the_timing(command: Command) -> None:
    command("sweep", "a.yaml", "--workers", "3", "--set", "execution.block_points=1")
    expected = content_hash(run("a.yaml", workers=1))
    assert command("info", "--hash", "results/a.nc") == (0, f"{expected}\n", "")
    timing = json.loads(Path("results/a.nc.timing.json").read_text())
    assert timing["points"] == 4
    assert timing["workers"] == 3
    assert timing["points_per_second"] == pytest.approx(4 / timing["seconds"], rel=0.5)
    assert timing["code_sha256"] == open_result(Path("results/a.nc")).attrs["code_sha256"]


def test_sweep_takes_its_output_from_option_or_config(command: Command) -> None:
    Path("b.yaml").write_text(FOUR_POINTS + "output: deep/er/b.nc\n")
    assert command("sweep", "b.yaml").out.startswith("deep/er/b.nc\n")
    assert command("sweep", "b.yaml", "-o", "c.nc").out.startswith("c.nc\n")
    assert command("sweep", "b.yaml", "--set", "output=d.nc").out.startswith("d.nc\n")
    hashes = {content_hash(open_result(Path(p))) for p in ("deep/er/b.nc", "c.nc", "d.nc")}
    assert len(hashes) == 1


def test_set_changes_the_config(command: Command) -> None:
    code, out, _ = command("sweep", "a.yaml", "--set", "T=[210]", "--set", "gamma=2/3")
    assert code == 0
    assert "1 point in" in out
    ds = open_result(Path("results/a.nc"))
    assert ds.sizes == {"temperature": 1}
    assert (ds.temperature[0], ds.rheological_index) == (210.0, 2 / 3)


def test_no_progress_prints_nothing_during_the_sweep(command: Command) -> None:
    assert command("sweep", "a.yaml", "--no-progress").err == ""


def test_points_that_fail_are_counted_and_explained(command: Command) -> None:
    code, out, err = command("sweep", "a.yaml", "--set", "stationary.max_periods=2")
    assert code == 3
    assert "points/s), 4 failed\n" in out
    assert "  4 not_stationary: The motion was still on its way to an orbit after" in err
    assert np.all(open_result(Path("results/a.nc")).status == 1)


def test_a_step_unstable_for_some_points_refuses_those(command: Command) -> None:
    Path("e.yaml").write_text(
        "sweep: {omega: [3e5, 3e6]}\nmodel: {X_m: 1e-9}\nstationary: {max_periods: 2}\n"
        "integrator: {method: euler-cromer, dt: 1e-10}\n"
    )
    code, out, err = command("sweep", "e.yaml")
    assert code == 3
    assert "2 failed" in out
    assert "  1 not_stationary: " in err
    assert "  1 refused: The fixed step is unstable" in err
    assert open_result(Path("results/e.nc")).status.values.tolist() == [1, 4]


def test_warnings_of_a_config_are_printed(command: Command) -> None:
    code, _, err = command("check", "a.yaml", "--set", "k=3000", "--set", "K=5e4")
    assert code == 0
    assert err.startswith("warning: ")
