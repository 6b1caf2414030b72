"""Trajectories: the Dataset, its sampling, its starts and its errors."""

from __future__ import annotations

import math
import pickle
import re
import subprocess
import sys
import textwrap
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from support import reference
from support.marks import one_then
from support.points import SUBHARMONIC
from support.sweeps.processes import HANGS

from stickslip import (
    IntegrationError,
    NoiseError,
    Parameters,
    Status,
    simulate,
    stationary_orbit,
)
from stickslip.kernels.streams import streams_of
from stickslip.options import METHODS, Options
from stickslip.variables import PARAMETERS, TRAJECTORY

X_M = 0.8e-6


@pytest.fixture(scope="module")
def fig_3() -> xr.Dataset:
    return simulate(periods=2, samples_per_period=500)


# --- the Dataset ----------------------------------------------------------------------------------


def test_the_dataset_has_the_variables_of_the_registry(fig_3: xr.Dataset) -> None:
    assert {"elapsed_time", *map(str, fig_3.data_vars)} == set(TRAJECTORY)
    assert dict(fig_3.sizes) == {"elapsed_time": 1001}
    for name, variable in TRAJECTORY.items():
        assert fig_3[name].dims == ("elapsed_time",)
        assert fig_3[name].dtype == np.float64
        assert fig_3[name].attrs["units"] == variable.units
        assert fig_3[name].attrs["symbol"] == variable.symbol
        assert fig_3[name].attrs["long_name"] == variable.meaning


def test_the_parameters_are_scalar_coordinates() -> None:
    p = Parameters(temperature=250.0, rheological_index=0.0)
    ds = simulate(p, periods=1, samples_per_period=2)
    assert set(map(str, ds.coords)) == {"elapsed_time", *PARAMETERS}
    for name, variable in PARAMETERS.items():
        assert ds[name].ndim == 0
        assert float(ds[name]) == getattr(p, name)
        assert ds[name].attrs["units"] == variable.units
        assert ds[name].attrs.get("comment", "") == variable.comment


def test_the_observables_follow_from_the_states(fig_3: xr.Dataset) -> None:
    t, p = fig_3.elapsed_time.values, Parameters()
    np.testing.assert_allclose(fig_3.upper_displacement, X_M * np.cos(10 * t), atol=1e-20)
    np.testing.assert_allclose(fig_3.upper_velocity, -X_M * 10 * np.sin(10 * t), atol=1e-20)
    u = (fig_3.upper_velocity - fig_3.lower_velocity).values
    np.testing.assert_allclose(fig_3.elastic_strain, u * 10.0, rtol=1e-12)
    stress = 4e12 * fig_3.order_parameter.values**2 * fig_3.elastic_strain.values
    np.testing.assert_allclose(fig_3.elastic_stress, stress, rtol=1e-12)
    # The law that was integrated: its cusp is rounded at 1e-2 rtol X_m omega.
    rate, rounding = u / 1e-9, 1e-8 * X_M * 10 / 1e-9
    viscous = 5e4 * rate / np.cbrt(rate**2 + rounding**2)
    np.testing.assert_allclose(fig_3.viscous_stress, viscous, rtol=1e-12)
    force = p.contact_area * (fig_3.elastic_stress + fig_3.viscous_stress)
    np.testing.assert_allclose(fig_3.friction_force, force, rtol=1e-12)


# --- sampling -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("periods", "per_period"), [(1, 1), (1, 7), (3, 1), (2, 500)])
def test_samples_are_equidistant_and_hold_both_ends(periods: int, per_period: int) -> None:
    p = Parameters(initial_displacement=2e-7, initial_velocity=1e-6, initial_order_parameter=0.3)
    ds = simulate(p, periods=periods, samples_per_period=per_period)
    period = 2 * math.pi / 10
    expected = np.linspace(0.0, periods * period, periods * per_period + 1)
    np.testing.assert_allclose(ds.elapsed_time, expected, rtol=1e-14)
    first = ds.isel(elapsed_time=0)
    assert float(first.lower_displacement) == 2e-7
    assert float(first.lower_velocity) == 1e-6
    assert float(first.order_parameter) == pytest.approx(0.3, rel=1e-15)
    assert np.all(np.isfinite(ds.to_dataframe()[list(TRAJECTORY)[1:]]))


