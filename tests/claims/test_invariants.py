"""Laws for every orbit, whatever its parameters: power balance, bounds, symmetry in time."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from support.marks import one_then
from support.points import FIG_7, FIG_8, FIG_9, GAMMAS, curve, orbits, rows

from stickslip import Parameters, Status, simulate
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS

COUNTS = ("orbit_periods", "melting_count", "solid_transition_count")


@pytest.mark.slow
@pytest.mark.parametrize("gamma", GAMMAS)
@pytest.mark.parametrize("figure", [FIG_7, FIG_8, FIG_9], ids=lambda figure: figure[0])
def test_power_balances_on_every_point_of_the_figures(
    figure: tuple[str, tuple[float, ...]], gamma: float
) -> None:
    found = curve(figure, gamma)
    assert np.all(found.status == Status.OK)
    assert np.all(found.power_balance_error < 1e-4)
    assert np.all(found.amplitude_error < 5e-4)


SCENES: dict[str, dict[str, float]] = {
    "fig3": {},
    "asymmetric": {"angular_frequency": 38.0},
    "frequency 32": {"angular_frequency": 32.0},
    "newtonian": {"rheological_index": 0.0, "temperature": 250.0},
    "dilatant": {"rheological_index": 2 / 3},
    "general power": {"rheological_index": -0.4, "temperature": 220.0},
    "liquid": {"temperature": 305.0},
    "starts beyond the bound": {"initial_order_parameter": 1.0},
    "second order": {"cubic_coefficient": 0.0},
}


@cache
def trajectory(scene: str) -> xr.Dataset:
    return simulate(Parameters(**SCENES[scene]), periods=3, samples_per_period=4000)


@pytest.mark.parametrize("scene", SCENES)
def test_friction_always_dissipates(scene: str) -> None:
    ds = trajectory(scene)
    assert float((ds.friction_force * (ds.upper_velocity - ds.lower_velocity)).min()) >= 0.0


@pytest.mark.parametrize("scene", SCENES)
def test_the_order_parameter_stays_positive_and_below_its_bound(scene: str) -> None:
    p = Parameters(**SCENES[scene])
    phi = trajectory(scene).order_parameter.values
    half = p.cubic_coefficient / (2 * p.quartic_coefficient)
    heating = 2 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    bound = half + np.sqrt(max(half**2 - heating / p.quartic_coefficient, 0.0))
    assert np.all(phi > 0)
    assert np.max(phi) <= max(bound, p.initial_order_parameter) * 1.001
    if scene == "fig3":
        assert np.max(phi) > 0.99 * bound == pytest.approx(0.99 * 0.603782, rel=1e-6)


@pytest.mark.parametrize("scene", SCENES)
def test_energy_is_conserved_along_a_trajectory(scene: str) -> None:
    # The work of friction on the block is the gained energy, by the trapezoidal rule on samples.
    p, ds = Parameters(**SCENES[scene]), trajectory(scene)
    power = (ds.friction_force * ds.lower_velocity).values
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]))]) * float(
        ds.elapsed_time[1]
    )
    energy = 0.5 * p.block_mass * ds.lower_velocity.values**2
    energy = energy + p.spring_stiffness * ds.lower_displacement.values**2
    assert np.max(np.abs(work - (energy - energy[0]))) < 2e-3 * np.max(energy)


@pytest.mark.parametrize(
    "scene", one_then("stress", ["fig3", "frequency 32", "newtonian", "general power"])
)
def test_symmetric_orbits_repeat_mirrored_after_half_a_period(scene: str) -> None:
    p = Parameters(**SCENES[scene])
    assert orbits(np.array(p)).asymmetry[0] < 1e-6
    ds = simulate(p, periods=1, start="stationary", samples_per_period=2000, rtol=1e-8)
    for name, scale in (
        ("lower_displacement", p.drive_amplitude),
        ("lower_velocity", p.drive_amplitude * p.angular_frequency),
    ):
        values = ds[name].values / scale
        np.testing.assert_allclose(values[1000:], -values[:1001], rtol=0, atol=1e-5)
    phi = np.log(ds.order_parameter.values)
    np.testing.assert_allclose(phi[1000:], phi[:1001], rtol=0, atol=2e-3)


def test_without_a_cubic_term_the_transition_is_continuous() -> None:
    # In a second-order transition the order parameter falls to 0 like sqrt(T_c - T) without a jump,
    # and the motion near T_c does not depend on whether the film started solid.
    temperatures = np.linspace(280.0, 290.0, 21)
    scene = {"cubic_coefficient": 0.0, "rheological_index": 2 / 3}
    rest, solid = (
        orbits(rows("temperature", temperatures, **scene, initial_order_parameter=phi_0))
        for phi_0 in (0.0, 0.6)
    )
    stress = rest.elastic_stress_amplitude
    np.testing.assert_allclose(
        stress, solid.elastic_stress_amplitude, rtol=0, atol=1e-3 * stress[0]
    )
    assert np.all(np.diff(stress) < 0)
    assert np.max(-np.diff(stress)) < 0.1 * stress[0]
    assert stress[-1] < 1.0


# --- any valid parameters -------------------------------------------------------------------------

NEAR_THE_PAPER = st.fixed_dictionaries(
    {
        "temperature": st.floats(100.0, 330.0),
        "viscosity_coefficient": st.floats(1e3, 5e5),
        "spring_stiffness": st.floats(300.0, 2e4),
        "rheological_index": st.one_of(st.sampled_from(GAMMAS), st.floats(-0.95, 1.5)),
        "angular_frequency": st.floats(2.0, 300.0),
        "drive_amplitude": st.floats(0.2e-6, 3e-6),
        "block_mass": st.floats(0.05, 4.0),
        "initial_displacement": st.floats(-1e-6, 1e-6),
        "initial_velocity": st.floats(-1e-5, 1e-5),
        "initial_order_parameter": st.floats(0.0, 2.0),
        "kinetic_coefficient": st.floats(10.0, 1e3),
    }
)


@settings(max_examples=15)
@given(changes=NEAR_THE_PAPER)
def test_an_orbit_is_ok_with_its_invariants_or_says_why_not(changes: dict[str, float]) -> None:
    p = Parameters(**changes)
    row = orbits(np.array(p), max_steps=300_000, max_periods=500).row[0]
    found = dict(zip(RESULT_COLUMNS, row.tolist(), strict=True))
    status = Status(int(found.pop("status")))
    if not status.is_result:
        assert status in (Status.NOT_STATIONARY, Status.STEP_LIMIT)
        del found["periods_integrated"]
        assert [found.pop(name) for name in COUNTS] == [-1] * len(COUNTS)
        assert found.pop("regime") == Regime.UNKNOWN
        assert all(np.isnan(value) for value in found.values())
        return
    if status is Status.OK:
        assert np.isnan(found.pop("lyapunov_exponent"))
    else:
        assert np.isnan(found.pop("floquet_multiplier"))
    assert all(np.isfinite(value) for value in found.values()), found
    assert found["power_balance_error"] <= 1e-2
    assert found["orbit_periods"] in (range(1, 33) if status is Status.OK else [0])
    assert found["melting_count"] >= 0
    assert found["periods_integrated"] >= found["orbit_periods"] + 1
    for name in ("elastic_stress", "friction_force"):
        half = 0.5 * (found[f"{name}_max"] - found[f"{name}_min"])
        size = max(abs(found[f"{name}_max"]), abs(found[f"{name}_min"]))
        assert half >= 0
        if status is Status.OK:
            assert found[f"{name}_amplitude"] == pytest.approx(half, rel=0, abs=1e-15 * size)
        else:  # a mean over single periods, where max and min belong to the whole window
            assert found[f"{name}_amplitude"] <= half * (1 + 1e-9)
        assert found[f"{name}_max"] >= found[f"{name}_min"]
    # Friction is never below its elastic part.
    assert found["friction_force_max"] >= p.contact_area * found["elastic_stress_max"] * (1 - 1e-9)
    assert 0 <= found["asymmetry"] <= 1 + 1e-9
