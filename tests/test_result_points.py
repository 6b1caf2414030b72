"""Points of a result, computed again from the file alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from support import messages

from stickslip import IntegrationError, Parameters, Status
from stickslip.variables import STROBOSCOPIC
from sweeps import run
from sweeps.borders import BoundaryError
from sweeps.files.netcdf import open_result
from sweeps.page import ReportError
from sweeps.points import PointError, point_of

LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
MAP = LOOSE | {"sweep": {"T": [200, 250, 300], "gamma": [-2 / 3, 0]}}
LINE = LOOSE | {"sweep": {"omega": [37.0, 38.0, 39.0]}, "follow": "omega"}
CASES = LOOSE | {
    "cases": {"T": [200.0, 210.0], "k": [5e4, 6e4]},
    "model": {"spring_stiffness": 2500},
}


@pytest.fixture(scope="module")
def ds(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    path = tmp_path_factory.mktemp("points") / "a.nc"
    run(MAP, output=path)
    return open_result(path)


@pytest.fixture(scope="module")
def followed() -> xr.Dataset:
    return run(LINE)


@pytest.mark.parametrize("temperature", [200.0, 250.0, 300.0])
@pytest.mark.parametrize("gamma", [-2 / 3, 0.0])
def test_a_point_is_computed_again_with_its_bits(
    ds: xr.Dataset, temperature: float, gamma: float
) -> None:
    point = point_of(ds, T=temperature, rheological_index=gamma)
    chosen = ds.sel(temperature=temperature, rheological_index=gamma)
    assert (point.parameters.temperature, point.parameters.rheological_index) == (
        temperature,
        gamma,
    )
    np.testing.assert_equal(dict(point.stored), {n: v.item() for n, v in chosen.data_vars.items()})
    assert point.differences() == {}
    stress = chosen.elastic_stress_amplitude.item()
    assert point.orbit().elastic_stress_amplitude == stress


def test_a_changed_number_in_the_file_is_found(ds: xr.Dataset) -> None:
    changed = ds.copy(deep=True)
    changed.friction_force_amplitude[0, 0] *= 1.0 + 1e-15
    point = point_of(changed, T=200, gamma=-2 / 3)
    assert list(point.differences()) == ["friction_force_amplitude"]


def test_a_part_of_a_result_has_points_too(ds: xr.Dataset) -> None:
    part = ds.sel(rheological_index=0.0).isel(temperature=slice(1, None))
    point = point_of(part, temperature=251)
    assert point.where == "temperature = 250 K, rheological_index = 0"
    assert point.differences() == {}


def test_dropped_parameters_are_those_of_the_config_or_refused() -> None:
    ds = run({"model": {"K": 1000}, "sweep": {"T": [150, 250], "omega": [10, 40]}})
    point = point_of(ds.drop_vars("spring_stiffness"), T=150, omega=40)
    assert point.parameters.spring_stiffness == 1000.0
    assert not point.differences()
    with pytest.raises(PointError, match="this result has lost temperature, which varied in it"):
        point_of(ds.isel(temperature=0, drop=True), omega=40)


def test_a_stack_of_results_gives_each_point_its_own_orbit_or_none() -> None:
    one = MAP | {"sweep": {"T": [200, 250]}}
    ds, stiffer = (run(one | {"model": {"K": stiffness}}) for stiffness in (3000, 4000))
    films = xr.concat([ds, stiffer], pd.Index(["soft", "stiff"], name="film"))
    point = films.stickslip.at(T=250, film="stiff")
    assert point.where == "temperature = 250 K, spring_stiffness = 4000 N m-1, film = stiff"
    force = stiffer.friction_force_amplitude.sel(temperature=250).item()
    assert point.orbit().friction_force_amplitude == force
    strict = run(one | {"integrator": {"rtol": 1e-8}})
    mixed = xr.concat([ds, strict], pd.Index([1e-4, 1e-8], name="rtol"))
    assert mixed.stickslip.at(T=250, rtol=1e-4).orbit().status is Status.OK
    for chosen in (mixed, mixed.sel(rtol=1e-8), mixed.isel(rtol=1).drop_vars("rtol")):
        where = {"rtol": 1e-8} if "rtol" in chosen.dims else {}
        other = chosen.stickslip.at(T=250, **where)
        for compute in (other.orbit, other.simulate, other.portrait):
            with pytest.raises(PointError, match=f"results {messages.OTHER_SETTINGS}"):
                compute()
    with pytest.raises(PointError, match=f"results {messages.OTHER_SETTINGS}"):
        point_of(mixed, ["T=250", "rtol=1e-8"]).orbit()
    bare = xr.concat([part.reset_coords(drop=True) for part in (ds, stiffer)], "film")
    with pytest.raises(PointError, match=r"it is unknown whether .*parameters were dropped"):
        bare.stickslip.at(T=250, film=1)


def test_a_dataset_in_other_units_or_single_precision_is_no_stack(ds: xr.Dataset) -> None:
    single = ds.map(lambda column: column.astype("f4") if column.dtype.kind == "f" else column)
    for changed in (single, ds.assign(friction_force_amplitude=1e3 * ds.friction_force_amplitude)):
        point = changed.assign_attrs(ds.attrs).stickslip.at(T=200, gamma=0)
        assert point.orbit().status is Status.OK


def test_the_time_course_is_that_of_the_orbit(ds: xr.Dataset) -> None:
    point = point_of(ds, T=200, gamma=-2 / 3)
    course = point.simulate()
    assert course.sizes["elapsed_time"] == 2001
    high, low = course.elastic_stress.max().item(), course.elastic_stress.min().item()
    assert 0.5 * (high - low) == pytest.approx(point.orbit().elastic_stress_amplitude, rel=1e-2)
    x = course.lower_displacement.values
    assert x[-1] == pytest.approx(x[0], abs=1e-3 * 0.8e-6)
    assert course.attrs["title"] == point.where


def test_the_schedule_of_a_run_does_not_change_the_motion_of_a_point(ds: xr.Dataset) -> None:
    schedule = {"simulation": {"periods": 3, "schedule": {"K": [1000, 9000]}}}
    point, plain = (point_of(result, T=200, gamma=0) for result in (run(MAP | schedule), ds))
    assert point.simulate().drop_attrs().equals(plain.simulate().drop_attrs())
    assert point.replay(1).sizes == {"elapsed_time": 2001, "period": 201}


def test_a_motion_of_no_periods_is_refused(ds: xr.Dataset) -> None:
    point = point_of(ds, T=200, gamma=0)
    for compute in (point.simulate, point.stroboscopic, point.portrait):
        with pytest.raises(ValueError, match="must be at least 1"):
            compute(0)


def test_the_initial_motion_begins_at_the_start(ds: xr.Dataset) -> None:
    point = point_of(ds, T=200, gamma=-2 / 3)
    course = point.simulate(periods=2, start="initial")
    assert course.lower_displacement.values[0] == 0.0
    strobes = point.stroboscopic(40)
    assert set(strobes.variables) == set(STROBOSCOPIC)
    assert strobes.stroboscopic_displacement.values[0] == 0.0
    state = point.orbit().state
    assert strobes.stroboscopic_displacement.values[-1] == pytest.approx(state[0], abs=1e-9)


@pytest.mark.parametrize("direction", ["up", "down"])
@pytest.mark.parametrize("omega", [37.0, 38.0, 39.0])
def test_a_followed_point_starts_where_the_sweep_did(
    followed: xr.Dataset, direction: str, omega: float
) -> None:
    point = point_of(followed, omega=omega, direction=direction)
    assert point.differences() == {}
    assert direction in point.where


def test_a_followed_point_starts_from_its_neighbour(followed: xr.Dataset) -> None:
    up, down = (point_of(followed, omega=38.0, direction=way) for way in ("up", "down"))
    assert len(up.before) == 1
    assert len(down.before) == 4
    start = up.simulate(periods=1, start="initial").lower_displacement.values[0]
    assert start != 0.0


def test_followed_results_side_by_side_keep_their_lines() -> None:
    stiff, soft = (run(LINE | {"model": {"K": stiffness}}) for stiffness in (3000, 2500))
    both = xr.concat([stiff, soft], "spring_stiffness")
    for stiffness in (3000, 2500):
        for way in ("up", "down"):
            point = both.stickslip.at(K=stiffness, omega=38.0, direction=way)
            assert point.differences() == {}
            assert set(point.before[:, Parameters._fields.index("spring_stiffness")]) == {stiffness}
    shifted = both.assign_coords(angular_frequency=both.angular_frequency + 0.5)
    with pytest.raises(PointError, match=r"follows angular_frequency over values other than 38\.5"):
        shifted.stickslip.at(K=3000, omega=38.5, direction="up")


def test_linked_cases_are_chosen_by_number_or_by_value() -> None:
    ds = run(CASES)
    by_number, by_value = point_of(ds, case=1), point_of(ds, T=210)
    assert by_number.parameters == by_value.parameters
    assert by_number.parameters.spring_stiffness == 2500.0
    assert by_number.differences() == {}
    assert by_number.where == (
        "temperature = 210 K, viscosity_coefficient = 60000 Pa s^(gamma+1), case = 1"
    )


def test_a_value_that_several_cases_share_chooses_none_of_them() -> None:
    ds = run(LOOSE | {"cases": {"T": [200.0, 200.0, 210.0], "k": [5e4, 6e4, 5e4]}})
    with pytest.raises(PointError, match="2 points along case have this value; choose one by case"):
        point_of(ds, T=200)
    assert point_of(ds, T=209).parameters.temperature == 210.0
    with pytest.raises(ValueError, match="2 points along case have this value"):
        ds.stickslip.plot("F_max", at={"T": 200})


def test_a_value_that_an_axis_repeats_chooses_none_of_its_points() -> None:
    soft, stiff = (run(LOOSE | {"sweep": {"T": [200.0]}, "model": {"K": k}}) for k in (2500, 3000))
    both = xr.concat([soft, stiff], "temperature", coords="different", compat="equals")
    with pytest.raises(PointError, match=r"2 points along temperature .* choose one with isel"):
        both.stickslip.at(T=200)
    assert both.isel(temperature=1).stickslip.at().parameters.spring_stiffness == 3000.0
    assert both.stickslip.at(K=2500).parameters.spring_stiffness == 2500.0


def test_an_axis_without_its_values_is_not_numbered(tmp_path: Path) -> None:
    """Its numbers would pass for values: a page once computed the orbits at 0, 1 and 2 K."""
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    bare = run(LOOSE | {"sweep": {"T": [200.0, 210.0, 220.0]}}).drop_vars("temperature")
    said = "the values of temperature were dropped from this result"
    with pytest.raises(ValueError, match=said):
        bare.stickslip.plot()
    with pytest.raises(ReportError, match=said):
        bare.stickslip.report(tmp_path / "a.html")
    with pytest.raises(PointError, match=said):
        bare.stickslip.explore()
    with pytest.raises(BoundaryError, match=said):
        bare.stickslip.boundaries()


def test_a_parameter_along_several_dimensions_selects_no_point() -> None:
    ds = run(LOOSE | {"cases": {"T": [200.0, 210.0, 220.0]}})
    warmer = ds.assign_coords(temperature=ds.temperature + 100.0)
    stack = xr.concat([ds, warmer], "film", coords="different", compat="equals")
    assert stack.temperature.dims == ("film", "case")
    with pytest.raises(PointError, match="temperature varies along film and case together"):
        stack.stickslip.at(T=320)
    with pytest.raises(ValueError, match="temperature varies along film and case together"):
        stack.stickslip.plot("F_max", x="T")


def test_values_may_come_from_an_array(ds: xr.Dataset) -> None:
    for temperature in ds.temperature:
        point = point_of(ds, T=temperature, gamma=ds.rheological_index[0])
        assert point.parameters.temperature == temperature
    assert ds.stickslip.plot("F_max", x="gamma", at={"T": ds.temperature[:2].values}).axes


def test_the_texts_of_a_point(ds: xr.Dataset) -> None:
    point = point_of(ds, T=200, gamma=-2 / 3)
    assert repr(point) == "<Point temperature = 200 K, rheological_index = -0.666667: ok>"
    assert ">stick_slip_symmetric<" in point._repr_html_()


def test_a_single_point_needs_no_choice() -> None:
    point = point_of(run(LOOSE))
    assert (point.where, point.differences()) == ("the only point", {})


def test_an_interpolated_point_is_computed_and_compared_with_nothing(ds: xr.Dataset) -> None:
    guessed = ds.copy(deep=True)
    guessed.status[0, 0] = Status.INTERPOLATED
    point = point_of(guessed, T=200, gamma=-2 / 3)
    assert not point.is_comparable
    assert point.differences() == {}
    assert point.orbit().status is Status.OK


def test_a_failed_point_shows_the_motion_from_its_start() -> None:
    ds = run(MAP | {"stationary": {"max_periods": 1}})
    point = point_of(ds, T=200, gamma=-2 / 3)
    assert point.status is Status.NOT_STATIONARY
    assert point.differences() == {}
    assert point.simulate().lower_displacement.values[0] == 0.0
    with pytest.raises(IntegrationError, match="No stationary start: ") as caught:
        point.simulate(start="stationary")
    assert caught.value.status is Status.NOT_STATIONARY
    with pytest.raises(IntegrationError):
        point_of(run(MAP | {"integrator": {"max_steps": 10}}), T=200, gamma=0).simulate()


def test_a_point_masked_by_ok_is_computed_and_compared_with_nothing() -> None:
    ds = run(MAP | {"stationary": {"max_periods": 1}})
    point = ds.stickslip.ok().stickslip.at(T=200, gamma=-2 / 3)
    assert repr(point).endswith("rheological_index = -0.666667: pending>")
    assert ">pending<" in point._repr_html_()
    assert point.orbit().status is Status.NOT_STATIONARY
    assert point.differences() == {}


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ({"T": 250}, "choose one, for example with rheological_index=-0.666667"),
        ({"T": 400, "gamma": 0}, "temperature goes from 200 to 300"),
        ({"temprature": 250}, "did you mean 'temperature'"),
        ({"T": "warm", "gamma": 0}, "must be a number, not 'warm'"),
        ({"T": 250, "gamma": 0, "omega": 11}, "angular_frequency is 10.0 throughout this file"),
    ],
)
def test_values_that_choose_no_single_point_are_refused(
    ds: xr.Dataset, where: dict[str, Any], message: str
) -> None:
    with pytest.raises(PointError, match=message.replace("(", r"\(")):
        point_of(ds, **where)


def test_an_unknown_direction_is_refused(followed: xr.Dataset) -> None:
    changed = followed.assign_coords(direction=["left", "down"])
    with pytest.raises(PointError, match="the direction 'left' is not one of up, down"):
        point_of(changed, omega=38.0, direction="left")


def test_a_direction_that_was_dropped_is_refused(followed: xr.Dataset) -> None:
    with pytest.raises(PointError, match="the direction along angular_frequency was dropped"):
        point_of(followed.isel(direction=1, drop=True), omega=38.0)


def test_a_config_may_leave_out_the_model(ds: xr.Dataset) -> None:
    point = point_of(ds.assign_attrs(config="integrator: {rtol: 1e-4}\n"), T=250, gamma=0)
    assert point.where.startswith("temperature = 250 K")


def test_a_trajectory_has_no_points_of_a_result(ds: xr.Dataset) -> None:
    course = point_of(ds, T=200, gamma=0).simulate()
    with pytest.raises(PointError, match=messages.NO_RESULT):
        point_of(course)


def test_versions_that_may_change_the_bits_are_listed(ds: xr.Dataset) -> None:
    software = "Python 3.1, numpy 9.0, numba 0.1.2, llvmlite 0.3.4, xarray 9.0"
    another = ds.assign_attrs(numerics_version="1", processor="8086", software=software)
    version, processor, compiler = point_of(another, T=200, gamma=0).versions
    assert version.startswith("the file has numerics version 1, this program ")
    assert processor.startswith("the file was computed on 8086, this machine has ")
    assert compiler.startswith(
        "the file was computed with numba 0.1.2 and llvmlite 0.3.4, this program uses numba "
    )
    other = str(ds.software).replace("xarray", "xarray 1, formerly")
    assert point_of(ds.assign_attrs(software=other), T=200, gamma=0).versions == ()
    assert point_of(ds, T=200, gamma=0).versions == ()


@pytest.mark.slow
def test_fifty_points_of_the_cube_have_the_bits_of_the_file(tmp_path: Path) -> None:
    axes = {
        "temperature": {"linspace": [150, 320], "num": 6},
        "viscosity_coefficient": {"geomspace": [1e4, 2e5], "num": 3},
        "spring_stiffness": [1000, 3000, 9000],
        "rheological_index": [-2 / 3, 0, 2 / 3],
        "angular_frequency": [7, 15, 31],
    }
    run(LOOSE | {"sweep": axes}, output=tmp_path / "cube.nc")
    cube, rng = open_result(tmp_path / "cube.nc"), np.random.default_rng(5)
    for _ in range(50):
        place = {dim: int(rng.integers(size)) for dim, size in cube.sizes.items()}
        assert point_of(cube.isel(place)).differences() == {}