@pytest.mark.parametrize("method", METHODS)
def test_sampling_does_not_change_the_motion(method: str) -> None:
    p = Parameters(elastic_coefficient=0.0)
    options = {"periods": 3, "method": method, "dt": 2e-5}
    dense, sparse = (simulate(p, samples_per_period=n, **options) for n in (640, 10))
    every = dense.isel(elapsed_time=slice(None, None, 64))
    for name in ("lower_displacement", "lower_velocity", "order_parameter"):
        ends = slice(None, None, 10)  # whole periods: no interpolation
        np.testing.assert_array_equal(sparse[name][ends], every[name][ends])
        np.testing.assert_allclose(sparse[name], every[name], rtol=1e-9, atol=1e-18)


def test_more_periods_continue_the_same_motion() -> None:
    short, long = (simulate(periods=n, samples_per_period=50) for n in (2, 5))
    head = long.isel(elapsed_time=slice(0, 101))
    np.testing.assert_array_equal(head.lower_displacement, short.lower_displacement)


# --- starts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "closes_after"),
    [
        ({}, 1),
        ({"angular_frequency": 38.0}, 1),
        ({"rheological_index": 2 / 3}, 1),
        (SUBHARMONIC, 2),
    ],
)
def test_a_stationary_start_closes_on_itself(changes: dict[str, float], closes_after: int) -> None:
    p = Parameters(**changes)
    assert stationary_orbit(p, rtol=1e-8).orbit_periods == closes_after
    ds = simulate(p, periods=2 * closes_after, start="stationary", samples_per_period=1, rtol=1e-8)
    x = ds.lower_displacement.values / X_M
    v = ds.lower_velocity.values / (X_M * p.angular_frequency)
    for motion in (x, v):
        np.testing.assert_allclose(motion[closes_after:], motion[:-closes_after], rtol=0, atol=1e-7)
    log_phi = np.log(ds.order_parameter.values)
    np.testing.assert_allclose(log_phi[closes_after:], log_phi[:-closes_after], rtol=0, atol=1e-4)
    if closes_after > 1:
        assert np.max(np.abs(x[1:] - x[:-1])) > 0.05


def test_a_start_from_rest_does_not_close() -> None:
    x = simulate(Parameters(rheological_index=0.0), periods=1).lower_displacement.values
    assert abs(x[-1] - x[0]) > 0.01 * X_M


@pytest.mark.parametrize("start", ["rest", "off the cusp", "solid", "newtonian"])
def test_a_tight_trajectory_agrees_with_the_slow_twin(start: str) -> None:
    # From rest V = v at t = 0. For gamma < 0 this is the cusp of the viscous force, where linearly
    # implicit steps can freeze the velocity although their error estimate is small.
    changes = {
        "rest": {},
        "off the cusp": {"initial_velocity": 1e-7},
        "solid": {"initial_order_parameter": 0.6},
        "newtonian": {"rheological_index": 0.0},
    }[start]
    p = Parameters(angular_frequency=38.0, **changes)
    end = 2 * math.pi / 38.0 / 4
    times = np.array([0.0, 0.5 * end, end])
    exact = reference.trajectory(p, times, "LSODA", rtol=1e-12)
    # Eight samples a period: numbers 1 and 2 are an eighth and a quarter of it.
    ds = simulate(p, periods=1, samples_per_period=8, rtol=1e-10)
    x = (ds.lower_displacement.values[1:3] - exact[1:, 0]) / X_M
    v = (ds.lower_velocity.values[1:3] - exact[1:, 1]) / (X_M * 38.0)
    assert np.max(np.abs(x)) < 5e-8
    assert np.max(np.abs(v)) < 5e-8


# --- schedules ------------------------------------------------------------------------------------

