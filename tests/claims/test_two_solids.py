"""The motion of films with a soft and a hard solid, against an independent solver and counts."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from support import reference
from support.marks import one_then
from support.points import TWO_SOLIDS

from stickslip import Parameters, Regime, Status, simulate, stationary_orbit

FLUIDS = (-2 / 3, 0.0, 0.3, 2 / 3)


def film(**changes: float) -> Parameters:
    return Parameters(**TWO_SOLIDS | changes)


@pytest.mark.parametrize("gamma", one_then("stress", FLUIDS))
def test_a_trajectory_agrees_with_an_independent_solver(gamma: float) -> None:
    p = film(rheological_index=gamma, viscosity_coefficient=5e4 if gamma < 0 else 10.0)
    ds = simulate(p, periods=1, samples_per_period=50, rtol=1e-9)
    states = reference.trajectory(p, ds.elapsed_time.values, method="LSODA", rtol=1e-10)
    off = np.abs(ds.lower_displacement.values - states[:, 0]).max() / abs(p.drive_amplitude)
    assert off < 1e-5
    np.testing.assert_allclose(ds.order_parameter.values[-1], math.exp(states[-1, 2]), rtol=1e-3)


@pytest.mark.stress
@pytest.mark.parametrize("gamma", FLUIDS)
def test_an_orbit_agrees_with_a_trajectory_along_it(gamma: float) -> None:
    p = film(rheological_index=gamma, viscosity_coefficient=5e4 if gamma < 0 else 10.0)
    orbit = stationary_orbit(p)
    assert orbit.status is Status.OK
    ds = simulate(p, periods=orbit.orbit_periods, start=orbit.state, samples_per_period=20_000)
    for name in ("elastic_stress", "friction_force"):
        high, low = float(ds[name].max()), float(ds[name].min())
        amplitude = getattr(orbit, f"{name}_amplitude")
        sampled = 0.5 * (high - low)  # samples miss the very peak of a spike
        assert 0.99 * amplitude < sampled < (1.0 + 1e-5) * amplitude
    assert orbit.solid_transition_count == transitions(ds, p)


def transitions(ds: xr.Dataset, p: Parameters) -> int:
    """Count the changes between the solids along a closed orbit, where each state has a phase.

    The phases follow from the order parameters at which the balance of these films turns, and from
    the values of the melting function between which a soft solid exists.
    """
    phi, eps = ds.order_parameter.values, ds.elastic_strain.values
    B = 4e12 * eps**2 + 2 * 0.95 * (p.temperature - 290.0)
    soft = (phi >= 0.12) & (phi <= 0.4) & (B > 3.067) & (B < 11.482)
    kinds = np.select([phi >= 0.5, soft, phi <= 0.012], [3, 2, 1], default=0)
    seen = kinds[kinds > 0]
    before = np.roll(seen, 1)
    return int(np.count_nonzero((seen != before) & (seen > 1) & (before > 1)))


@pytest.mark.stress
def test_under_a_slow_strain_the_film_melts_in_two_steps() -> None:
    # Stiff springs hold the block, so the strain follows the drive, slowly for the film.
    p = film(spring_stiffness=1e9, drive_amplitude=7.2e-8, initial_order_parameter=0.85)
    orbit = stationary_orbit(p)
    assert (orbit.melting_count, orbit.solid_transition_count) == (2, 2)  # twice a period
    ds = simulate(p, periods=1, start=orbit.state, samples_per_period=20_000)
    assert transitions(ds, p) == 2
    gentle = stationary_orbit(p._replace(drive_amplitude=6.68e-8))
    assert (gentle.melting_count, gentle.solid_transition_count) == (0, 4)  # back and forth
    paper = stationary_orbit(film())  # it melts in one step
    assert (paper.melting_count, paper.solid_transition_count) == (1, 0)


@pytest.mark.stress
def test_euler_cromer_agrees() -> None:
    light = film(
        angular_frequency=2e4, drive_amplitude=1e-11, contact_area=6e-13, block_mass=1e-5,
        spring_stiffness=6e4, initial_order_parameter=0.6,
    )  # fmt: skip
    fine = stationary_orbit(light, rtol=1e-8)
    steps = stationary_orbit(light, method="euler-cromer", dt=2e-9, rtol=1e-5)
    assert steps.status is Status.OK
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        difference = abs(getattr(steps, name) / getattr(fine, name) - 1.0)
        assert difference <= steps.amplitude_error
        assert difference < 1e-2


def test_a_film_that_freezes_without_a_barrier_into_a_soft_solid_is_solid_there() -> None:
    """Without a cubic term the balance turns at phi = 0.2 and 0.6: the soft solid ends at 0.2."""
    e, soft, hard = 2000.0, 0.2, 0.6
    energy = {"b": 0.0, "c": 2 * e * soft * hard, "d": 4 / 3 * e * (soft + hard), "e": e}
    p = Parameters(**energy, T=288.0, k=5e3, X_m=1e-8)
    orbit = stationary_orbit(p)
    phi = simulate(p, start=orbit.state, samples_per_period=4000).order_parameter.values
    assert phi.max() < soft
    assert orbit.melting_count == 2
    # It freezes at half the order parameter at rest, and melts at a tenth of that.
    assert np.mean(phi > 0.5 * phi.max()) < orbit.solid_fraction < np.mean(phi > 0.05 * phi.max())
    stiff = stationary_orbit(p._replace(viscosity_coefficient=5e4))
    assert (stiff.regime, stiff.solid_fraction) == (Regime.LOCKED, pytest.approx(1.0))


def test_a_film_that_temperature_does_not_freeze_is_liquid() -> None:
    orbit = stationary_orbit(Parameters(alpha=0.0, b=0.0))
    assert (orbit.regime, orbit.solid_fraction) == (Regime.LIQUID, 0.0)
