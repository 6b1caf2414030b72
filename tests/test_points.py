"""Orbits of many points in one call: the arguments and the Dataset."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from joblib.parallel import get_active_backend
from support.marks import one_then

from stickslip import (
    NoiseError,
    OptionError,
    ParameterError,
    Parameters,
    stationary_orbit,
    stationary_orbits,
)
from stickslip.dispatch import backend
from stickslip.dispatch.errors import ExecutorError
from stickslip.orbit import failed_row
from stickslip.points import places_of, results_at, rows_of
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS
from sweeps import run

TEMPERATURES = [200.0, 228.0, 250.0]


def assert_single(ds: xr.Dataset, **changes: float) -> None:
    """Assert that a point is what `stationary_orbit` finds."""
    orbit = stationary_orbit(Parameters(**changes))
    for name in RESULT_COLUMNS:
        np.testing.assert_equal(ds[name].item(), getattr(orbit, name), err_msg=name)


# --- the Dataset ----------------------------------------------------------------------------------


def test_each_point_is_the_single_orbit_bit_for_bit() -> None:
    ds = stationary_orbits({"T": TEMPERATURES, "gamma": [0.0, -2 / 3, 2 / 3]})
    assert dict(ds.sizes) == {"point": 3}
    for number, (temperature, index) in enumerate(
        zip(TEMPERATURES, (0.0, -2 / 3, 2 / 3), strict=True)
    ):
        assert_single(ds[{"point": number}], temperature=temperature, rheological_index=index)


def test_a_product_equals_a_sweep_bit_for_bit() -> None:
    temperature = xr.DataArray(TEMPERATURES, dims="temperature")
    stiffness = xr.DataArray([500.0, 3000.0], dims="spring_stiffness")
    ds = stationary_orbits({"temperature": temperature, "spring_stiffness": stiffness})
    swept = run({"sweep": {"T": TEMPERATURES, "K": [500.0, 3000.0]}})
    assert ds.friction_force_amplitude.dims == ("temperature", "spring_stiffness")
    xr.testing.assert_identical(ds, swept.drop_attrs(deep=False))


def test_without_parameters_it_is_the_paper() -> None:
    ds = stationary_orbits({})
    assert not ds.sizes
    assert_single(ds)


def test_no_points_are_no_orbits() -> None:
    assert stationary_orbits({"T": []}).friction_force_amplitude.shape == (0,)


def test_parameters_and_results_have_their_units() -> None:
    ds = stationary_orbits({"T": 250.0})
    assert set(ds.coords) == set(PARAMETERS)
    assert set(ds.data_vars) == set(RESULT_COLUMNS)
    for name in (*PARAMETERS, *RESULT_COLUMNS):
        assert ds[name].attrs["units"] == {**PARAMETERS, **RESULTS}[name].units


def test_asking_for_observables_changes_nothing() -> None:
    ds = stationary_orbits({"T": [250.0]})
    xr.testing.assert_identical(stationary_orbits({"T": [250.0]}, observables="harmonics"), ds)
    single = stationary_orbit(Parameters(temperature=250.0), observables=["moments"])
    assert ds.friction_force_out_of_phase.item() == single.friction_force_out_of_phase
    assert ds.friction_force_rms.item() == single.friction_force_rms


@pytest.mark.parametrize("jobs", [1, 2, 3])
def test_the_number_of_threads_changes_no_bit(jobs: int) -> None:
    points = {"T": np.linspace(150.0, 320.0, 70)}
    with joblib.parallel_config(n_jobs=jobs):
        ds = stationary_orbits(points, rtol=1e-4)
    xr.testing.assert_identical(ds, stationary_orbits(points, rtol=1e-4))


@pytest.mark.parametrize("kind", one_then("stress", ["threading", "loky"]))
def test_joblib_chooses_the_workers(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    compute = backend.JoblibWorkers.blocks

    def watched(self: backend.JoblibWorkers, *arguments: Any) -> Any:
        asked.append(type(get_active_backend()[0]).__name__)
        return compute(self, *arguments)

    monkeypatch.setattr(backend.JoblibWorkers, "blocks", watched)
    points = {"T": np.linspace(150.0, 320.0, 70)}
    expected = stationary_orbits(points, rtol=1e-4)
    assert asked == []
    with joblib.parallel_config(kind, n_jobs=2):
        xr.testing.assert_identical(stationary_orbits(points, rtol=1e-4), expected)
    assert asked == [f"{kind.capitalize()}Backend"]


def test_a_backend_that_returns_all_results_at_once_is_refused() -> None:
    with (
        joblib.parallel_config("multiprocessing", n_jobs=2),
        pytest.raises(ExecutorError, match="MultiprocessingBackend cannot return blocks as they"),
    ):
        stationary_orbits({"T": TEMPERATURES}, rtol=1e-4)


@pytest.mark.stress
def test_late_points_among_many_and_few_have_the_same_bits() -> None:
    odd = {"k": 22802, "K": 2349.9, "T": 205.9, "window": 40, "rtol": 1e-4}
    options = {name: odd.pop(name) for name in ("window", "rtol")}
    many = stationary_orbits(odd | {"omega": np.linspace(34.0, 37.0, 300)}, **options)
    assert (many.status == Status.APERIODIC).any()
    for some in (slice(0, 300, 50), slice(20, 21)):
        few = stationary_orbits(odd | {"omega": many.angular_frequency.values[some]}, **options)
        xr.testing.assert_equal(few, many.isel(point=some))


def test_options_are_passed_on() -> None:
    ds = stationary_orbits({"T": [250.0]}, rtol=1e-9, accelerate=False)
    orbit = stationary_orbit(Parameters(temperature=250.0), rtol=1e-9, accelerate=False)
    assert ds.friction_force_amplitude.item() == orbit.friction_force_amplitude
    assert ds.periods_integrated.item() == orbit.periods_integrated


# --- the arguments --------------------------------------------------------------------------------


def test_rows_of_a_table_are_points() -> None:
    table = pd.DataFrame({"T": TEMPERATURES, "k": [5e4, 4e4, 3e4]}, index=list("abc"))
    ds = stationary_orbits(table)
    assert ds.point.values.tolist() == list("abc")
    assert_single(ds.sel(point="b"), temperature=228.0, viscosity_coefficient=4e4)


def test_parameters_in_the_index_of_a_table_count() -> None:
    table = pd.DataFrame({"T": TEMPERATURES, "k": [5e4, 4e4, 3e4]})
    for index in ("T", ["T", "k"]):
        rest = table.set_index(index, append=index == "T")
        ds = stationary_orbits(rest if rest.shape[1] else rest.assign(gamma=-2 / 3))
        assert ds.temperature.values.tolist() == TEMPERATURES
        assert ds.viscosity_coefficient.values.tolist() == [5e4, 4e4, 3e4]


def test_an_index_may_be_named_by_a_number() -> None:
    ds = stationary_orbits(pd.DataFrame({"T": [250.0]}, index=pd.Index([7], name=1)))
    assert ds.friction_force_amplitude.dims == ("1",)
    assert ds["1"].values.tolist() == [7]


def test_coordinates_of_a_dataset_are_parameters_as_its_variables_are() -> None:
    given = xr.Dataset(
        {"T": ("x", TEMPERATURES)}, {"K": ("x", [500.0, 1e3, 2e3]), "x": list("abc")}
    )
    rows = rows_of(places_of(given))
    assert rows[:, Parameters._fields.index("spring_stiffness")].tolist() == [500.0, 1e3, 2e3]
    alone = places_of(given.drop_vars("T"))
    assert alone.spring_stiffness.dims == ("x",)
    assert alone.x.values.tolist() == list("abc")


def test_points_of_a_stacked_result_are_computed_again() -> None:
    grid = places_of(
        {
            "T": xr.DataArray(TEMPERATURES, dims="temperature"),
            "omega": xr.DataArray([10.0, 20.0], dims="angular_frequency"),
        }
    )
    stacked = grid.stack(place=("temperature", "angular_frequency"))
    again = {"T": stacked.temperature, "omega": stacked.angular_frequency}
    for points in (again, stacked):
        places = places_of(points)
        assert dict(places.sizes) == {"place": 6}
        np.testing.assert_array_equal(rows_of(places), rows_of(grid))
    labels = {"run": [1, 2], "temperature": TEMPERATURES}
    runs = xr.DataArray([TEMPERATURES] * 2, labels, ["run", "temperature"])
    of_runs = places_of({"T": runs.stack(place=("run", "temperature"))})
    assert of_runs.run.values.tolist() == [1, 1, 1, 2, 2, 2]
    assert of_runs.temperature.values.tolist() == TEMPERATURES * 2


def test_coordinates_of_an_array_hide_no_result() -> None:
    labels = {"status": ("x", [3, 3]), "temperature": ("x", [1.0, 2.0]), "x": [5, 6]}
    places = places_of({"k": xr.DataArray([4e4, 5e4], labels, "x")})
    assert float(places.temperature) == 200.0
    assert places.x.values.tolist() == [5, 6]
    ds = results_at(places, np.tile(failed_row(Status.FAILED), (2, 1)))
    assert set(ds.data_vars) == set(RESULT_COLUMNS)
    assert ds.status.values.tolist() == [Status.FAILED] * 2


def test_arrays_broadcast_as_in_numpy() -> None:
    ds = stationary_orbits({"T": np.array(TEMPERATURES)[:, None], "k": np.array([5e4, 3e4])})
    assert dict(ds.sizes) == {"dim_0": 3, "dim_1": 2}
    where = ds[{"dim_0": 2, "dim_1": 1}]
    assert_single(where, temperature=250.0, viscosity_coefficient=3e4)


def test_later_changes_of_an_array_do_not_reach_the_result() -> None:
    temperature, viscosity = np.array([200.0]), np.array(3e4)
    ds = stationary_orbits({"T": temperature, "k": viscosity})
    temperature += 50.0
    viscosity += 1e4
    assert ds.temperature.item() == 200.0
    assert ds.viscosity_coefficient.item() == 3e4
    assert ds.temperature.values.flags.writeable


def test_a_number_holds_for_all_points() -> None:
    ds = stationary_orbits({"T": TEMPERATURES, "k": 3e4})
    assert ds.viscosity_coefficient.dims == ()
    assert_single(ds[{"point": 0}], temperature=200.0, viscosity_coefficient=3e4)


WRONG: dict[str, tuple[Any, type[Exception], str]] = {
    "a misspelt parameter": ({"temprature": 3.0}, TypeError, "did you mean 'temperature'?"),
    "a parameter twice": ({"T": 200.0, "temperature": 250.0}, TypeError, "given twice"),
    "no mapping": ([200.0, 250.0], TypeError, "points must map parameters to their values"),
    "out of range": ({"T": [200.0, -1.0]}, ParameterError, "temperature must be at least 0"),
    "not a number": ({"T": [200.0, np.nan]}, ParameterError, "finite number, not nan"),
    "zero": ({"X_m": [1e-6, 0.0, -1e-6]}, ParameterError, "drive_amplitude must not be 0"),
    "unbounded": ({"d": [0.0, 10.0]}, ParameterError, "grows without bound"),
    "lengths": (
        {"T": [1.0, 2.0], "k": [1.0, 2.0, 3.0]},
        ValueError,
        "need the same number of values, but have: temperature 2, viscosity_coefficient 3",
    ),
    "shapes": (
        {"T": [1.0, 2.0], "k": [[1.0, 2.0, 3.0]], "K": 1.0},
        ValueError,
        "need the same number of values, but have: temperature 2, viscosity_coefficient 1 x 3",
    ),
    "ragged": ({"T": [1.0, [2.0]]}, ParameterError, "temperature must be a number, or an array"),
    "words": ({"k": ["a", 1.0]}, ParameterError, "viscosity_coefficient must be a number, or"),
    "numbers as text": ({"T": ["200", "250"]}, ParameterError, "list of numbers, not '200'"),
    "truth values": ({"T": np.array([True])}, ParameterError, "list of numbers, not True"),
    "a truth value": ({"T": np.array([True, 1.0], object)}, ParameterError, "number, not True"),
    "complex numbers": ({"T": [200.0 + 1.0j]}, ParameterError, "list of numbers, not (200+1j)"),
    "masked": (
        {"T": np.ma.array([200.0, 250.0], mask=[0, 1])},
        ParameterError,
        "none of them masked",
    ),
    "a word in a column": (
        pd.DataFrame({"T": [200.0, "x"]}),
        ParameterError,
        "temperature must be a number, not 'x'",
    ),
    "text along a dimension": (
        {"T": xr.DataArray(["200"], dims="a")},
        ParameterError,
        "temperature must be a number, or an array or a list of numbers, not '200'",
    ),
    "lengths along a dimension": (
        {"T": xr.DataArray([1.0, 2.0], dims="a"), "k": xr.DataArray([1.0, 2.0, 3.0], dims="a")},
        ValueError,
        "need equal coordinates, but have: temperature 2, viscosity_coefficient 3",
    ),
    "a parameter as a dimension alone": (
        {"T": xr.DataArray([200.0], {"viscosity_coefficient": [1e5]}, "viscosity_coefficient")},
        ValueError,
        "viscosity_coefficient is a dimension of the points, but its values are not along it",
    ),
    "a parameter along another dimension": (
        {
            "T": xr.DataArray([200.0], dims="a"),
            "k": xr.DataArray([5e4], dims="temperature"),
        },
        ValueError,
        "temperature is a dimension of the points, but its values are not along it",
    ),
    "a parameter as a level alone": (
        {"k": xr.DataArray([5e4], {"temperature": ("a", [250.0])}, "a").set_xindex("temperature")},
        ValueError,
        "temperature is an index of the points, but its values are not given",
    ),
    "a result as a dimension": (
        pd.DataFrame({"T": [200.0]}, index=pd.Index([2], name="regime")),
        ValueError,
        "regime is a dimension of the points and also a result; rename the dimension",
    ),
    "other coordinates": (
        {
            "T": xr.DataArray([200.0, 250.0], {"sample": [1, 2]}, "sample"),
            "k": xr.DataArray([4e4, 5e4], {"sample": [1, 3]}, "sample"),
        },
        ValueError,
        "sample",
    ),
    "a column twice": (
        pd.DataFrame([[200.0, 250.0]], columns=["T", "T"]),
        TypeError,
        "T is given twice, by the columns",
    ),
    "a column and the index": (
        pd.DataFrame({"T": [200.0]}).set_index("T", drop=False),
        TypeError,
        "T is given twice, by the columns",
    ),
    "a column of measurements": (
        pd.DataFrame({"T": [200.0], "friction": [1e-3]}),
        TypeError,
        "no parameter 'friction'",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_invalid_arguments_are_refused_with_a_reason(case: str) -> None:
    points, error, words = WRONG[case]
    with pytest.raises(error, match=re.escape(words)):
        stationary_orbits(points)


def test_options_are_checked_as_for_a_single_orbit() -> None:
    with pytest.raises(OptionError, match="rtol"):
        stationary_orbits({"T": [200.0]}, rtol=2.0)
    with pytest.raises(TypeError, match="there is no option rtoll"):
        stationary_orbits({"T": [200.0]}, rtoll=1e-6)
    with pytest.raises(NoiseError):
        stationary_orbits({"T": [200.0]}, noise="none")


_IN_A_POOL = """
import multiprocessing
from stickslip import stationary_orbits

def force(temperature):
    return float(stationary_orbits({"T": [temperature]}).friction_force_amplitude[0])

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(pool.map(force, [200.0]))
"""


@pytest.mark.slow
def test_a_worker_of_a_pool_prints_nothing(tmp_path: Path) -> None:
    script = tmp_path / "pool.py"
    script.write_text(_IN_A_POOL)
    command = [sys.executable, "-W", "error", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    force = stationary_orbit(Parameters(temperature=200.0)).friction_force_amplitude
    assert done.stdout == f"[{force!r}]\n"
