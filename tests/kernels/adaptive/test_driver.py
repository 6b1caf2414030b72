"""Orbits in lanes agree with the scalar integrator, whatever the neighbours and the budgets."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.points import GAMMAS, SUBHARMONIC, amplitude_errors, orbits, row

from stickslip import Options, Parameters, Status, simulate
from stickslip.compiled.simd import LANES
from stickslip.kernels.adaptive.passes import TRAVEL, work_through
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import ATTEMPTED, CYCLE, OUTCOME, motions_of
from stickslip.measure.results import STATUS
from stickslip.options import DEFAULTS
from stickslip.orbit import compute_orbits

COUNTS = ("orbit_periods", "melting_count")


@cache
def random_points(
    number: int, seed: int = 20130720, fluids: tuple[float, ...] = (*GAMMAS, np.nan)
) -> np.ndarray:
    """Return points around the paper's, of these fluids in turn; NaN stands for any fluid."""
    rng = np.random.default_rng(seed)
    points = [
        row(
            temperature=rng.uniform(150.0, 310.0),
            viscosity_coefficient=10.0 ** rng.uniform(4.0, 5.3),
            spring_stiffness=10.0 ** rng.uniform(3.0, 4.0),
            rheological_index=rng.uniform(-0.9, 0.9)
            if np.isnan(fluids[i % len(fluids)])
            else fluids[i % len(fluids)],
            angular_frequency=rng.uniform(5.0, 60.0),
            drive_amplitude=rng.choice([-1.0, 1.0]) * rng.uniform(0.4e-6, 1.2e-6),
            initial_order_parameter=rng.choice([0.0, 0.6]),
        )
        for i in range(number)
    ]
    return np.array(points)


# --- the scalar integrator ------------------------------------------------------------------------


def test_trajectories_in_lanes_end_where_the_scalar_drive_ends() -> None:
    points = np.array([row(rheological_index=g) for g in (*GAMMAS, -0.5)])
    motions = motions_of(points, DEFAULTS.physics)
    motions.counts[:, CYCLE] = 2
    work_through(motions, TRAVEL, 1e-9, 10**7, DEFAULTS.physics)
    conversion_of(DEFAULTS.physics).restore_states(points, motions.states)
    steps = motions.counts[:, ATTEMPTED]
    assert np.all(motions.counts[:, OUTCOME] == Status.OK)
    assert np.all((steps > 500) & (steps < 100_000))
    for point, state in zip(points, motions.states, strict=True):
        p = Parameters(*point)
        ds = simulate(p, periods=1, samples_per_period=4, rtol=1e-10)
        X_m, V_m = p.drive_amplitude, p.drive_amplitude * p.angular_frequency
        assert state[0] == pytest.approx(float(ds.lower_displacement[-1]), abs=1e-7 * X_m)
        assert state[1] == pytest.approx(float(ds.lower_velocity[-1]), abs=1e-6 * V_m)
        assert np.exp(state[2]) == pytest.approx(float(ds.order_parameter[-1]), rel=1e-5)


# --- neighbours -----------------------------------------------------------------------------------

LOOSE: dict[str, Any] = {"rtol": 1e-4, "stationary_rtol": 1e-4}


