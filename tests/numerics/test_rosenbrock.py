"""One Rosenbrock step: its order, that of its estimates and of its continuous extension."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.stiff_problems import SMOOTH, START, STIFF, jacobian, rhs, smooth_solution

from stickslip.compiled.decorators import jit
from stickslip.numerics.linear import algebra
from stickslip.numerics.rosenbrock import make_defect_error, make_step
from stickslip.numerics.tableaus import RODAS4P2

ALGEBRA = algebra(3)
defect_error, interpolate = make_defect_error(ALGEBRA), ALGEBRA.interpolate

END = 2.0


class Method(NamedTuple):
    """One compiled step of the method, and the compiled march of equal steps."""

    one: Any
    march: Any


class Step(NamedTuple):
    y: np.ndarray
    estimate: np.ndarray
    defect: np.ndarray
    within: np.ndarray


@pytest.fixture(scope="module")
def method() -> Method:
    step = make_step(rhs, RODAS4P2, ALGEBRA)

    @jit
    def one(p, t, h, y):
        y1, error, d1, d2, LU = step(p, t, y, h, rhs(p, t, y), jacobian(p, t, y))
        return y1, error, defect_error(rhs(p, t + h, y1), LU, y, y1, d1, d2, h), d1, d2

    @jit
    def march(p, t0, t1, steps, y):
        h = (t1 - t0) / steps
        for i in range(steps):
            t = t0 + i * h
            y, _, _, _, _ = step(p, t, y, h, rhs(p, t, y), jacobian(p, t, y))
        return y

    return Method(one, march)


def single_step(method: Method, p: float, h: float, y: tuple[float, float, float]) -> Step:
    y1, error, defect, d1, d2 = method.one(p, 0.0, h, y)
    thetas = np.linspace(0.0, 1.0, 21)
    within = np.array([interpolate(theta, y, y1, d1, d2) for theta in thetas])
    return Step(np.array(y1), np.array(error), np.array(defect), within)


def slope(steps: list[float], errors: list[float]) -> float:
    """Exponent of the power law through the errors."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def test_the_jacobian_of_the_smooth_problem_is_right() -> None:
    # Otherwise the order tests below would test something else.
    step = 1e-6
    for direction in range(4):
        at = [[*START, 0.3], [*START, 0.3]]
        at[0][direction] -= step
        at[1][direction] += step
        low, high = (np.array(rhs(SMOOTH, y[3], tuple(y[:3]))) for y in at)
        J = jacobian(SMOOTH, 0.3, START)
        column = J[3] if direction == 3 else [row[direction] for row in J[:3]]
        assert (high - low) / (2 * step) == pytest.approx(column, abs=1e-9)


def test_the_global_error_is_of_fourth_order(method: Method) -> None:
    counts = [40, 80, 160, 320]
    reference = smooth_solution(np.array([0.0, END]))[-1]
    errors = [
        float(np.abs(np.array(method.march(SMOOTH, 0.0, END, n, START)) - reference).max())
        for n in counts
    ]
    assert slope([END / n for n in counts], errors) == pytest.approx(4.0, abs=0.2)
    assert errors[-1] < 1e-10


# A local error of order p + 1 belongs to a method of order p.
SHORT_STEPS = [0.05, 0.025, 0.0125, 0.00625]


@pytest.mark.parametrize("part", ["within", "estimate", "defect"])
def test_continuous_extension_and_both_estimates_are_of_third_order(
    method: Method, part: str
) -> None:
    sizes = []
    for h in SHORT_STEPS:
        found = getattr(single_step(method, SMOOTH, h, START), part)
        if part == "within":  # its error, uniformly
            found = found - smooth_solution(np.linspace(0.0, h, 21))
        sizes.append(float(np.abs(found).max()))
    assert slope(SHORT_STEPS, sizes) == pytest.approx(4.0, abs=0.2)


def test_the_continuous_extension_joins_the_ends_of_the_step(method: Method) -> None:
    step = single_step(method, SMOOTH, 0.3, START)
    assert step.within[0] == pytest.approx(START, rel=1e-15)
    assert step.within[-1] == pytest.approx(step.y, rel=1e-15)


def test_the_embedded_estimate_is_the_error_of_the_embedded_solution(method: Method) -> None:
    for h in SHORT_STEPS:
        step = single_step(method, SMOOTH, h, START)
        embedded = step.y - step.estimate
        true = smooth_solution(np.array([0.0, h]))[-1] - embedded
        assert step.estimate == pytest.approx(true, abs=0.05 * float(np.abs(true).max()))


def test_a_step_far_beyond_the_stiff_rates_is_damped(method: Method) -> None:
    step = single_step(method, STIFF, 0.1, (1.0, 5.0, 1.0))
    assert abs(step.y[0]) < 1e-6
    assert step.y[1] == pytest.approx(math.cos(0.1), abs=1e-3)  # from 5.0
    assert np.all(np.isfinite(step.estimate))


# --- the cusp ------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("u_0", [0.0, 1e-15, 1e-12, -1e-12, 1e-9])
def test_a_step_across_a_rounded_cusp_has_a_large_error_estimate(
    method: Method, u_0: float, tolerance: float
) -> None:
    step = single_step(method, -tolerance, 0.1, (u_0, 0.0, 0.0))
    assert max(abs(step.estimate[0]), abs(step.defect[0])) > tolerance
