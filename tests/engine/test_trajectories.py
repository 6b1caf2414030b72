"""Trajectories of a config: the numbers of `simulate`, with the provenance of a file."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.sweeps.processes import HANGS
from support.sweeps.writing import write_dataset

import stickslip
from stickslip import IntegrationError, Parameters, Status
from sweeps.config.load import from_mapping, from_yaml
from sweeps.config.pull import PulledError
from sweeps.engine.trajectories import AxisLeftError, OtherAxesError, trajectories, trajectory
from sweeps.files.netcdf import open_result

SHORT = {"periods": 1, "samples_per_period": 50}


def config(**parts: Any) -> Any:
    return from_mapping({"simulation": SHORT} | parts)


def same_numbers(found: xr.Dataset, expected: xr.Dataset) -> None:
    xr.testing.assert_identical(found.drop_attrs(deep=False), expected.drop_attrs(deep=False))


@pytest.mark.parametrize(
    ("parts", "keywords"),
    [
        ({"integrator": {"rtol": 1e-4}}, {"rtol": 1e-4}),
        ({"simulation": SHORT | {"start": "stationary"}}, {"start": "stationary"}),
        ({"simulation": SHORT | {"periods": 2}}, {"periods": 2}),
        ({"noise": {"treatment": "none"}, "model": {"phi_0": 0.5}}, {"noise": "none"}),
        (
            {"noise": {"treatment": "stochastic", "realizations": 2, "seed": 7}},
            {"noise": "stochastic", "realizations": 2, "seed": 7},
        ),
        (
            {
                "integrator": {"method": "euler-cromer", "dt": 1e-10},
                "model": {"omega": 3e5, "X_m": 1e-9},
            },
            {"method": "euler-cromer", "dt": 1e-10},
        ),
    ],
)
def test_each_setting_reaches_the_trajectory(
    parts: dict[str, Any], keywords: dict[str, Any]
) -> None:
    settings = config(**parts)
    found = trajectory(settings)
    same_numbers(found, stickslip.simulate(settings.parameters(), **(SHORT | keywords)))
    plain = stickslip.simulate(settings.parameters(), **SHORT)
    assert "noise" in parts or not found.drop_attrs().equals(plain.drop_attrs())


def test_budgets_reach_the_trajectory() -> None:
    with pytest.raises(IntegrationError) as caught:
        trajectory(config(integrator={"max_steps": 10}))
    assert caught.value.status is Status.STEP_LIMIT
    settled = {"simulation": SHORT | {"start": "stationary"}}
    with pytest.raises(IntegrationError, match="No stationary start") as caught:
        trajectory(config(stationary={"max_periods": 2}, **settled))
    assert caught.value.status is Status.NOT_STATIONARY


def test_a_trajectory_has_its_provenance(tmp_path: Path) -> None:
    settings = config(model={"T": 250})
    write_dataset(trajectory(settings), tmp_path / "a.nc")
    ds = open_result(tmp_path / "a.nc")
    assert ds.attrs["title"] == "Trajectory"
    assert "Time courses" in ds.attrs["summary"]
    assert from_yaml(ds.attrs["config"]) == settings
    assert ds.temperature == 250.0
    assert trajectory(config(title="Mine")).attrs["title"] == "Mine"


AXIS = {"sweep": {"T": [200, 250], "gamma": [-0.5, 0]}}
CASES = {"cases": {"X_m": [4e-7, 8e-7], "omega": [20, 10]}}
REFINED = {"sweep": {"T": [200, 225, 250]}, "refine": {"axes": ["T"], "levels": 1}}


@pytest.mark.parametrize(
    ("parts", "points"),
    [(AXIS, 4), (CASES, 2), (AXIS | CASES, 8), (AXIS | {"follow": "T"}, 8), (REFINED, 3)],
    ids=["axes", "cases", "both", "followed", "refined"],
)
def test_an_axis_left_is_refused_with_a_way_out_that_works(
    parts: dict[str, Any], points: int
) -> None:
    with pytest.raises(AxisLeftError, match=f"has {points} points") as caught:
        trajectory(config(**parts))
    _, *choices = str(caught.value).split(" --set ")
    settings = from_mapping({"simulation": SHORT} | parts, overrides=choices)
    assert trajectory(settings).sizes == {"elapsed_time": 51}


@pytest.mark.stress
@pytest.mark.parametrize("method", ["{method: adaptive}", "{method: euler-cromer, dt: 1e-8}"])
def test_all_kernels_are_compiled_in_advance(tmp_path: Path, method: str) -> None:
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "from sweeps.config.load import from_yaml\n"
        "from sweeps.engine import trajectories\n"
        f"config = from_yaml('simulation: {{periods: 1}}\\nintegrator: {method}\\n')\n"
        "kept = lambda: {p.name: p.stat().st_size for p in Path('cache').rglob('*')}\n"
        "trajectories.compile_trajectory_kernels(config)\n"
        "compiled = kept()\n"
        "trajectories.trajectory(config)\n"
        "assert compiled and kept() == compiled, kept().keys() - compiled.keys()\n"
    )
    own = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    process = [sys.executable, "-c", code]
    subprocess.run(process, cwd=tmp_path, env=own, check=True, timeout=HANGS)


def test_trajectories_along_an_axis_are_those_of_simulate() -> None:
    found = trajectories(config(sweep={"omega": [10, 15, 32]}, title="Three"))
    assert found.friction_force.dims == ("angular_frequency", "sample")
    assert found.elapsed_time.dims == ("angular_frequency", "sample")
    assert "elapsed_time" in found.coords
    np.testing.assert_array_equal(found.angular_frequency, [10.0, 15.0, 32.0])
    assert found.temperature.shape == ()
    for omega in (10.0, 15.0, 32.0):
        one = stickslip.simulate(Parameters(angular_frequency=omega), **SHORT)
        run = found.sel(angular_frequency=omega)
        for name in [*one.data_vars, "elapsed_time"]:
            np.testing.assert_array_equal(run[name].values, one[name].values)
            assert run[name].attrs == one[name].attrs
    assert found.attrs["title"] == "Three"
    assert found.attrs["Conventions"] == "CF-1.8"


@pytest.mark.parametrize(
    "parts",
    [
        {},
        AXIS,
        CASES,
        {"sweep": {"T": [200, 250]}} | CASES,
        {"sweep": {"T": [200, 250]}, "follow": "T"},
    ],
)
def test_several_trajectories_need_exactly_one_axis(parts: dict[str, Any]) -> None:
    with pytest.raises(OtherAxesError, match="exactly one axis"):
        trajectories(config(**parts))


def test_pulls_along_an_axis_are_refused() -> None:
    pull = {"drive": {"velocity": 2e-6}, "duration": 1}
    with pytest.raises(PulledError, match="simulate one at a time, with --set"):
        trajectories(from_mapping({"sweep": {"T": [200, 250]}, "simulation": pull}))
