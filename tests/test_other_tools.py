"""Results in the hands of other libraries: units, Zarr, several files, ArviZ, hvPlot."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from sweeps import run
from sweeps.files.netcdf import open_result

pytestmark = pytest.mark.stress  # they import half of the ecosystem

LOOSE: dict[str, Any] = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
AXES: dict[str, Any] = {"sweep": {"T": [200, 250, 300], "gamma": [-2 / 3, 0]}}


@pytest.fixture(autouse=True)
def warnings_of_others() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two results that differ in the stiffness of the springs, and two halves of one."""
    folder = tmp_path_factory.mktemp("results")
    for name, changes in {
        "soft": {"model": {"K": 2000}},
        "stiff": {},
        "cold": {"sweep": {"T": [200, 220], "gamma": [-2 / 3, 0]}},
        "warm": {"sweep": {"T": [250, 300], "gamma": [-2 / 3, 0]}},
    }.items():
        run(LOOSE | AXES | changes, output=folder / f"{name}.nc")
    return folder


def result(folder: Path) -> xr.Dataset:
    return open_result(folder / "stiff.nc")


def test_pint_reads_the_units_of_all_variables(folder: Path) -> None:
    pytest.importorskip("pint_xarray")
    registry = pytest.importorskip("cf_xarray.units").units
    ds = result(folder).pint.quantify(unit_registry=registry)
    force = ds.friction_force_amplitude.pint.to("mN").pint.dequantify()
    np.testing.assert_allclose(force, 1e3 * result(folder).friction_force_amplitude)
    assert str(ds.kinetic_coefficient.pint.units) == "meter ** 3 / joule / second"


def test_zarr_gives_the_result_back_and_its_points(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    result(folder).to_zarr(tmp_path / "a.zarr")
    back = xr.open_zarr(tmp_path / "a.zarr").load()
    xr.testing.assert_identical(back, result(folder))
    assert back.stickslip.at(T=250, gamma=0).differences() == {}


def test_files_are_opened_together(folder: Path) -> None:
    files = [folder / "soft.nc", folder / "stiff.nc"]
    both = xr.open_mfdataset(files, combine="nested", concat_dim="spring_stiffness")
    assert both.spring_stiffness.values.tolist() == [2000.0, 3000.0]
    halves = xr.open_mfdataset([folder / "cold.nc", folder / "warm.nc"]).load()
    assert halves.temperature.values.tolist() == [200.0, 220.0, 250.0, 300.0]
    ends = halves.friction_force_amplitude.sel(temperature=[200, 250, 300])
    np.testing.assert_array_equal(ends, result(folder).friction_force_amplitude)


def test_a_result_that_was_saved_again_keeps_its_points_and_a_change_is_seen(
    folder: Path, tmp_path: Path
) -> None:
    result(folder).to_netcdf(tmp_path / "again.nc")
    again = xr.open_dataset(tmp_path / "again.nc").load()
    assert again.stickslip.at(T=250, gamma=0).differences() == {}
    again["friction_force_amplitude"] = 1.1 * again.friction_force_amplitude
    again.to_netcdf(tmp_path / "changed.nc")
    changed = xr.open_dataset(tmp_path / "changed.nc").load()
    assert [*changed.stickslip.at(T=250, gamma=0).differences()] == ["friction_force_amplitude"]


def test_hvplot_draws_a_curve_for_each_fluid(folder: Path) -> None:
    pytest.importorskip("hvplot.xarray")
    curves = result(folder).friction_force_amplitude.hvplot(x="temperature", by="rheological_index")
    assert len(curves) == 2
