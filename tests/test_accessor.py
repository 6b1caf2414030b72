"""`ds.stickslip`: points, pictures and masks of a Dataset."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from stickslip import Status, simulate
from sweeps import run

MAP = {
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "sweep": {"T": {"linspace": [200, 300], "num": 9}, "K": {"linspace": [500, 3000], "num": 9}},
}


@pytest.fixture(scope="module")
def ds() -> xr.Dataset:
    return run(MAP)


@pytest.mark.parametrize(
    "code",
    [
        "import sweeps.accessor",
        "from stickslip import simulate; simulate(periods=1)",
        pytest.param("from sweeps import run; run({})", marks=pytest.mark.stress),
    ],
)
def test_a_dataset_has_the_accessor_after(code: str) -> None:
    script = f"{code}\nimport xarray as xr; assert xr.Dataset().stickslip is not None"
    subprocess.run([sys.executable, "-c", script], check=True, stderr=subprocess.DEVNULL)


def test_importing_the_packages_loads_no_xarray() -> None:
    code = "import sweeps, stickslip, sys; assert 'xarray' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_point(ds: xr.Dataset) -> None:
    point = ds.stickslip.at(T=250, K=500)
    assert point.parameters.temperature == 250.0
    assert point.differences() == {}
    assert isinstance(point.portrait(), Figure)
    axes = Figure().subplots()
    assert point.portrait(ax=axes) is axes
    assert axes.lines


def test_values_of_axes_may_be_arrays(ds: xr.Dataset) -> None:
    point = ds.stickslip.at(T=ds.temperature[4], K=ds.spring_stiffness.max())
    assert (point.parameters.temperature, point.parameters.spring_stiffness) == (250.0, 3000.0)
    for values in (np.array([500.0, 3000.0]), ds.spring_stiffness[[0, -1]], [500, 3000]):
        figure = ds.stickslip.plot("friction_force_amplitude", x="T", at={"K": values})
        assert [text.get_text() for text in figure.legends[0].get_texts()] == [
            "$K = 500$ N/m",
            "$K = 3000$ N/m",
        ]
    assert len(ds.stickslip.plot("F_max", x="T", at={"K": ds.spring_stiffness[0]}).axes) == 1


def test_failed_points_are_masked(ds: xr.Dataset) -> None:
    failed = ds.copy(deep=True)
    failed.status[0, 0], failed.status[1, 1] = Status.DIVERGED, Status.INTERPOLATED
    masked = failed.stickslip.ok()
    assert np.isnan(masked.melting_count[0, 0])
    assert np.isnan(masked.friction_force_amplitude[0, 0])
    assert masked.melting_count[1, 1] == ds.melting_count[1, 1]
    assert int(np.isnan(masked.melting_count).sum()) == 1
    assert masked.attrs == failed.attrs


def test_an_empty_selection_is_refused_for_what_it_is(ds: xr.Dataset) -> None:
    nothing, said = ds.isel(temperature=[]), "this selection has no points along temperature"
    with pytest.raises(ValueError, match=said):
        nothing.stickslip.plot()
    with pytest.raises(ValueError, match=said):
        nothing.stickslip.plot("regime", x="K")
    with pytest.raises(ValueError, match=said):
        nothing.stickslip.map("regime", x="T", y="K")
    with pytest.raises(ValueError, match=said):
        nothing.stickslip.at(T=250, K=500)
    with pytest.raises(ValueError, match=said):
        nothing.stickslip.boundaries()
    with pytest.raises(ValueError, match="no points along elapsed_time"):
        simulate(periods=1).isel(elapsed_time=[]).stickslip.plot("F")
    assert nothing.stickslip.ok().sizes["temperature"] == 0


def test_masks_and_quantiles_need_a_status(ds: xr.Dataset) -> None:
    bare = ds.drop_vars("status")
    with pytest.raises(ValueError, match="not the result of a sweep: it lacks a status"):
        bare.stickslip.ok()
    with pytest.raises(ValueError, match="not the result of a sweep: it lacks a status"):
        bare.rename(temperature="case").stickslip.quantiles()


def test_pictures(ds: xr.Dataset) -> None:
    curves = ds.stickslip.plot("friction_force_amplitude", x="T", at={"K": 500})
    assert len(curves.axes[0].lines) >= 1
    assert isinstance(simulate(periods=1).stickslip.plot(), Figure)
    with pytest.raises(ValueError, match="unknown variable"):
        ds.stickslip.plot("friction")


def test_a_map_cuts_the_cases_at_a_linked_parameter() -> None:
    linked = {"K": [500, 1000, 2000, 3000], "k": [4e4, 5e4, 6e4, 7e4]}
    ds = run({"sweep": {"T": [200, 250, 300], "omega": [10, 12]}, "cases": linked})
    assert ds.stickslip.map("regime", K=500).axes
    assert ds.stickslip.map("regime", x="K", omega=10).axes


def test_maps_take_the_longest_axes(ds: xr.Dataset) -> None:
    assert ds.stickslip.map("regime").axes
    assert ds.stickslip.map("friction_force_amplitude", x="K").axes
    with pytest.raises(ValueError, match="a map needs two axes"):
        ds.stickslip.map("regime", K=500)
    with pytest.raises(ValueError, match=r"for ax call plot\('regime', x=..., y=..., ax=...\)"):
        ds.stickslip.map("regime", ax=Figure().subplots())


def test_it_says_what_a_dataset_holds(ds: xr.Dataset) -> None:
    text = "<stickslip accessor of a sweep (temperature: 9, spring_stiffness: 9)>"
    assert repr(ds.stickslip) == text
    motion = simulate(periods=1, samples_per_period=20)
    assert repr(motion.stickslip) == "<stickslip accessor of a trajectory (elapsed_time: 21)>"


def test_a_notebook_shows_a_picture_that_pyplot_does_not_know(ds: xr.Dataset) -> None:
    png = ds.stickslip.plot()._repr_png_()  # type: ignore[attr-defined]
    assert png.startswith(b"\x89PNG")
