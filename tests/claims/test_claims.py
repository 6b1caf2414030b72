"""What the paper claims, figure by figure, on computed data (the claims of docs/equations.md)."""

from __future__ import annotations

import math
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from support.points import FIG_7, FIG_8, FIG_9, GAMMAS, LOCKED, curve, orbits, row, rows

from stickslip import Parameters, Status, simulate, stationary_orbit

X_M = 0.8e-6
SOLID = 230.0 / (2 * 850.0)
"""b/2c: the film is solid from this order parameter, melted below a tenth of it."""

STUCK_SPEED = 1e-9 * 6.8293e-6 / 1e-8
"""h eps_c0/tau [m/s]: the melting strain at 200 K as a relative speed."""

CONSTANT_FORCE = 0.002
"""Forces are called constant, or equal, within 0.2 %."""

CONSTANT_STRESS = 0.005
"""The stress of gamma = -2/3 in Fig. 8 is called constant within 0.5 %."""


def spread(values: np.ndarray) -> float:
    return float(np.ptp(values) / np.max(values))


def falls(values: np.ndarray) -> bool:
    return bool(np.all(np.diff(values) < 0))


def rises(values: np.ndarray) -> bool:
    return bool(np.all(np.diff(values) > 0))


# --- Figs. 3 and 4: the time courses --------------------------------------------------------------


@cache
def fig_3() -> xr.Dataset:
    """A stationary period at 200 K and 10 rad/s, rolled to begin with a solidification."""
    ds = simulate(periods=1, start="stationary", samples_per_period=20_000, rtol=1e-8)
    ds = ds.isel(time=slice(None, -1))  # the last sample is the first one again
    start = next(s for s in runs(ds.order_parameter.values >= SOLID) if s.start > 0).start
    return ds.roll(time=-start, roll_coords=False)


def relative_velocity(ds: xr.Dataset) -> np.ndarray:
    return (ds.upper_velocity - ds.lower_velocity).values


