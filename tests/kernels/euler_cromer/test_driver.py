"""The paper's own method: first order, refused where unstable, and in agreement with the other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.points import error_scales, orbits, row

from stickslip import IntegrationError, Parameters, Status, kernels, simulate, stability
from stickslip.options import Options

X_M = 0.8e-6
OMEGA = 38.0


def end_of_a_period(p: Parameters, options: Options) -> np.ndarray:
    """(x/X_m, v/(X_m omega)) after one period from the start."""
    fixed = options.method == "euler-cromer"
    door = kernels.fixed_trajectory if fixed else kernels.adaptive_trajectory
    start, samples = np.empty(3), np.empty((2, 3))
    kernels.starting_log_state(np.array(p), start)
    assert door(np.array(p), options.settings(), start, 1, samples) == Status.OK
    return samples[-1, :2] / [X_M, X_M * p.angular_frequency]


@pytest.mark.slow
def test_errors_fall_in_proportion_to_the_step() -> None:
    # Through a slip at 38 rad/s, where the order parameter has its fastest rates, and from rest:
    # on the cusp of the viscous force, which the adaptive method must not freeze on either.
    p = Parameters(angular_frequency=OMEGA)
    exact = end_of_a_period(p, Options(rtol=1e-10))
    steps = np.array([4e-9, 2e-9, 1e-9])
    found = [end_of_a_period(p, Options(method="euler-cromer", dt=dt)) for dt in steps.tolist()]
    errors = np.abs(np.array(found) - exact)
    slopes = np.diff(np.log(errors), axis=0) / np.diff(np.log(steps))[:, None]
    assert np.all(np.abs(slopes - 1) < 0.1), (slopes, errors)
    assert errors[-1, 0] < 1e-7


# Steps that gave finite, plausible and wrong amplitudes, up to 17 times too high, without any NaN.
FINITE_BUT_WRONG = [
    ({"angular_frequency": 38.0}, 8e-8),
    ({"rheological_index": 0.0}, 2.6e-5),
    ({"rheological_index": 2 / 3}, 2e-6),
    ({"block_mass": 1e-3}, 2e-6),
    ({"strain_relaxation_time": 1e-6}, 2e-6),
]


@pytest.mark.parametrize(("changes", "dt"), FINITE_BUT_WRONG, ids=str)
def test_finite_but_wrong_steps_are_refused(changes: dict[str, float], dt: float) -> None:
    assert orbits(row(**changes), method="euler-cromer", dt=dt).status == Status.REFUSED
    with pytest.raises(IntegrationError) as caught:
        simulate(Parameters(**changes), method="euler-cromer", dt=dt)
    assert caught.value.status is Status.REFUSED


@pytest.mark.parametrize("changes", [{}, {"angular_frequency": 38.0}, {"temperature": 300.0}])
def test_refusal_begins_at_the_largest_stable_step(changes: dict[str, float]) -> None:
    limit = float(stability.largest_stable_step(row(**changes))[0])
    options = {"method": "euler-cromer", "max_steps": 1}
    assert orbits(row(**changes), dt=limit, **options).status == Status.STEP_LIMIT
    assert orbits(row(**changes), dt=limit * (1 + 1e-12), **options).status == Status.REFUSED


def test_the_step_of_the_paper_is_stable_at_its_parameters() -> None:
    for omega in (10.0, 15.0, 32.0, 38.0):
        assert stability.largest_stable_step(row(angular_frequency=omega))[0] > 10 * 1e-10


def test_a_step_that_overflows_is_seen() -> None:
    # Past the refusal, straight through the compiled door: twice the stable step at 38 rad/s.
    start, samples = np.empty(3), np.empty((2, 3))
    point = row(angular_frequency=OMEGA)
    kernels.starting_log_state(point, start)
    settings = Options(method="euler-cromer", dt=1.6e-8).settings()
    assert kernels.fixed_trajectory(point, settings, start, 1, samples) == Status.DIVERGED


# Scenes whose largest stable step is long: a liquid film, a slow one, and one without elasticity.
ORBITS = [
    ({"elastic_coefficient": 0.0}, 2e-5),
    ({"elastic_coefficient": 0.0, "rheological_index": -0.5}, 2e-5),
    ({"temperature": 300.0}, 7e-7),
    ({"temperature": 300.0, "rheological_index": 0.0, "viscosity_coefficient": 1e4}, 7e-7),
    (
        {
            "temperature": 250.0,
            "rheological_index": 0.0,
            "viscosity_coefficient": 1e4,
            "kinetic_coefficient": 1.0,
        },
        2e-6,
    ),
]


@pytest.mark.parametrize(("changes", "dt"), ORBITS, ids=str)
def test_orbits_agree_with_the_adaptive_ones_within_the_stated_error(
    changes: dict[str, float], dt: float
) -> None:
    point = row(**changes)
    fixed = orbits(point, method="euler-cromer", dt=dt)
    exact = orbits(point, rtol=1e-9, stationary_rtol=1e-9)
    assert (fixed.status, exact.status) == (Status.OK, Status.OK)
    stress_scale, force_scale = error_scales(point)
    true = max(
        *abs(fixed.elastic_stress_amplitude - exact.elastic_stress_amplitude) / stress_scale,
        *abs(fixed.friction_force_amplitude - exact.friction_force_amplitude)
        / np.maximum(exact.friction_force_amplitude, force_scale),
    )
    # 1e-6 for the distance to the limit that `stationary_rtol` leaves to both.
    assert true <= fixed.amplitude_error[0] + 1e-6
    assert fixed.amplitude_error[0] < 1e-4
    assert fixed.power_balance_error[0] < 1e-4
    assert fixed.melting_count == exact.melting_count
    assert fixed.orbit_periods == exact.orbit_periods == 1


def test_the_stated_error_falls_in_proportion_to_the_step() -> None:
    errors = [
        orbits(row(elastic_coefficient=0.0), method="euler-cromer", dt=dt).amplitude_error[0]
        for dt in (4e-5, 2e-5, 1e-5)
    ]
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 2.0, rtol=0.1)


def test_a_period_is_divided_evenly() -> None:
    # dt does not divide the period: the last sample is at its end all the same.
    p = Parameters(elastic_coefficient=0.0, initial_displacement=1e-7)
    period = 2 * math.pi / 10
    found = simulate(p, method="euler-cromer", dt=period / 20_000.5, periods=1)
    even = simulate(p, method="euler-cromer", dt=period / 20_001, periods=1)
    np.testing.assert_array_equal(found.lower_displacement, even.lower_displacement)


def test_the_first_steps_are_those_of_the_method() -> None:
    # By hand: v from the old state, x with the new v, phi from the old state and not negative.
    # From x = 0, so that the new v (1e-4 beside the old one in a step) shows in x.
    p = Parameters(
        angular_frequency=2e5,
        drive_amplitude=8e-11,
        initial_velocity=3e-7,
        initial_order_parameter=0.5,
        noise_intensity=0.0,
    )
    dt = 2 * math.pi / 2e5 / 4000
    x, v, phi = 0.0, 3e-7, 0.5
    by_hand = [(x, v, phi)]
    for n in range(3):
        u = -8e-11 * 2e5 * math.sin(2e5 * n * dt) - v
        eps = u * 10.0
        viscous = math.copysign(5e4 * abs(u / 1e-9) ** (1 / 3), u)
        force = 0.6e-9 * (4e12 * phi**2 * eps + viscous)
        rate = -100 * phi * (4e12 * eps**2 + 1.9 * (200 - 290) - 230 * phi + 850 * phi**2)
        v += dt * (force - 6000 * x) / 0.4
        x += dt * v
        phi = abs(phi + dt * rate)
        by_hand.append((x, v, phi))
    settings = Options(method="euler-cromer", dt=dt * (1 + 1e-9)).settings()
    samples = np.empty((4001, 3))
    start = np.array([0.0, 3e-7, math.log(0.5)])
    kernels.fixed_trajectory(np.array(p), settings, start, 4000, samples)
    np.testing.assert_allclose(samples[:4], by_hand, rtol=1e-9)