STEPS = {"temperature": [200.0, 250.0], "angular_frequency": [10.0, 20.0]}


@pytest.mark.parametrize("method", METHODS)
def test_a_section_begins_where_the_one_before_ended(method: str) -> None:
    shorter = {"periods": 2, "samples_per_period": 40, "method": method, "dt": 2e-5}
    liquid = Parameters(elastic_coefficient=0.0)
    both = simulate(liquid, schedule=STEPS, **shorter)
    first = simulate(liquid, **shorter)
    np.testing.assert_array_equal(both.lower_velocity[:81], first.lower_velocity)
    end = first.isel(elapsed_time=-1)
    start = {
        "initial_displacement": float(end.lower_displacement),
        "initial_velocity": float(end.lower_velocity),
        "initial_order_parameter": float(end.order_parameter),
    }
    p = liquid._replace(temperature=250.0, angular_frequency=20.0, **start)
    second = simulate(p, **shorter).isel(elapsed_time=slice(1, None))
    for name in list(TRAJECTORY)[1:]:
        found, alone = both[name].values[81:], second[name].values
        np.testing.assert_allclose(found, alone, rtol=1e-9, atol=1e-12 * np.abs(alone).max())
    np.testing.assert_allclose(
        both.elapsed_time[81:], second.elapsed_time + float(end.elapsed_time), rtol=1e-14
    )
    assert np.all(np.diff(both.elapsed_time) > 0)


def test_scheduled_parameters_lie_along_the_time() -> None:
    ds = simulate(schedule=STEPS, periods=1, samples_per_period=4)
    assert ds.temperature.values.tolist() == [200.0] * 5 + [250.0] * 4
    assert ds.angular_frequency.values.tolist() == [10.0] * 5 + [20.0] * 4
    assert ds.temperature.attrs == PARAMETERS["temperature"].attributes
    assert ds.spring_stiffness.ndim == 0


def test_a_step_that_is_unstable_in_a_later_section_is_refused_at_once() -> None:
    with pytest.raises(IntegrationError, match="above the largest stable step"):
        simulate(
            Parameters(elastic_coefficient=0.0),
            schedule={"kinetic_coefficient": [100.0, 1e9]},
            method="euler-cromer",
            dt=2e-5,
        )


# --- errors ---------------------------------------------------------------------------------------


VISCOUS = {"parameters": Parameters(elastic_coefficient=0.0), "dt": 2e-5, "max_steps": 10}
TOO_LONG = r"dt = 1e-07 s is above the largest stable step 1\.3e-8 s\. "


@pytest.mark.parametrize(
    ("arguments", "status", "context"),
    [
        ({"method": "euler-cromer", "dt": 1e-7, "periods": 1}, Status.REFUSED, TOO_LONG),
        ({"start": "stationary", "max_periods": 2}, Status.NOT_STATIONARY, "No stationary start: "),
        *((VISCOUS | {"method": method}, Status.STEP_LIMIT, "") for method in METHODS),
        ({"parameters": Parameters(initial_velocity=1e200)}, Status.DIVERGED, ""),
    ],
)
def test_a_run_that_fails_is_an_error_with_its_status(
    arguments: dict, status: Status, context: str
) -> None:
    message = f"^{context}{re.escape(status.sentence)}$"
    with pytest.raises(IntegrationError, match=message) as caught:
        simulate(**arguments)
    assert caught.value.status is status


def test_a_film_that_could_never_solidify_is_an_error() -> None:
    with pytest.raises(NoiseError):
        simulate(noise="none")
    ds = simulate(Parameters(initial_order_parameter=0.6), noise="none", periods=1)
    assert float(ds.order_parameter.min()) < 1e-30  # melted, and unable to solidify


