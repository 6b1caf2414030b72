"""The elastic strain as an independent variable, Eq. 23, and its adiabatic limit, Eq. 24."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from support import reference
from support.marks import marked
from support.points import orbits
from support.symmetries import SYMMETRIES, expected, transformed

from stickslip import Parameters, Status, simulate, stationary_orbit
from stickslip.options import OptionError, Options
from stickslip.orbit import Orbit, compute_orbits

TIGHT = 1e-12


def slow_film(tau: float, k: float = 5e4, **more: float) -> Parameters:
    """Return a film whose thickness grows with the relaxation time, at the same viscous stress.

    `k` is the viscosity coefficient of a film of the paper's thickness.
    """
    h, p = 0.1 * tau, Parameters(**more)
    k *= (h / p.film_thickness) ** (p.rheological_index + 1.0)
    return p._replace(film_thickness=h, strain_relaxation_time=tau, viscosity_coefficient=k)


@cache
def orbit(p: Parameters, strain: str, rtol: float = TIGHT) -> Orbit:
    return stationary_orbit(p, strain=strain, rtol=rtol)


def change(p: Parameters) -> tuple[float, float]:
    """Return the relative changes of the amplitudes of stress and force from Eq. 24 to Eq. 23."""
    before, after = orbit(p, "adiabatic"), orbit(p, "relaxing")
    assert before.status == after.status == Status.OK
    return (
        after.elastic_stress_amplitude / before.elastic_stress_amplitude - 1.0,
        after.friction_force_amplitude / before.friction_force_amplitude - 1.0,
    )


# --- the amplitudes ------------------------------------------------------------------------------


def test_at_the_papers_parameters_the_adiabatic_limit_is_excellent() -> None:
    stress, force = change(Parameters())
    assert stress == pytest.approx(-2.6e-8, rel=0.05)
    assert abs(force) < 1e-8


@pytest.mark.parametrize(
    ("changes", "stress", "force"),
    [
        ((1e-4, 1e-3, 2320794.4168), 4.3010956e6, 2.8168948e-3),
        *marked("stress", [((1e-3, 1e-2, 5e6), 4.2971086e6, 2.8495199e-3)]),
    ],
)
def test_a_thick_film_that_relaxes_slowly(
    changes: tuple[float, ...], stress: float, force: float
) -> None:
    names = ("film_thickness", "strain_relaxation_time", "viscosity_coefficient")
    found = orbit(Parameters(**dict(zip(names, changes, strict=True))), "relaxing")
    # The values are from another solver.
    assert found.elastic_stress_amplitude == pytest.approx(stress, rel=1e-6)
    assert found.friction_force_amplitude == pytest.approx(force, rel=1e-6)


@pytest.mark.stress
def test_the_stress_differs_in_proportion_to_the_relaxation_time() -> None:
    times = np.array([1e-8, 1e-7, 1e-6, 1e-5])
    differences = np.array([change(slow_film(tau))[0] for tau in times.tolist()])
    assert np.all(differences < 0.0)
    slope = np.polyfit(np.log(times), np.log(-differences), 1)[0]
    assert slope == pytest.approx(1.0, abs=0.05)
    assert change(slow_film(1e-4))[0] > 10.0 * differences[-1]  # it grows more slowly beyond


@pytest.mark.parametrize(
    ("gamma", "k"), [(-2 / 3, 5e4), *marked("stress", [(-0.5, 5e3), (0.0, 300.0), (2 / 3, 0.5)])]
)
def test_the_stated_error_holds(gamma: float, k: float) -> None:
    points = np.array(
        [
            slow_film(tau, k, rheological_index=gamma, temperature=T, angular_frequency=omega)
            for tau in (1e-6, 1e-3)
            for T in (180.0, 230.0, 260.0)
            for omega in (7.0, 12.0, 20.0)
        ]
    )
    found, exact = (orbits(points, strain="relaxing", rtol=rtol) for rtol in (1e-6, 1e-10))
    assert np.all(found.status == Status.OK)
    full = 2.0 * Parameters().spring_stiffness * Parameters().drive_amplitude
    area = Parameters().contact_area
    for name, least in (("elastic_stress", 0.01 * full / area), ("friction_force", 0.01 * full)):
        value, true = (getattr(orbit, f"{name}_amplitude") for orbit in (found, exact))
        assert np.all(abs(value - true) <= found.amplitude_error * np.maximum(true, least))


# --- the integrators -----------------------------------------------------------------------------

SLOW = slow_film(1e-3)


def test_the_trajectory_agrees_with_the_independent_twin() -> None:
    ds = simulate(SLOW, periods=1, samples_per_period=50, strain="relaxing", rtol=1e-9)
    found = reference.trajectory(SLOW, ds.elapsed_time.values, rtol=1e-8, relaxing=True)
    X_m, V_m = SLOW.drive_amplitude, SLOW.drive_amplitude * SLOW.angular_frequency
    scale = V_m * SLOW.strain_relaxation_time / SLOW.film_thickness
    for name, column, size in (
        ("lower_displacement", 0, X_m),
        ("lower_velocity", 1, V_m),
        ("elastic_strain", 3, scale),
    ):
        np.testing.assert_allclose(ds[name], found[:, column], rtol=0, atol=2e-5 * size)
    np.testing.assert_allclose(np.log(ds.order_parameter), found[:, 2], rtol=0, atol=1e-3)


def test_scalar_and_lanes_agree() -> None:
    found = orbit(SLOW, "relaxing", 1e-9)
    ds = simulate(
        SLOW, periods=1, start=found.state, samples_per_period=200_000, strain="relaxing", rtol=1e-9
    )
    for name in ("elastic_stress", "friction_force"):
        half = 0.5 * float(ds[name].max() - ds[name].min())
        assert getattr(found, f"{name}_amplitude") == pytest.approx(half, rel=1e-7)
    end = [float(ds[name][-1]) for name in ("lower_displacement", "lower_velocity")]
    V_m = SLOW.drive_amplitude * SLOW.angular_frequency
    np.testing.assert_allclose(end, found.state[:2], rtol=0, atol=1e-7 * V_m)
    assert float(ds.elastic_strain[-1]) == pytest.approx(found.state[3], rel=1e-6)


@pytest.mark.parametrize("name", SYMMETRIES)
def test_symmetries_hold_bit_for_bit(name: str) -> None:
    symmetry = SYMMETRIES[name]
    p = SLOW._replace(initial_displacement=3e-7, initial_velocity=-2e-6)
    points = np.array([p, transformed(p, symmetry)])
    (row, other), (final, other_final) = compute_orbits(points, Options(strain="relaxing"))
    np.testing.assert_array_equal(other, expected(row, symmetry), strict=True)
    motion, strain = symmetry.motion, math.copysign(1.0, symmetry.motion)
    np.testing.assert_array_equal(other_final, final * [motion, motion, 1.0, strain, 1.0])


def test_it_starts_with_the_strain_of_the_adiabatic_limit() -> None:
    p = SLOW._replace(initial_velocity=-2e-6)
    ds = simulate(p, periods=1, samples_per_period=10, strain="relaxing")
    expected_strain = 2e-6 * p.strain_relaxation_time / p.film_thickness  # the drive is at rest
    assert float(ds.elastic_strain[0]) == pytest.approx(expected_strain, rel=1e-12)


# --- energy --------------------------------------------------------------------------------------


def test_the_film_gives_energy_back_and_the_power_balances() -> None:
    slow = slow_film(1e-2)
    found = orbit(slow, "relaxing", 1e-6)
    assert found.power_balance_error < 1e-5
    ds = simulate(slow, periods=1, start=found.state, strain="relaxing")
    power = ds.friction_force * (ds.upper_velocity - ds.lower_velocity)
    assert float(power.min()) < -0.01 * float(power.max())


def test_elastic_power_is_stored_or_lost() -> None:
    # The terms come from the samples of a trajectory over part of a period.
    p = slow_film(0.1)
    ds = simulate(p, periods=1, samples_per_period=100_000, strain="relaxing", rtol=1e-9)
    energy = p.elastic_coefficient * (ds.order_parameter * ds.elastic_strain).values ** 2 / 2
    begin, end = sorted((10_000 + int(energy[10_000:].argmin()), int(energy.argmax())))
    part = slice(begin, end + 1)
    ds, energy = ds.isel(elapsed_time=part), energy[part]
    t, u = ds.elapsed_time.values, (ds.upper_velocity - ds.lower_velocity).values
    lost = (
        2.0 * energy * (1.0 / p.strain_relaxation_time - np.gradient(np.log(ds.order_parameter), t))
    )
    total = np.trapezoid(ds.elastic_stress.values * u, t) / p.film_thickness
    gained = energy[-1] - energy[0]
    assert np.trapezoid(lost, t) + gained == pytest.approx(total, rel=1e-4)
    assert abs(gained) > 0.05 * abs(total)


# --- options -------------------------------------------------------------------------------------


def test_euler_cromer_refuses_a_relaxing_strain() -> None:
    with pytest.raises(OptionError, match="strain 'relaxing' needs the method adaptive"):
        Options(method="euler-cromer", strain="relaxing")


def test_a_start_without_the_strain_is_refused() -> None:
    with pytest.raises(ValueError, match="ln phi, strain"):
        simulate(SLOW, start=(0.0, 0.0, -1.0), strain="relaxing")
