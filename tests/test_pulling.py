"""Pulls of the upper block: their slips, their course, and the options that they exclude."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from support import reference
from support.marks import one_then

from stickslip import Parameters, simulate
from stickslip.course import PullError, course_of

# By LSODA, from rest: (T, V), duration, seconds between meltings, peak of F.
SLIPS = [(200.0, 2e-6, 2.0, 0.31283, 2.80508e-3), (250.0, 2e-6, 1.0, 0.14479, 1.31533e-3)]


@pytest.mark.parametrize(("T", "V", "duration", "period", "peak"), SLIPS)
def test_slips_agree_with_an_independent_solver(
    T: float, V: float, duration: float, period: float, peak: float
) -> None:
    ds = simulate(Parameters(temperature=T), drive=V, duration=duration, rtol=1e-10)
    assert ds.attrs["motion"] == "stick-slip"
    assert ds.attrs["slip_period"] == pytest.approx(period, abs=5e-6)
    assert ds.attrs["slip_force_max"] == pytest.approx(peak, abs=5e-9)
    # The samples stay below the extrema, but come near them.
    late = ds.elapsed_time > ds.melting_time[1]
    force, spring = ds.friction_force[late], ds.spring_force[late]
    assert 0.99 * peak < force.max() <= ds.slip_force_max.max()
    least = float(ds.spring_force_min[1:].min())
    assert least <= spring.min() <= least + 0.01 * abs(least)
    np.testing.assert_allclose(ds.spring_force, 2 * 3000.0 * ds.lower_displacement)
    mean = force[ds.elapsed_time[late] <= ds.melting_time[-1]].mean()
    assert ds.attrs["slip_force_mean"] == pytest.approx(float(mean), rel=0.01)


def test_a_fast_pull_slides_steadily() -> None:
    ds = simulate(drive=1e-5, duration=1.0, rtol=1e-10)
    assert (ds.attrs["motion"], ds.sizes["melting"]) == ("steady", 0)
    assert ds.attrs["steady_force"] == pytest.approx(6.46330e-4, abs=5e-10)
    assert ds.attrs["steady_force_change"] < 1e-12


TABLE = {"elapsed_time": [0.05, 0.1, 0.15, 0.2], "velocity": [2e-6, -1e-6, 0.0, 4e-6]}
STEPS = {
    "elapsed_time": [0.0, 0.1, 0.1, 0.15, 0.2, 0.2],
    "velocity": [1e-6, 1e-6, 5e-6, 2e-6, -1e-6, 3e-6],
}
# The same pulls as sections: begin, end, and V at both.
OF_TABLE = [
    (0.0, 0.05, 2e-6, 2e-6),
    (0.05, 0.1, 2e-6, -1e-6),
    (0.1, 0.15, -1e-6, 0.0),
    (0.15, 0.2, 0.0, 4e-6),
    (0.2, 0.25, 4e-6, 4e-6),
]
OF_STEPS = [
    (0.0, 0.1, 1e-6, 1e-6),
    (0.1, 0.15, 5e-6, 2e-6),
    (0.15, 0.2, 2e-6, -1e-6),
    (0.2, 0.25, 3e-6, 3e-6),
]


@pytest.mark.parametrize(("table", "sections"), [(TABLE, OF_TABLE), (STEPS, OF_STEPS)])
def test_a_table_is_followed_node_by_node(table: dict, sections: list) -> None:
    """Compared with LSODA, restarted at each node, with independent equations."""
    ds = simulate(drive=pd.DataFrame(table), duration=0.25, samples=50, rtol=1e-9)
    moved = sum(0.5 * (first + last) * (end - begin) for begin, end, first, last in sections)
    assert float(ds.upper_displacement[-1]) == pytest.approx(moved, rel=1e-12)
    p, y = Parameters(), np.array(reference.starting_state(Parameters()))
    for begin, end, first, last in sections:

        def velocity(t: float, at: tuple = (begin, end), V: tuple = (first, last)) -> float:
            return float(np.interp(t, at, V))

        def rates(t: float, y: np.ndarray, velocity: Callable = velocity) -> list[float]:
            # The twin's drive is V = -X_m omega sin(omega t): X_m omega at t = -1, omega = pi/2.
            omega = math.pi / 2
            own = {"drive_amplitude": velocity(t) / omega, "angular_frequency": omega}
            return reference.right_hand_side(-1.0, y, SimpleNamespace(**p._asdict() | own))

        times = ds.elapsed_time.values
        times = times[(times > begin + 1e-12) & (times <= end + 1e-12)].clip(max=end)
        inner = ds.sel(elapsed_time=times[times < end - 1e-12], method="nearest")
        np.testing.assert_allclose(
            inner.upper_velocity, [velocity(t) for t in inner.elapsed_time.values], atol=1e-18
        )
        run = solve_ivp(
            rates, (begin, end), y, "LSODA", times, rtol=1e-10, atol=[1e-18, 1e-16, 1e-9]
        )
        found = ds.sel(elapsed_time=times, method="nearest")
        np.testing.assert_allclose(found.lower_displacement, run.y[0], atol=1e-13)
        np.testing.assert_allclose(found.lower_velocity, run.y[1], atol=1e-11)
        y = run.y[:, -1]


@pytest.mark.parametrize("strain", one_then("stress", ["adiabatic", "relaxing"]))
def test_a_step_is_the_limit_of_a_ramp(strain: str) -> None:
    quick = {"elapsed_time": [0, 0.1, 0.1 + 1e-10, 0.2], "velocity": [1e-6, 1e-6, 5e-6, 5e-6]}
    step = {"elapsed_time": [0, 0.1, 0.1, 0.2], "velocity": [1e-6, 1e-6, 5e-6, 5e-6]}
    runs = [simulate(drive=table, samples=20, strain=strain, rtol=1e-10) for table in (quick, step)]
    for name in ("lower_displacement", "lower_velocity", "order_parameter", "friction_force"):
        ramped, stepped = (run[name].values[11:] for run in runs)  # after the step
        # The impulse of the force in 1e-10 s, and the rounding of times that close, are 1e-6.
        np.testing.assert_allclose(stepped, ramped, rtol=0, atol=1e-5 * np.abs(ramped).max())
    np.testing.assert_array_equal(runs[0].upper_velocity[11:], runs[1].upper_velocity[11:])


def test_a_step_at_the_very_end_is_not_part_of_the_run() -> None:
    late = {"elapsed_time": [0, 2, 2], "velocity": [2e-6, 2e-6, 4e-5]}
    held = {"elapsed_time": [0, 2], "velocity": [2e-6, 2e-6]}
    stepped, plain = (simulate(drive=table, rtol=1e-9) for table in (late, held))
    assert stepped.attrs["settled_slips"] == plain.attrs["settled_slips"] == 3
    assert stepped.attrs["slip_period"] == pytest.approx(plain.attrs["slip_period"], rel=1e-7)


def test_the_error_falls_with_the_tolerance() -> None:
    runs = [simulate(drive=TABLE, samples=40, rtol=10.0**-n) for n in (5, 7, 11)]
    errors = [float(np.abs(run.friction_force - runs[-1].friction_force).max()) for run in runs]
    assert errors[1] < 0.1 * errors[0]
    assert errors[1] < 1e-8


@pytest.mark.parametrize("strain", one_then("stress", ["adiabatic", "relaxing"]))
def test_the_mirror_image_of_a_pull(strain: str) -> None:
    way = {"duration": 0.35, "samples": 20, "strain": strain, "rtol": 1e-8}
    there, back = (simulate(drive=V, **way) for V in (2e-6, -2e-6))
    np.testing.assert_array_equal(there.friction_force, -back.friction_force)
    np.testing.assert_array_equal(there.melting_time, back.melting_time)
    slips = there.attrs["motion"] == "stick-slip"
    high, low = ("slip_force_max", "slip_force_min") if slips else ("steady_force",) * 2
    assert there.attrs[high] == -back.attrs[low]


def test_only_the_last_velocity_counts_for_the_summary() -> None:
    for begin in (0.5, 0.51):  # after a step, or a ramp
        times = [0, 0.5, begin, 1.6]
        ds = simulate(drive={"elapsed_time": times, "velocity": [2e-6, 2e-6, 4e-5, 4e-5]})
        assert ds.sizes["melting"] > 1
        assert ds.attrs["motion"] == "steady"
    held = {
        "elapsed_time": [0, 0.4, 0.41, 0.9, 0.91, 2.5],
        "velocity": [2e-6, 2e-6, 0, 0, 2e-6, 2e-6],
    }
    assert simulate(drive=held).attrs["slip_period"] == pytest.approx(0.31283, rel=1e-3)
    late = {"elapsed_time": [0, 1, 1, 3], "velocity": [1e-5, 1e-5, 2e-5, 2e-5]}
    liquid = simulate(Parameters(temperature=320.0), drive=late)
    assert liquid.attrs["steady_force_change"] < 1e-6 * liquid.attrs["steady_force"]


@pytest.mark.parametrize(
    "pull", [2, np.int64(2), np.float32(2.0), np.array(2.0), xr.DataArray(2.0)]
)
def test_any_number_is_a_constant_velocity(pull: object) -> None:
    course = course_of(pull)  # type: ignore[arg-type]
    assert (course.time.tolist(), course.velocity.tolist()) == ([0.0], [2.0])


@pytest.mark.parametrize(
    ("pull", "message"),
    [
        ("fast", "a velocity in m/s, or a table"),
        (True, "a velocity in m/s, or a table"),
        (np.bool_(True), "a velocity in m/s, or a table"),
        (0.0, "nothing would be pulled"),
        (math.nan, "velocity is nan"),
        ({"velocity": [1e-6]}, "elapsed_time is missing"),
        ({"elapsed_time": [0, 1], "velocity": [1e-6]}, "not 1 and 2"),
        (
            {"elapsed_time": [0, 1, 0.5], "velocity": [1, 1, 1]},
            "row 2: elapsed_time falls from 1 s to 0.5 s",
        ),
        (
            {"elapsed_time": [0, 1, 1, 1], "velocity": [1] * 4},
            "row 3: elapsed_time is 1 s in three",
        ),
        ({"elapsed_time": [-1, 1], "velocity": [1, 1]}, "row 0: elapsed_time is -1 s"),
        ({"elapsed_time": [0, 1], "velocity": [1, math.inf]}, "row 1: velocity is inf"),
        (
            {"elapsed_time": [0, 1], "velocity": np.ma.array([1, 9e36], mask=[0, 1])},
            "must not contain masked val",
        ),
    ],
)
def test_an_invalid_pull_is_refused(pull: object, message: str) -> None:
    with pytest.raises(PullError, match=message):
        course_of(pull)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"drive": 2e-6}, "needs a duration"),
        ({"drive": 2e-6, "duration": -1.0}, "duration must be a time"),
        ({"duration": 1.0}, "duration needs a drive"),
        (
            {"drive": TABLE, "start": "stationary"},
            "needs a periodic drive: a pull has no stationary orbit",
        ),
        ({"drive": TABLE, "schedule": {"temperature": [200.0]}}, "schedule needs a periodic drive"),
        (
            {"drive": TABLE, "method": "euler-cromer", "dt": 1e-7},
            "a pull needs the method 'adaptive'",
        ),
        ({"drive": TABLE, "noise": "stochastic"}, "a pull cannot have stochastic noise"),
    ],
)
def test_options_that_a_pull_excludes_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulate(**arguments)
