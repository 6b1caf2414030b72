"""The step of the variational equations: its order, what it damps, and what it carries exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stickslip.numerics.linear import algebra
from stickslip.numerics.variational import DAMPING, NODES, make_variational_step, shift_of

TWO = algebra(2)
step = make_variational_step(TWO)
ZERO = (0.0, 0.0)


def jacobian(t: float) -> tuple[tuple[float, float], tuple[float, float]]:
    return (-math.sin(t), 1.0), (math.cos(2.0 * t) - 1.0, -0.5)


def carried(w: tuple[float, float], steps: int) -> np.ndarray:
    h = 1.0 / steps
    for i in range(steps):
        LUs = tuple(TWO.factor(jacobian((i + c) * h), shift_of(h)) for c in NODES)
        w = step(w, 0.0, ZERO, ZERO, shift_of(h), LUs, (ZERO, ZERO, ZERO))
    return np.array(w)


def test_it_is_of_third_order() -> None:
    exact = carried((1.0, -0.4), 4096)
    errors = [np.abs(carried((1.0, -0.4), n) - exact).max() for n in (16, 32, 64)]
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(slopes, 3.0, atol=0.2)


def test_a_fast_mode_decays_within_a_step() -> None:
    h, J = 0.1, ((-1e9, 0.0), (0.0, -1.0))
    LUs = (TWO.factor(J, shift_of(h)),) * 3
    fast, slow = step((1.0, 1.0), 0.0, ZERO, ZERO, shift_of(h), LUs, (ZERO, ZERO, ZERO))
    assert abs(fast) < 1e-7
    assert slow == pytest.approx(math.exp(-0.1), abs=1e-5)


@pytest.mark.parametrize("rate", [0.1, 0.03])
def test_an_oscillation_is_damped_as_stated(rate: float) -> None:
    LUs = (TWO.factor(((0.0, 1.0), (-(rate**2), 0.0)), shift_of(1.0)),) * 3
    w: tuple[float, ...] = (1.0, 0.0)
    for _ in range(1000):
        w = step(w, 0.0, ZERO, ZERO, shift_of(1.0), LUs, (ZERO, ZERO, ZERO))
    amplitude = math.hypot(w[0], w[1] / rate)
    assert -math.log(amplitude) == pytest.approx(1000 * DAMPING * rate**4, rel=0.02)


@pytest.mark.parametrize("h", [0.01, 0.7])
def test_a_displacement_along_the_motion_moves_with_it_for_any_slope(h: float) -> None:
    f0, f1, f_t = (0.3, 2.0), (-0.1, 0.6), (0.0, 0.0)
    LUs = tuple(TWO.factor(((0.0, 1.0), (0.0, -slope)), shift_of(h)) for slope in (3.0, 1e6, 40.0))
    w = (2.5 * f0[0], 2.5 * f0[1])
    moved = step(w, 2.5, f0, f1, shift_of(h), LUs, (f_t, f_t, f_t))
    assert moved == pytest.approx((2.5 * f1[0], 2.5 * f1[1]), rel=1e-14)


def test_the_jacobian_moves_the_rest_of_a_displacement() -> None:
    """Whatever share counts as along the motion, the result is the same to the step's order.

    The equation y' = -y^2 + t depends on time; its exact dy/dy0 comes from differences.
    """
    one = algebra(1)
    move, h, y0 = make_variational_step(one), 0.02, 0.8

    def rate(t: float, y: float) -> float:
        return -y * y + t

    def path(y: float, t: float) -> float:
        for i in range(400):  # Heun's method, far finer than the step
            d = t / 400
            k = rate(i * d, y)
            y += 0.5 * d * (k + rate((i + 1) * d, y + d * k))
        return y

    exact = (path(y0 + 1e-5, h) - path(y0 - 1e-5, h)) / 2e-5
    LUs = tuple(one.factor(((-2.0 * path(y0, c * h),),), shift_of(h)) for c in NODES)
    f0, f1 = (rate(0.0, y0),), (rate(h, path(y0, h)),)
    for share in (0.0, 1.0 / f0[0], -3.0):
        (moved,) = move((1.0,), share, f0, f1, shift_of(h), LUs, ((1.0,),) * 3)
        assert moved == pytest.approx(exact, abs=1e-7)
