"""Odd harmonics of the drive agree with other integrators and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from support import reference
from support.marches import FAST_DT, fast, period
from support.points import error_scales

from stickslip import Parameters, Status, simulate, stationary_orbit

# Such drives have kernels of their own. The suite compares their lanes with the scalar twin, in
# tests/kernels/test_every_parameter.py.
pytestmark = pytest.mark.stress

PULSED = {"third_harmonic": -0.3, "fifth_harmonic": 0.2}


@pytest.mark.parametrize(
    ("third_harmonic", "stress", "force"),
    [(0.0, 1.857461e6, 1.321672e-3), (-0.05, 1.857979e6, 1.322031e-3)],
)
def test_amplitudes_agree_with_other_integrators(
    third_harmonic: float, stress: float, force: float
) -> None:
    # The values are from LSODA and Radau, to the digits given.
    orbit = stationary_orbit(Parameters(temperature=250, third_harmonic=third_harmonic), rtol=1e-8)
    assert orbit.elastic_stress_amplitude == pytest.approx(stress, abs=0.51)
    assert orbit.friction_force_amplitude == pytest.approx(force, abs=0.51e-9)


def test_the_work_of_a_period_agrees_with_another_integrator() -> None:
    p = Parameters(temperature=250.0, third_harmonic=-0.05)
    ds = simulate(p, periods=1, start="stationary", samples_per_period=40_000, rtol=1e-8)
    power = (ds.friction_force * ds.upper_velocity).values[:-1]  # of a whole period without its end
    work = power.sum() * float(ds.elapsed_time[1])
    assert work == pytest.approx(1.783744e-9, abs=0.6e-15)


@pytest.mark.parametrize("changes", [{"spring_stiffness": 100.0}, {"rheological_index": 2 / 3}])
def test_the_force_of_a_locked_block_balances_springs_and_inertia(
    changes: dict[str, float],
) -> None:
    p = Parameters(temperature=150.0, viscosity_coefficient=1e7, **changes, **PULSED)
    phase = np.linspace(0.0, 2.0 * np.pi, 100_001)
    force = np.zeros(len(phase))
    for n, part in ((1, 1.0), (3, p.third_harmonic), (5, p.fifth_harmonic)):
        inertia = p.block_mass * (n * p.angular_frequency) ** 2
        force += (2.0 * p.spring_stiffness - inertia) * part * np.cos(n * phase)
    exact = 0.5 * np.ptp(force) * p.drive_amplitude
    orbit = stationary_orbit(p)
    assert orbit.status is Status.OK
    floor = float(error_scales(np.array([p]))[1][0])
    assert abs(orbit.friction_force_amplitude - exact) <= 1e-5 * max(exact, floor)


def test_a_strong_harmonic_settles_like_any_drive() -> None:
    # Errors and distances are relative to the speed of the drive, here 31 times X_m omega.
    p = Parameters(temperature=250.0, drive_amplitude=2e-8, third_harmonic=10.0)
    orbit, exact = stationary_orbit(p), stationary_orbit(p, rtol=1e-9)
    assert orbit.status is exact.status is Status.OK
    off = abs(orbit.friction_force_amplitude / exact.friction_force_amplitude - 1.0)
    assert off <= max(orbit.amplitude_error, 1e-12) <= 1e-5


def test_trajectories_agree_with_the_twin() -> None:
    p = Parameters(temperature=250.0, **PULSED)
    ds = simulate(p, periods=1, samples_per_period=20, rtol=1e-8).isel(elapsed_time=slice(6))
    twin = reference.trajectory(p, ds.elapsed_time.values, rtol=1e-8)
    off = np.abs(ds.lower_displacement.values - twin[:, 0])
    assert off.max() <= 1e-5 * p.drive_amplitude


@pytest.mark.parametrize("strain", ["adiabatic", "relaxing"])
def test_a_start_on_the_orbit_stays_there(strain: str) -> None:
    p = Parameters(temperature=250.0, **PULSED)
    orbit = stationary_orbit(p, strain=strain)
    ds = simulate(p, periods=1, start=orbit.state, samples_per_period=100_000, strain=strain)
    half = 0.5 * np.ptp(ds.friction_force.values)
    assert half == pytest.approx(orbit.friction_force_amplitude, rel=1e-5)


def test_euler_cromer_is_of_order_one_with_harmonics() -> None:
    p, steps = fast(**PULSED), (1.0, 0.5, 0.25)
    ends = [period([p], part * FAST_DT)[0][0] for part in steps]
    first, second = (np.abs(ends[i + 1] - ends[i]) for i in range(2))
    assert np.log2(first[:2] / second[:2]) == pytest.approx([1.0, 1.0], abs=0.2)