@pytest.mark.parametrize("run", [{"periods": 1}, {"drive": 2e-6, "duration": 0.01}])
def test_without_noise_phi_0_does_not_matter_if_the_start_is_a_state(run: dict[str, Any]) -> None:
    without = {"noise": "none", "samples_per_period": 50, "samples": 50} | run
    solid = Parameters(initial_order_parameter=0.6)
    with pytest.raises(NoiseError):
        simulate(**without)
    given = simulate(start=[0.0, 0.0, math.log(0.6)], **without)
    assert given.equals(simulate(solid, **without).assign_coords(initial_order_parameter=0.0))
    if "periods" in run:  # the search for the stationary orbit starts at phi_0
        with pytest.raises(NoiseError):
            simulate(start="stationary", **without)


def test_noise_may_end_along_a_run_but_not_begin() -> None:
    solid, shorter = Parameters(temperature=200.0), {"periods": 1, "samples_per_period": 50}
    ds = simulate(solid, schedule={"noise_intensity": [1e-18, 0.0]}, **shorter)
    first = simulate(solid, **shorter)
    np.testing.assert_array_equal(ds.order_parameter[:51], first.order_parameter)
    assert float(ds.order_parameter[51]) > 0.5  # solid as before, though phi_0 = 0
    with pytest.raises(NoiseError):
        simulate(solid, schedule={"noise_intensity": [0.0, 1e-18]}, **shorter)


def test_a_section_that_would_continue_from_a_lost_state_is_refused_with_the_reason() -> None:
    melted = Parameters(initial_order_parameter=0.6, temperature=250.0)
    run: dict[str, Any] = {"periods": 1, "samples_per_period": 50, "noise": "none"}
    assert float(simulate(melted, **run).order_parameter[-1]) == 0.0  # the last section may
    with pytest.raises(NoiseError, match=r"^section 2 of the schedule begins at phi = 0") as caught:
        simulate(melted, schedule={"temperature": [250.0, 150.0]}, **run)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    # Euler-Cromer integrates phi itself, of which 0 is a value like others.
    run |= {"method": "euler-cromer", "dt": 4e-8}
    ds = simulate(melted, schedule={"temperature": [250.0, 250.0]}, **run)
    assert (ds.order_parameter[50:] == 0.0).all()


