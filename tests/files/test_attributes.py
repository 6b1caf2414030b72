"""Names, units, types, flags and provenance of a result file, on which docs and scripts rely."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import matplotlib as mpl
import netCDF4
import numpy as np
import pytest
import xarray as xr
from support.marks import marked
from support.sweeps.writing import write_dataset

from stickslip import Status
from stickslip.compiled.cache import processor, source_hash
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.parameters import Parameters
from stickslip.regime import Regime
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS
from sweeps.config.load import Config, from_mapping, from_yaml
from sweeps.engine.run import run
from sweeps.engine.trajectories import trajectories, trajectory
from sweeps.files.attributes import result_dataset
from sweeps.grid import Grid

FLAGS = {"status": Status, "regime": Regime}
ATTRIBUTES = {
    "Conventions",
    "title",
    "summary",
    "source",
    "history",
    "references",
    "config",
    "config_sha256",
    "software",
    "code_sha256",
    "numerics_version",
    "processor",
    "data_sha256",
}
CASES = {"drive_amplitude": [0.4e-6, 0.8e-6], "angular_frequency": [20, 10]}
SWEEPS: dict[str, dict[str, Any]] = {
    "one axis": {"sweep": {"T": [200, 250]}},
    "two axes": {"sweep": {"T": [200, 250], "gamma": [-2 / 3, 0, 2 / 3]}},
    "cases": {"cases": CASES},
    "an axis and cases": {"sweep": {"T": [200, 250, 300]}, "cases": CASES},
    "one point": {},
}
LOOSE = {"integrator": {"rtol": 1e-4}}
SHORT = {"simulation": {"periods": 1, "samples_per_period": 20}}


def rows(size: int) -> np.ndarray:
    """Results that differ for each point and column."""
    results = np.arange(size * len(RESULT_COLUMNS), dtype=float).reshape(size, -1) + 1.0
    results[:, -1] = 0
    results[:, RESULT_COLUMNS.index("regime")] = np.arange(size) % 6  # a byte
    return results


def made(config: dict[str, Any]) -> xr.Dataset:
    settings = from_mapping(config)
    grid = Grid.from_config(settings)
    return result_dataset(settings, grid, rows(grid.size))


@pytest.fixture
def stored(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[netCDF4.Dataset]:
    """The file of a sweep, opened with the NetCDF library."""
    write_dataset(made(SWEEPS[request.param]), tmp_path / "a.nc")
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        file.set_auto_mask(False)
        yield file


all_sweeps = pytest.mark.parametrize("stored", ["an axis and cases", "one point"], indirect=True)


@all_sweeps
def test_variables_types_units_and_fill_values(stored: netCDF4.Dataset) -> None:
    assert {*stored.variables} - {*PARAMETERS, "case"} == set(RESULT_COLUMNS)
    for name in RESULT_COLUMNS:
        declared = RESULTS[name]
        variable, is_float = stored[name], declared.dtype == "f8"
        assert variable.dtype == np.dtype(declared.dtype), name
        assert variable.units == declared.units, name
        assert variable.long_name, name
        assert ("_FillValue" in variable.ncattrs()) == is_float, name
        assert not is_float or np.isnan(variable._FillValue), name
    assert stored.data_model == "NETCDF4"


@all_sweeps
def test_parameters_are_coordinates_with_symbol_and_unit(stored: netCDF4.Dataset) -> None:
    for name, parameter in PARAMETERS.items():
        variable = stored[name]
        assert variable.dtype == np.float64
        assert (variable.units, variable.symbol) == (parameter.units, parameter.symbol)
        assert "_FillValue" not in variable.ncattrs()
        if not variable.dimensions:
            assert variable[()] == getattr(Parameters(), name)
    scalars = {name for name in PARAMETERS if not stored[name].dimensions}
    assert scalars <= set(stored["status"].coordinates.split())


@all_sweeps
@pytest.mark.parametrize("name", FLAGS)
def test_flags_are_complete(stored: netCDF4.Dataset, name: str) -> None:
    flags = stored[name]
    assert flags.flag_values.dtype == np.int8
    words = flags.flag_meanings.split()
    codes = {each.name.lower(): each.value for each in FLAGS[name]}
    assert dict(zip(words, flags.flag_values.tolist(), strict=True)) == codes


@all_sweeps
def test_attributes_are_texts_without_gaps(stored: netCDF4.Dataset) -> None:
    assert set(stored.ncattrs()) == ATTRIBUTES
    for holder in [stored, *stored.variables.values()]:
        for name in holder.ncattrs():
            value = holder.getncattr(name)
            if name in ("_FillValue", "flag_values"):
                continue
            assert isinstance(value, str), (holder, name)
            assert value
            assert value not in ("None", "True", "False")
            assert not value.startswith("{")
    assert stored.Conventions == "CF-1.8"


def test_dimensions_follow_the_config() -> None:
    ds = made(SWEEPS["an axis and cases"])
    assert ds.status.dims == ("temperature", "case")
    assert ds.status.shape == (3, 2)
    assert ds.case.dtype == np.int32
    np.testing.assert_array_equal(ds.case, [0, 1])
    assert ds.drive_amplitude.dims == ds.angular_frequency.dims == ("case",)
    np.testing.assert_array_equal(ds.angular_frequency, [20.0, 10.0])
    assert set(PARAMETERS) <= set(ds.coords)
    swapped = made({"sweep": {"gamma": [0, 1], "T": [200, 250, 300]}})
    assert swapped.status.dims == ("rheological_index", "temperature")
    point = made({})
    assert point.status.dims == ()


def test_each_result_lands_at_its_point() -> None:
    config = SWEEPS["two axes"]
    ds, results = made(config), rows(6)
    for name in RESULT_COLUMNS:
        column = RESULT_COLUMNS.index(name)
        np.testing.assert_array_equal(ds[name].values, results[:, column].reshape(2, 3))
    chosen = ds.sel(temperature=250, rheological_index=0)
    assert chosen.friction_force_amplitude == results[4, 1]


# --- provenance ---


FULL = {
    "title": "All: 100 % \"quoted\" 'text' #1",
    "model": {"K": 2500, "phi_0": 0.25},
    **SWEEPS["an axis and cases"],
    "integrator": {"rtol": 1e-5, "max_steps": 10**7},
    "stationary": {"rtol": 1e-5, "max_periods": 99, "accelerate": False},
    "noise": {"treatment": "none"},
    "output": "elsewhere/b.nc",
    "execution": {"workers": 7, "block_points": 3},
    "plot": {"figure": "phase_portraits"},
    "simulation": {"periods": 3, "start": "stationary", "samples_per_period": 100},
}


def without_execution(config: Config) -> Config:
    plain = from_mapping({})
    return config.model_copy(update={"output": plain.output, "execution": plain.execution})


@pytest.mark.parametrize("config", [*SWEEPS.values(), FULL])
def test_the_stored_config_gives_the_same_sweep_again(config: dict[str, Any]) -> None:
    settings, ds = from_mapping(config), made(config)
    again = from_yaml(ds.attrs["config"])
    assert again == without_execution(settings)
    assert again.sha256() == ds.attrs["config_sha256"] == settings.sha256()
    keys = re.findall(r"^(\w+):", ds.attrs["config"], flags=re.MULTILINE)
    assert "model" in keys
    assert set(keys).isdisjoint({"execution", "output"})


def test_execution_and_output_appear_only_in_the_history() -> None:
    moved = FULL | {"output": "c.nc", "execution": {"workers": 1}}
    first, second = made(FULL).attrs, made(moved).attrs
    first.pop("history"), second.pop("history")
    assert first == second


def test_where_a_file_comes_from(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/where/bin/stickslip", "sweep", "a/b.yaml", "-o", "c d.nc"])
    attrs = made(FULL).attrs
    time, command = attrs["history"].split(" ", 1)
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", time)
    assert command == "stickslip sweep a/b.yaml -o 'c d.nc'"
    assert attrs["title"] == FULL["title"]
    assert made({}).attrs["title"]
    assert attrs["source"].endswith("method adaptive")
    assert attrs["source"].startswith(f"stickslip {metadata.version('stickslip')}, ")
    assert "arXiv:1302.0720" in attrs["references"]
    assert attrs["code_sha256"] == source_hash()
    assert attrs["numerics_version"] == str(NUMERICS_VERSION)
    assert attrs["processor"] == processor()
    for name in ("Python", "stickslip", "numpy", "numba", "llvmlite", "xarray", "netCDF4"):
        assert re.search(rf"\b{name} \d+\.\d+", attrs["software"]), name


# --- other tools ---


def cf_findings(path: Path) -> list[str]:
    """The complaints of the CF checker of IOOS about a file."""
    from compliance_checker.runner import CheckSuite, ComplianceChecker

    CheckSuite.load_all_available_checkers()
    report = path.with_suffix(".json")
    ComplianceChecker.run_checker(
        str(path), ["cf:1.8"], 0, "strict", output_filename=str(report), output_format="json"
    )
    groups = json.loads(report.read_text())["cf:1.8"]
    assert groups["possible_points"] > 100  # it has looked
    return sorted({msg for group in groups["all_priorities"] for msg in group["msgs"]})


# When the checker loads its plug-ins, it warns of one that it is about to drop.
checked = pytest.mark.filterwarnings("ignore:The ioos_sos checker is deprecated:DeprecationWarning")


SCHEDULE = {"schedule": {"temperature": [200.0, 250.0]}}
FOLLOWED = LOOSE | {"sweep": {"omega": [10, 11]}, "follow": "omega"}


def borders(kind: str) -> xr.Dataset:
    ds = run(LOOSE | {"sweep": {"omega": [14.0, 15.0], "T": [200.0, 201.0]}})
    return ds.stickslip.boundaries(1e-2, kind)


FILES: dict[str, Callable[[], xr.Dataset]] = {
    **{name: lambda config=config: made(config) for name, config in SWEEPS.items()},
    "a trajectory": lambda: trajectory(from_mapping(SHORT)),
    "a schedule": lambda: trajectory(from_mapping({"simulation": SHORT["simulation"] | SCHEDULE})),
    "trajectories": lambda: trajectories(from_mapping(SHORT | SWEEPS["one axis"])),
    "a followed sweep": lambda: run(FOLLOWED),
    **{f"borders of {kind}": lambda kind=kind: borders(kind) for kind in ("regime", "orbit")},
}
TELLING = ["an axis and cases", "a trajectory", "borders of orbit"]
LESS_TELLING = [name for name in FILES if name not in TELLING]


@checked
@pytest.mark.parametrize("name", [*TELLING, *marked("stress", LESS_TELLING)])
def test_a_file_follows_the_cf_conventions(tmp_path: Path, name: str) -> None:
    write_dataset(FILES[name](), tmp_path / "a.nc")
    assert cf_findings(tmp_path / "a.nc") == []


@checked
def test_the_checker_would_find_something(tmp_path: Path) -> None:
    ds = made(SWEEPS["one axis"])
    ds.temperature.attrs["units"] = "furlongs per what"
    ds.to_netcdf(tmp_path / "a.nc")
    assert cf_findings(tmp_path / "a.nc")


def test_the_documented_one_liners_plot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mpl.use("Agg")
    from matplotlib import pyplot as plt

    path = tmp_path / "a.nc"
    write_dataset(run(SWEEPS["two axes"], workers=1), path)
    try:
        with xr.open_dataset(path) as ds:
            ds.friction_force_amplitude.plot()
            plt.figure()
            ds.friction_force_amplitude.sel(rheological_index=0, method="nearest").plot()
            label = plt.gca().get_ylabel().replace("\n", " ")
            assert label == "amplitude of the friction force [N]"
            assert plt.gca().get_xlabel() == "lubricant temperature [K]"
            plt.figure()
            ok = ds.where(ds.status == 0)
            ok.elastic_stress_amplitude.plot(x="temperature", hue="rheological_index")
            assert len(plt.gca().lines) == 3
    finally:
        plt.close("all")