def runs(mask: np.ndarray) -> list[slice]:
    """The stretches over which a mask holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [slice(i, j) for i, j in zip(edges[::2], edges[1::2], strict=True)]


def sticks() -> list[slice]:
    """From solidification until the strain passes the melting strain."""
    ds = fig_3()
    solid = runs(ds.order_parameter.values >= SOLID)
    speed = np.abs(relative_velocity(ds))
    ends = [s.start + int(np.argmax(speed[s] > STUCK_SPEED)) for s in solid]
    return [slice(s.start, end) for s, end in zip(solid, ends, strict=True)]


def test_fig_3_sticks_four_times_a_period_two_in_each_direction() -> None:
    stress = fig_3().elastic_stress.values
    peaks = [stress[s][np.argmax(np.abs(stress[s]))] for s in sticks()]
    assert sorted(np.sign(peaks)) == [-1, -1, 1, 1]
    np.testing.assert_allclose(np.abs(peaks), 4.3048e6, rtol=0.01)


def test_fig_3_has_four_meltings_a_period_and_is_symmetric() -> None:
    orbit = stationary_orbit(rtol=1e-8)
    assert (orbit.melting_count, orbit.orbit_periods) == (4, 1)
    assert orbit.asymmetry < 1e-6


def test_fig_4_blocks_that_stick_move_slower_than_the_melting_strain_allows() -> None:
    speed = np.abs(relative_velocity(fig_3()))
    phi = fig_3().order_parameter.values
    for solid, stick in zip(runs(phi >= SOLID), sticks(), strict=True):
        assert np.all(speed[stick] < STUCK_SPEED)
        # Beyond that strain the film melts at once: in less than 1 % of the time that it stuck.
        assert solid.stop - stick.stop < 0.01 * (stick.stop - stick.start)
    assert max(speed) > 40 * STUCK_SPEED  # ... and the slip is another matter


def test_fig_4_the_distance_of_the_blocks_is_constant_while_they_stick() -> None:
    # A solid film creeps like a dashpot, F >= A a phi^2 (tau/h) u: a mean force of 1 mN on
    # phi_plus = 0.6 over the longest stick of 0.15 s makes 17 nm, 2 % of X_m.
    ds = fig_3()
    distance = (ds.upper_displacement - ds.lower_displacement).values
    travelled = [np.ptp(ds.upper_displacement.values[s]) for s in sticks()]
    for stick in sticks():
        assert np.ptp(distance[stick]) < 0.02 * X_M
    assert min(travelled) > 0.5 * X_M  # not because nothing moved
    assert np.ptp(distance) > X_M


def test_fig_4_the_creep_of_a_stuck_block_is_that_of_a_dashpot() -> None:
    ds = fig_3()
    distance = (ds.upper_displacement - ds.lower_displacement).values
    dt = float(ds.time[1] - ds.time[0])
    mobility = 1e-9 / (0.6e-9 * 4e12 * 1e-8)
    bound = mobility * np.abs(ds.friction_force.values) / ds.order_parameter.values**2 * dt
    for stick in sticks():
        assert np.ptp(distance[stick]) <= bound[stick].sum() * 1.001


def test_fig_3_the_elastic_stress_drops_to_zero_at_each_melting() -> None:
    ds = fig_3()
    melted = runs(ds.order_parameter.values <= 0.1 * SOLID)
    assert len(melted) == 4
    for liquid in melted:
        stress = np.abs(ds.elastic_stress.values[liquid])
        assert np.median(stress) < 1e-6 * 4.3e6  # stays there ...
        assert np.argmax(stress < 1e-3 * 4.3e6) < 0.05 * len(stress)  # ... at once


# --- Fig. 5: phase portraits ----------------------------------------------------------------------

FIG_5 = {10.0: 4, 15.0: 2, 32.0: 2, 38.0: 1}
"""Drive frequencies and meltings a period."""


def fig_5(omega: float, **start: float) -> SimpleNamespace:
    found = orbits(row(angular_frequency=omega, **start))
    assert found.status == Status.OK
    return found


@pytest.mark.parametrize(("omega", "meltings"), FIG_5.items())
def test_fig_5_meltings_a_period(omega: float, meltings: int) -> None:
    found = fig_5(omega)
    assert (found.orbit_periods, found.melting_count) == (1, meltings)


@pytest.mark.parametrize("omega", FIG_5)
def test_fig_5_symmetric_at_10_and_32_asymmetric_at_15_and_38(omega: float) -> None:
    ds = simulate(
        Parameters(angular_frequency=omega),
        periods=1,
        start="stationary",
        samples_per_period=4000,
        rtol=1e-8,
    )
    x, v = ds.lower_displacement.values / X_M, ds.lower_velocity.values / (X_M * omega)
    half = 2000
    tilt = max(np.max(np.abs(y[half:] + y[: half + 1])) for y in (x, v))
    if omega in (10.0, 32.0):
        assert fig_5(omega).asymmetry < 1e-6
        assert tilt < 1e-5
    else:
        assert fig_5(omega).asymmetry > 0.4
        assert tilt > 0.1


def test_fig_5_a_start_in_the_solid_makes_the_orbit_at_38_symmetric() -> None:
    solid = fig_5(38.0, initial_order_parameter=0.6)
    for phi_0 in (0.01, 0.6):
        found = fig_5(38.0, initial_order_parameter=phi_0)
        assert found.asymmetry < 1e-6
        assert found.melting_count == fig_5(32.0).melting_count == 2
        np.testing.assert_allclose(
            found.elastic_stress_amplitude, solid.elastic_stress_amplitude, rtol=5e-6
        )


def test_fig_5_a_start_at_1e_6_is_forgotten() -> None:
    rest, small = fig_5(38.0), fig_5(38.0, initial_order_parameter=1e-6)
    assert small.asymmetry > 0.99
    assert small.melting_count == 1
    np.testing.assert_allclose(
        small.elastic_stress_amplitude, rest.elastic_stress_amplitude, rtol=5e-6
    )


# --- Fig. 6: four temperatures --------------------------------------------------------------------


def test_fig_6_stress_and_force_fall_from_section_to_section() -> None:
    found = orbits(rows("temperature", [200.0, 220.0, 250.0, 300.0]))
    assert falls(found.elastic_stress_amplitude)
    assert falls(found.friction_force_amplitude)
    assert found.melting_count.tolist() == [4, 4, 2, 0]


def test_fig_6_at_300_K_the_film_is_liquid_throughout() -> None:
    ds = simulate(Parameters(temperature=300.0), periods=2, start="stationary")
    assert float(ds.order_parameter.max()) < 1e-9
    assert float(np.abs(ds.elastic_stress).max()) < 1e-6


def test_fig_6_heating_a_running_film_melts_it() -> None:
    # The sections of the figure are one run: each starts where the one before has ended.
    state: dict[str, float] = {}
    peaks = []
    for temperature in (200.0, 220.0, 250.0, 300.0):
        ds = simulate(Parameters(temperature=temperature, **state), periods=4)
        last = ds.isel(time=-1)
        state = {
            "initial_displacement": float(last.lower_displacement),
            "initial_velocity": float(last.lower_velocity),
            "initial_order_parameter": float(last.order_parameter),
        }
        peaks.append(float(np.abs(ds.elastic_stress[-4000:]).max()))
    assert falls(np.array(peaks))
    assert peaks[-1] < 1.0


# --- Fig. 7: amplitudes against temperature -------------------------------------------------------

LIQUID_STRESS = 1.0
"""Below this amplitude [Pa] a film counts as liquid throughout: a solid one has 1e4 to 1e7 Pa."""


def fig_7(gamma: float) -> SimpleNamespace:
    return curve(FIG_7, gamma)


def peak(found: SimpleNamespace, quantity: str) -> np.ndarray:
    """The larger of the two extremes."""
    return np.maximum(getattr(found, f"{quantity}_max"), -getattr(found, f"{quantity}_min"))


def solid_part(found: SimpleNamespace) -> np.ndarray:
    return found.elastic_stress_amplitude > LIQUID_STRESS


@pytest.mark.slow
# And in the long tests a fluid between those of the figure.
@pytest.mark.parametrize("gamma", [*LOCKED, pytest.param(1 / 3, marks=pytest.mark.stress)])
def test_fig_7_stress_falls_with_temperature(gamma: float) -> None:
    found = fig_7(gamma)
    assert np.all(found.status == Status.OK)
    assert falls(found.elastic_stress_amplitude[solid_part(found)])
    assert np.all(np.diff(solid_part(found).astype(int)) <= 0)  # once liquid, liquid


@pytest.mark.slow
def test_fig_7_stress_and_force_peaks_fall_with_temperature_for_the_pseudoplastic() -> None:
    found = fig_7(-2 / 3)
    solid = solid_part(found)
    assert np.all(found.status == Status.OK)
    assert np.all(np.diff(solid.astype(int)) <= 0)
    assert falls(peak(found, "elastic_stress")[solid])
    assert falls(peak(found, "friction_force")[solid])


@pytest.mark.slow
def test_fig_7_amplitudes_of_the_pseudoplastic_fall_wherever_its_orbit_is_symmetric() -> None:
    # At 228 and 229 K the start from rest leads to an asymmetric orbit of three meltings, whose
    # second stick in one direction does not come about: maximum and minimum differ, and half of
    # their difference is a third lower than on both sides of that island.
    found = fig_7(-2 / 3)
    symmetric = found.asymmetry < 1e-3
    assert found.x[~symmetric].tolist() == [228.0]
    assert found.melting_count[~symmetric].tolist() == [3]
    part = solid_part(found) & symmetric
    assert falls(found.elastic_stress_amplitude[part])
    assert falls(found.friction_force_amplitude[part])


@pytest.mark.slow
def test_fig_7_the_pseudoplastic_has_the_largest_stress_while_it_is_solid() -> None:
    largest = fig_7(-2 / 3)
    part = largest.x <= 283.0
    for gamma in LOCKED:
        other = fig_7(gamma).elastic_stress_amplitude
        assert np.all(largest.elastic_stress_amplitude[part] > other[part])


@pytest.mark.slow
def test_fig_7_the_pseudoplastic_melts_at_the_lowest_temperature() -> None:
    melting = {gamma: fig_7(gamma).x[~solid_part(fig_7(gamma))].min() for gamma in GAMMAS}
    assert 284.0 < melting[-2 / 3] <= 286.0
    assert melting[0.0] == melting[2 / 3] == 290.0  # from rest the film is liquid above T_c


@pytest.mark.slow
def test_fig_7_the_force_of_the_pseudoplastic_ends_on_a_plateau() -> None:
    found = fig_7(-2 / 3)
    plateau = found.friction_force_amplitude[~solid_part(found)]
    assert spread(plateau) < CONSTANT_FORCE
    # The fall ends there, not below.
    assert np.all(found.friction_force_amplitude > plateau[0] * (1 - CONSTANT_FORCE))
    assert found.friction_force_amplitude[0] > 7 * plateau[0]


@pytest.mark.slow
def test_fig_7_the_force_is_constant_and_equal_for_the_others() -> None:
    newtonian, dilatant = (fig_7(gamma).friction_force_amplitude for gamma in LOCKED)
    assert spread(newtonian) < CONSTANT_FORCE
    assert spread(dilatant) < CONSTANT_FORCE
    assert np.all(np.abs(newtonian / dilatant - 1) < CONSTANT_FORCE)


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
def test_fig_7_the_force_is_smallest_for_the_pseudoplastic(gamma: float) -> None:
    smallest = fig_7(-2 / 3).friction_force_amplitude
    assert np.all(smallest < fig_7(gamma).friction_force_amplitude)


# --- Fig. 8: amplitudes against the viscosity coefficient -----------------------------------------


def fig_8(gamma: float) -> SimpleNamespace:
    return curve(FIG_8, gamma)


@pytest.mark.slow
def test_fig_8_stress_is_constant_for_the_pseudoplastic_and_falls_for_the_others() -> None:
    assert spread(fig_8(-2 / 3).elastic_stress_amplitude) < CONSTANT_STRESS
    for gamma in LOCKED:
        assert falls(fig_8(gamma).elastic_stress_amplitude)
        assert spread(fig_8(gamma).elastic_stress_amplitude) > 0.5


@pytest.mark.slow
def test_fig_8_force_grows_for_the_pseudoplastic_and_is_constant_for_the_others() -> None:
    assert rises(fig_8(-2 / 3).friction_force_amplitude)
    assert spread(fig_8(-2 / 3).friction_force_amplitude) > 0.2
    for gamma in LOCKED:
        assert np.all(fig_8(gamma).status == Status.OK)
        assert spread(fig_8(gamma).friction_force_amplitude) < CONSTANT_FORCE


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
def test_fig_8_force_is_smallest_for_the_pseudoplastic(gamma: float) -> None:
    smallest = fig_8(-2 / 3).friction_force_amplitude
    assert np.all(smallest < fig_8(gamma).friction_force_amplitude)


# --- Fig. 9: amplitudes against the spring stiffness ----------------------------------------------


def fig_9(gamma: float) -> SimpleNamespace:
    return curve(FIG_9, gamma)


def steepness(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """d ln y/d ln x between neighbours: 1 for a proportional growth."""
    return np.diff(np.log(y)) / np.diff(np.log(x))


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
def test_fig_9_stress_grows_slowly_for_the_locked_blocks(gamma: float) -> None:
    # Slowly: hardly faster than K itself, and without the jump of the pseudoplastic.
    found = fig_9(gamma)
    assert rises(found.elastic_stress_amplitude)
    assert np.max(steepness(found.x, found.elastic_stress_amplitude)) < 1.2


@pytest.mark.slow
def test_fig_9_stress_jumps_up_and_then_stays_for_the_pseudoplastic() -> None:
    found = fig_9(-2 / 3)
    steep = steepness(found.x, found.elastic_stress_amplitude) > 2.0
    # Two neighbouring jumps: between them lie asymmetric orbits of a single slip a period.
    assert found.x[1:][steep].tolist() == [1100.0, 1200.0]
    before, after = found.x <= 1000.0, found.x >= 1200.0
    assert rises(found.elastic_stress_amplitude[before])
    assert np.max(found.elastic_stress_amplitude[before]) < 0.6 * np.min(
        found.elastic_stress_amplitude[after]
    )
    assert spread(found.elastic_stress_amplitude[after]) < 0.01


@pytest.mark.slow
def test_fig_9_force_is_linear_in_the_stiffness_and_equal_for_the_locked_blocks() -> None:
    newtonian, dilatant = (fig_9(gamma) for gamma in LOCKED)
    for found in (newtonian, dilatant):
        line = (2 * found.x - 0.4 * 10.0**2) * X_M
        assert np.all(found.status == Status.OK)
        assert np.all(np.abs(found.friction_force_amplitude / line - 1) < CONSTANT_FORCE)
    ratio = newtonian.friction_force_amplitude / dilatant.friction_force_amplitude
    assert np.all(np.abs(ratio - 1) < CONSTANT_FORCE)


@pytest.mark.slow
def test_fig_9_force_grows_and_saturates_for_the_pseudoplastic() -> None:
    found = fig_9(-2 / 3)
    force = found.friction_force_amplitude
    assert np.all(found.status == Status.OK)
    assert rises(force[found.x <= 1000.0])
    saturated = force[found.x >= 1200.0]
    assert spread(saturated) < 0.01  # while K grows eightfold
    assert np.min(saturated) > 1.7 * np.max(force[found.x <= 1000.0])


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
def test_fig_9_force_is_smallest_for_the_pseudoplastic_but_where_it_slips_early(
    gamma: float,
) -> None:
    # A start from rest slips between K = 1100 and the knee near 1770 N/m, where a locked block
    # would still need less force.
    smallest, other = fig_9(-2 / 3), fig_9(gamma)
    excess = smallest.friction_force_amplitude / other.friction_force_amplitude - 1
    early = (smallest.x >= 1100.0) & (smallest.x < 1770.0)
    assert np.all(excess[early] > 0)
    # At K = 100 N/m locked blocks differ by 1e-6, less than the offset that decays so slowly there
    # leaves at the default settings; the stated errors cover it.
    resolved = smallest.x >= 200.0
    assert np.all(excess[~early & resolved] < 0)
    assert np.all(excess[~resolved] < (smallest.amplitude_error + other.amplitude_error)[~resolved])
    assert np.all(excess[smallest.x > 1770.0] < -0.01)


def test_fig_9_a_start_from_rest_slips_where_a_matched_one_is_locked() -> None:
    matched = {"initial_displacement": X_M, "initial_order_parameter": 0.6}
    rest = orbits(row(spring_stiffness=1500.0))
    locked = orbits(row(spring_stiffness=1500.0, **matched))
    assert (rest.melting_count, locked.melting_count) == (2, 0)
    assert math.isclose(locked.friction_force_amplitude[0], (2 * 1500 - 40) * X_M, rel_tol=1e-3)