@cache
def alone(**options: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the results of fifty points, each computed alone."""
    parts = [compute_orbits(point, Options(**LOOSE, **options)) for point in trouble()]
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def trouble() -> np.ndarray:
    """Return fifty points, a few of which diverge at the start."""
    # Most have one fluid, more than there are lanes, so that lanes take one point after another.
    points = np.concatenate([random_points(12), random_points(38, fluids=(-2 / 3,))])
    assert np.count_nonzero(points == -2 / 3) > 2 * LANES
    points[[3, 17, 40], Parameters._fields.index("initial_velocity")] = 1e200, -1e250, 1e300
    return points


# One budget is enough for all, the others run out for some points.
BUDGETS: list[dict[str, Any]] = [{}, {"max_periods": 6}, {"max_steps": 3000}]


@pytest.mark.parametrize("budget", BUDGETS, ids=str)
def test_a_point_has_the_same_bits_among_any_neighbours(budget: dict[str, Any]) -> None:
    points, expected = trouble(), alone(**budget)
    rng = np.random.default_rng(1)
    orders = [np.arange(50), np.arange(50)[::-1], rng.permutation(50)]
    orders += [rng.permutation(50)[:n] for n in (1, 2, 7, 8, 15, 16, 17, 31, 33)]
    for order in orders:
        found = compute_orbits(points[order], Options(**LOOSE, **budget))
        for ours, theirs in zip(found, expected, strict=True):
            np.testing.assert_array_equal(ours, theirs[order], strict=True)


def test_every_status_occurs_among_those_neighbours() -> None:
    statuses = [set(alone(**budget)[0][:, STATUS].astype(int).tolist()) for budget in BUDGETS]
    assert statuses[0] >= {Status.OK, Status.DIVERGED}
    assert statuses[1] >= {Status.OK, Status.NOT_STATIONARY}
    assert statuses[2] >= {Status.OK, Status.STEP_LIMIT}


# --- acceleration ---------------------------------------------------------------------------------

ATTRACTORS: dict[str, dict[str, float]] = {
    "two at 38, from rest": {"angular_frequency": 38.0},
    "two at 38, from 0.01": {"angular_frequency": 38.0, "initial_order_parameter": 0.01},
    "two at 38, from 1e-6": {"angular_frequency": 38.0, "initial_order_parameter": 1e-6},
    "asymmetric at 15": {"angular_frequency": 15.0},
    "subharmonic": SUBHARMONIC,
    "slipping from rest": {"spring_stiffness": 1500.0},
    "locked": {
        "spring_stiffness": 1500.0,
        "initial_displacement": 0.8e-6,
        "initial_order_parameter": 0.6,
    },
    "dilatant, liquid": {"temperature": 294.0, "rheological_index": 2 / 3},
    "dilatant, solid": {
        "temperature": 294.0,
        "rheological_index": 2 / 3,
        "initial_order_parameter": 0.6,
    },
    "newtonian": {"temperature": 294.0, "rheological_index": 0.0},
    "general": {"rheological_index": -0.4, "angular_frequency": 20.0},
}


@cache
def both(name: str) -> tuple[SimpleNamespace, SimpleNamespace]:
    point = row(**ATTRACTORS[name])
    return orbits(point), orbits(point, accelerate=False)


@pytest.mark.parametrize("name", ATTRACTORS)
def test_jumps_end_on_the_orbit_of_plain_iteration(name: str) -> None:
    hurried, plain = both(name)
    assert hurried.status == plain.status == Status.OK
    for count in COUNTS:
        assert getattr(hurried, count) == getattr(plain, count)
    point = row(**ATTRACTORS[name])
    stress, force = plain.elastic_stress_amplitude, plain.friction_force_amplitude
    assert amplitude_errors(hurried, point, stress, force) <= 5e-6
    assert hurried.asymmetry == pytest.approx(plain.asymmetry, abs=1e-5)
    assert hurried.periods_integrated <= 1.5 * plain.periods_integrated + 10
    # An asymmetric orbit must not come out as its mirror image.
    if plain.asymmetry > 1e-3:
        p = Parameters(*point)
        ours, theirs = hurried.final[0, :2], plain.final[0, :2]
        if hurried.orbit_periods == 1:
            scale = p.drive_amplitude * np.array([1.0, p.angular_frequency])
            np.testing.assert_allclose(ours / scale, theirs / scale, rtol=0, atol=1e-5)


# --- the measurement ------------------------------------------------------------------------------

MEASURED: dict[str, dict[str, float]] = {
    "fig3": {},
    "asymmetric": {"angular_frequency": 15.0},
    "locked": {"rheological_index": 0.0},
    "dilatant": {"rheological_index": 2 / 3, "temperature": 250.0},
    "general": {"rheological_index": -0.4, "temperature": 220.0},
    "mirrored": {"angular_frequency": 38.0, "drive_amplitude": -0.8e-6},
    "near melting": {"temperature": 280.0},
}


@pytest.mark.parametrize("name", MEASURED)
def test_extremes_agree_with_a_dense_trajectory_on_the_orbit(name: str) -> None:
    p = Parameters(**MEASURED[name])
    found = orbits(np.array(p))
    ds = simulate(p, periods=1, start="stationary", samples_per_period=400_000, rtol=1e-9)
    for quantity in ("elastic_stress", "friction_force"):
        values, scale = ds[quantity].values, getattr(found, f"{quantity}_amplitude")[0]
        high, low = (getattr(found, f"{quantity}_{end}")[0] for end in ("max", "min"))
        # Samples miss the peak by the square of their distance, and exceed it by no more than the
        # error of the orbit.
        assert -5e-6 * scale < high - values.max() < 1e-4 * scale
        assert -1e-4 * scale < low - values.min() < 5e-6 * scale


def test_meltings_agree_with_a_dense_trajectory_on_the_orbit() -> None:
    for changes in MEASURED.values():
        p = Parameters(**changes)
        found = orbits(np.array(p))
        ds = simulate(p, periods=1, start="stationary", samples_per_period=20_000)
        solid = 0.5 * p.cubic_coefficient / p.quartic_coefficient
        last, count = 0, 0
        for phi in np.tile(ds.order_parameter.values[:-1], 2):  # twice, so that it is cyclic
            phase = 1 if phi >= solid else -1 if phi <= 0.1 * solid else last
            count += last == 1 and phase == -1
            last = phase
        assert count in (2 * found.melting_count[0], 2 * found.melting_count[0] - 1)


def test_a_rejected_step_that_is_not_finite_leaves_no_trace_in_the_record() -> None:
    # At loose tolerances some attempted steps overflow, and are rejected and not measured. The step
    # to an extremum, whose length no error control has chosen, may overflow too.
    for seed in (3, 5):
        found = orbits(random_points(200, seed), rtol=1e-3, stationary_rtol=1e-3)
        counts = np.bincount(found.status.astype(int), minlength=7)
        assert counts[Status.OK] + counts[Status.NOT_STATIONARY] == 200, counts
        assert np.isfinite(found.elastic_stress_amplitude_spread[found.status == Status.OK]).all()


@pytest.mark.slow
def test_the_error_falls_in_proportion_to_the_tolerance() -> None:
    points = random_points(20, seed=3)
    exact = orbits(points, rtol=1e-11, stationary_rtol=1e-11)
    known = exact.status == Status.OK
    assert np.count_nonzero(known) >= 18
    tolerances = 10.0 ** -np.arange(3.0, 10.0)
    stress, force = exact.elastic_stress_amplitude, exact.friction_force_amplitude
    medians = []
    for rtol in tolerances:
        found = orbits(points, rtol=rtol, stationary_rtol=rtol)
        counted = known & (found.status == Status.OK)
        assert np.count_nonzero(counted) >= 18
        assert np.all(found.orbit_periods[counted] == exact.orbit_periods[counted])
        medians.append(np.median(amplitude_errors(found, points, stress, force)[counted]))
    slope = np.polyfit(np.log(tolerances), np.log(medians), 1)[0]
    assert 0.7 <= slope <= 1.5, (slope, medians)
    assert np.all(medians <= tolerances)
