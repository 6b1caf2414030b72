"""The observables that experiments report, against independent integrators and closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.marks import marked
from support.points import MISSED_STICKS, orbits, row

from stickslip import Parameters, Status, simulate, stationary_orbit
from stickslip.variables import RESULT_COLUMNS

OBSERVABLES = [
    RESULT_COLUMNS.index(f"friction_force_{name}")
    for name in ("in_phase", "out_of_phase", "rms", "mean_abs")
]

# From LSODA on the same equations, settled to 1e-9 of X_m; all digits are significant.
MEASURED: dict[float, dict[str, tuple[float, float]]] = {
    200.0: {
        "dissipated_energy": (3.343224e-9, 1e-15),
        "friction_force_in_phase": (-6.865e-6, 1e-9),
        "friction_force_out_of_phase": (1.330227e-3, 1e-9),
        "friction_force_rms": (1.2120125e-3, 1e-10),
        "friction_force_mean_abs": (9.200383e-4, 1e-10),
    },
    250.0: {
        "dissipated_energy": (1.828701e-9, 1e-15),
        "friction_force_in_phase": (8.018315e-5, 1e-11),
        "friction_force_out_of_phase": (7.276171e-4, 1e-10),
        "friction_force_mean_abs": (5.131182e-4, 1e-10),
    },
}


@pytest.mark.parametrize("temperature", MEASURED)
def test_they_agree_with_independent_integrators(temperature: float) -> None:
    p = Parameters(temperature=temperature)
    orbit = stationary_orbit(p, rtol=1e-10)
    for name, (value, last_digit) in MEASURED[temperature].items():
        assert getattr(orbit, name) == pytest.approx(value, abs=0.51 * last_digit), name


def sums_over(p: Parameters, periods: int) -> dict[str, float]:
    """Return the observables of an orbit from sums over equidistant samples."""
    course = simulate(p, periods=periods, start="stationary", samples_per_period=20_000)
    F, t = course.friction_force.values[:-1], course.elapsed_time.values[:-1]
    phase, sign = p.angular_frequency * t, math.copysign(1.0, p.drive_amplitude)
    return {
        "friction_force_in_phase": 2.0 * sign * np.mean(F * np.cos(phase)),
        "friction_force_out_of_phase": -2.0 * sign * np.mean(F * np.sin(phase)),
        "friction_force_rms": np.sqrt(np.mean(F * F)),
        "friction_force_mean_abs": np.mean(np.abs(F)),
    }


CASES: dict[str, dict[str, Any]] = {
    "mirror image": {"temperature": 250.0, "drive_amplitude": -0.8e-6},
    "asymmetric": {"temperature": 228.0},
    "several periods": {
        "temperature": 172.2, "viscosity_coefficient": 14781.0, "spring_stiffness": 1839.0,
        "angular_frequency": 34.96,
    },
    "no film": {"elastic_coefficient": 0.0},
}  # fmt: skip


HARMONICS = {"temperature": 250.0, "third_harmonic": 0.2, "fifth_harmonic": -0.05}


@pytest.mark.parametrize(
    "changes", [*CASES.values(), *marked("stress", [HARMONICS])], ids=[*CASES, "harmonics"]
)
def test_they_are_integrals_over_the_time_courses(changes: dict[str, float]) -> None:
    p = Parameters(**changes)
    orbit = stationary_orbit(p)
    assert orbit.status == Status.OK
    for name, value in sums_over(p, orbit.orbit_periods).items():
        tolerance = 1e-4 * orbit.friction_force_rms
        assert getattr(orbit, name) == pytest.approx(value, abs=tolerance), name


@pytest.mark.parametrize("changes", CASES.values(), ids=CASES)
def test_a_cosine_dissipates_by_the_force_in_phase_with_its_velocity(
    changes: dict[str, float],
) -> None:
    p = Parameters(**changes)
    orbit, way = stationary_orbit(p), math.pi * abs(p.drive_amplitude)
    work = way * orbit.friction_force_out_of_phase
    assert orbit.dissipated_energy == pytest.approx(work, rel=1e-14)
    error = way * orbit.friction_force_out_of_phase_error
    assert orbit.dissipated_energy_error == pytest.approx(error, rel=1e-14)
    assert 0.0 < error < 1e-4 * work


@pytest.mark.parametrize(
    "changes", [*CASES.values(), *marked("stress", [HARMONICS])], ids=[*CASES, "harmonics"]
)
def test_the_loss_of_a_closed_orbit_equals_the_work_of_the_drive(changes: dict[str, float]) -> None:
    p = Parameters(**changes)
    orbit = stationary_orbit(p)
    course = simulate(p, periods=orbit.orbit_periods, start="stationary", samples_per_period=20_000)
    F, V = course.friction_force.values[:-1], course.upper_velocity.values[:-1]
    period = 2.0 * math.pi / p.angular_frequency
    work, flow = (period * np.mean(power) for power in (F * V, abs(F * V)))
    assert orbit.dissipated_energy == pytest.approx(work, abs=1e-4 * flow)


# --- by every method ----------------------------------------------------------------------------

POINTS = np.array([row(**changes) for changes in CASES.values()])
STOCHASTIC = {"noise": "stochastic", "realizations": 3, "window": 20, "rtol": 1e-4}
FIXED = {"method": "euler-cromer", "dt": 2e-5, "stationary_rtol": 1e-4}
WAYS: dict[str, tuple[np.ndarray, dict[str, Any]]] = {
    "adaptive": (POINTS, {}),
    "euler-cromer": (POINTS[-1:], FIXED),
    "stochastic": (row(**MISSED_STICKS)[None], STOCHASTIC),
}


@pytest.mark.parametrize(
    "way",
    ["adaptive", *marked("stress", ["euler-cromer", "stochastic"])],  # they need other kernels
)
def test_every_method_computes_them(way: str) -> None:
    points, options = WAYS[way]
    found = orbits(points, **options)
    assert np.isfinite(found.row[:, OBSERVABLES]).all()
    # The largest force is above the root mean square, and this is above the mean.
    force = np.maximum(found.friction_force_max, -found.friction_force_min)
    assert (found.friction_force_mean_abs < found.friction_force_rms).all()
    assert (found.friction_force_rms < force).all()


@pytest.mark.stress
def test_means_over_a_window_scatter_by_no_more_than_documented() -> None:
    chaotic = {
        "temperature": 205.9, "viscosity_coefficient": 22802.0, "spring_stiffness": 2349.9,
        "angular_frequency": 35.874,
    }  # fmt: skip
    points = np.array([row(**chaotic, initial_displacement=1e-9 * i) for i in range(16)])
    found = orbits(points)
    assert (found.status == Status.APERIODIC).all()
    allowed = 1.5 * np.mean(found.amplitude_error) / 3.0
    for name in ("friction_force_rms", "friction_force_mean_abs"):
        assert getattr(found, name).std(ddof=1) < allowed * found.friction_force_rms.mean()
    for name in ("dissipated_energy", "friction_force_in_phase", "friction_force_out_of_phase"):
        scatter = getattr(found, name).std(ddof=1)
        error = np.mean(getattr(found, f"{name}_error")) / 3.0
        assert scatter < 1.5 * error, name


@pytest.mark.slow
def test_both_methods_agree() -> None:
    exact, errors = orbits(POINTS[-1:], rtol=1e-9), []
    for dt in (4e-5, 2e-5):
        fixed = orbits(POINTS[-1:], **FIXED | {"dt": dt})
        differences = fixed.row[0, OBSERVABLES] - exact.row[0, OBSERVABLES]
        misses = abs(differences) / exact.friction_force_rms
        errors.append(misses.max())
    assert errors[1] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