def test_noise_lifts_a_film_from_any_depth_as_from_just_below_its_level() -> None:
    solid = Parameters(temperature=200.0)
    near, deep = (simulate(solid, periods=1, start=[0.0, 0.0, log_phi]) for log_phi in (-31, -700))
    assert 0.0 < float(deep.order_parameter[0]) < float(near.order_parameter[0])
    assert math.isclose(deep.order_parameter[-1], near.order_parameter[-1], rel_tol=1e-6)
    pulled = simulate(solid, start=[0.0, 0.0, -700.0], drive=1e-6, duration=1.0)
    assert np.isfinite(pulled.order_parameter).all()
    # So does noise that begins after a film has melted without it.
    melted = Parameters(initial_order_parameter=0.6)
    changes = {"noise_intensity": [0.0, 1e-18], "temperature": [300.0, 200.0]}
    ds = simulate(melted, schedule=changes, periods=2)
    assert float(ds.order_parameter[ds.sizes["elapsed_time"] // 2]) == 0.0
    assert float(ds.order_parameter[-1]) > 0.5


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"periods": 0}, "at least 1"),
        ({"periods": -1}, "at least 1"),
        ({"samples_per_period": 0}, "at least 1"),
        ({"drive": 2e-6, "duration": 1.0, "samples": 0}, "samples must be at least 1"),
        ({"drive": 2e-6, "duration": 1.0, "samples": -1}, "samples must be at least 1"),
        ({"start": "somewhere"}, "start must be one of"),
        ({"start": [0.0, 0.0]}, "start must be one of"),
        ({"start": ["a", "b", "c"]}, "start must be one of"),
        ({"schedule": {"temperature": [200.0, 250.0], "X_m": [1e-6]}}, "temperature 2, drive"),
        ({"schedule": {"temperature": []}}, "the same number of values, but have: temperature 0"),
        ({"schedule": {"initial_velocity": [0.0]}}, "initial_velocity cannot be scheduled"),
        ({"schedule": {"temperature": [200.0, -1.0]}}, "temperature must be at least 0"),
    ],
)
def test_invalid_arguments_are_refused_with_a_reason(wrong: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulate(**wrong)


@pytest.mark.parametrize("schedule", [pd.DataFrame({"T": [200.0]}), [200.0], {"T": 200.0}])
def test_a_schedule_that_is_no_mapping_to_lists_is_refused(schedule: Any) -> None:
    with pytest.raises(TypeError, match="schedule must map parameters to lists of values"):
        simulate(schedule=schedule)


# --- stochastic films -----------------------------------------------------------------------------

CHANCE = {"noise": "stochastic", "samples_per_period": 100, "periods": 2}


def test_a_stochastic_film_has_a_path_for_each_realization() -> None:
    ds = simulate(**CHANCE, realizations=3)
    assert dict(ds.sizes) == {"realization": 3, "elapsed_time": 201}
    assert len(np.unique(ds.order_parameter[:, -1])) == 3
    assert (ds.order_parameter > 1e-20).all()  # never below the noise, also between steps
    xr.testing.assert_identical(ds.isel(realization=[0]), simulate(**CHANCE))
    assert not simulate(**CHANCE, seed=2).order_parameter.equals(simulate(**CHANCE).order_parameter)


def test_random_numbers_continue_from_section_to_section() -> None:
    once = simulate(**CHANCE | {"periods": 2})
    twice = simulate(**CHANCE | {"periods": 1}, schedule={"temperature": [200.0, 200.0]})
    # Each section begins with a short step, so that the paths differ, but not their statistics.
    assert twice.sizes == once.sizes
    np.testing.assert_allclose(twice.lower_displacement, once.lower_displacement, atol=1e-3 * X_M)
    film = twice.order_parameter[0]
    assert film[50] != film[150]  # other numbers, though the parameters are the same


def test_paths_of_euler_cromer_agree_with_its_lanes() -> None:
    p = Parameters(
        angular_frequency=2e3, drive_amplitude=8e-9, temperature=250.0, initial_order_parameter=0.6,
        noise_intensity=1e-4,
    )  # fmt: skip
    steps = 32 * 20_000
    dt = 2.0 * math.pi / 2e3 / steps * (1.0 + 1e-12)
    options = Options(noise="stochastic", realizations=2, method="euler-cromer", dt=dt)
    start = np.array([[0.0, 0.0, math.log(0.6), 1.0]])
    points = np.array([p])
    walk = METHODS["euler-cromer"].kernels.stochastic_walk(
        np.repeat(points, 2, axis=0), np.repeat(start, 2, axis=0), streams_of(points, options),
        options,
    )  # fmt: skip
    paths = simulate(
        p, periods=2, samples_per_period=1, noise="stochastic", realizations=2, dt=dt,
        method="euler-cromer",
    )  # fmt: skip
    for period in (1, 2):
        walk.next_period()
        np.testing.assert_allclose(
            np.exp(walk.states()[:, 2]), paths.order_parameter[:, period], rtol=1e-7
        )
    assert abs(paths.order_parameter[0, 2] / paths.order_parameter[1, 2] - 1.0) > 1e-5


@pytest.mark.parametrize(
    "short_and_long",
    one_then(
        "stress",
        [
            "simulate(periods={}, samples_per_period=1)",
            "simulate(periods={}, samples_per_period=1, method='euler-cromer', dt=1e-8)",
            "simulate(drive=2e-6, duration={}, samples=1)",
        ],
    ),
)
def test_ctrl_c_does_not_wait_for_a_long_run(short_and_long: str) -> None:
    # An alarm that is handled as Ctrl-C is comes while compiled code runs.
    script = f"""
        import signal
        from stickslip import simulate

        {short_and_long.format(1)}
        signal.signal(signal.SIGALRM, signal.default_int_handler)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        try:
            {short_and_long.format(10**6)}
        except KeyboardInterrupt:
            print("interrupted")
    """
    command = [sys.executable, "-c", textwrap.dedent(script)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=HANGS, check=False)
    assert done.stdout == "interrupted\n", done.stderr
