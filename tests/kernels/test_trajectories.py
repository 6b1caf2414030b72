"""Trajectories of Euler-Cromer: its first steps by hand, its division of a period, overflow."""

from __future__ import annotations

import math

import numpy as np

from stickslip import Parameters, Status, simulate
from stickslip.kernels.trajectories import start_kernel, write_trajectory
from stickslip.options import DEFAULTS, Options


def sampled(p: Parameters, options: Options, per_period: int = 1) -> tuple[np.ndarray, int]:
    """Return the states (x, v, phi) of a period from the start, for any step, and the Status."""
    start, samples = np.empty(3), np.empty((per_period + 1, 3))
    start_kernel(DEFAULTS.physics)(np.array(p), start)
    return samples, write_trajectory(np.array(p), options, start, per_period, samples)


def test_a_step_that_overflows_is_detected() -> None:
    # This is twice the stable step at 38 rad/s.
    p = Parameters(angular_frequency=38.0)
    assert sampled(p, Options(method="euler-cromer", dt=1.6e-8))[1] == Status.DIVERGED


def test_a_period_is_divided_evenly() -> None:
    # dt does not divide the period, but the last sample is at the end nevertheless.
    p = Parameters(elastic_coefficient=0.0, initial_displacement=1e-7)
    period = 2 * math.pi / 10
    found = simulate(p, method="euler-cromer", dt=period / 20_000.5, periods=1)
    even = simulate(p, method="euler-cromer", dt=period / 20_001, periods=1)
    np.testing.assert_array_equal(found.lower_displacement, even.lower_displacement)


def test_the_first_steps_are_those_of_the_method() -> None:
    # v comes from the old state, x from the new v, and phi from the old state and is not negative.
    # It starts at x = 0, so that the new v, which differs by 1e-4 from the old one, shows in x.
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
    found, status = sampled(p, Options(method="euler-cromer", dt=dt * (1 + 1e-9)), 4000)
    assert status == Status.OK
    np.testing.assert_allclose(found[:4], by_hand, rtol=1e-9)
