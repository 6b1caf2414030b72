"""Vectors of any width and their linear systems against NumPy; NaN and infinity are not lost."""

import math

import numpy as np
import pytest

from stickslip.numerics import linear
from stickslip.numerics.linear import Algebra, algebra

WIDTHS = [2, 3, 4]
BAD = [math.nan, math.inf, -math.inf]


@pytest.fixture(scope="module", params=WIDTHS, ids="width {}".format)
def of_width(request: pytest.FixtureRequest) -> Algebra:
    return algebra(request.param)


def random_system(rng: np.random.Generator, width: int) -> tuple[np.ndarray, float]:
    """A Jacobian with entries of very different size, and a shift that dominates its diagonal."""
    J = rng.normal(size=(width, width)) * 10.0 ** rng.uniform(-2, 2, size=(width, width))
    return J, 4.0 * float(np.abs(J).sum())


def rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())


def vectors(rng: np.random.Generator, width: int, count: int) -> list[tuple[float, ...]]:
    return [tuple(row) for row in rng.normal(size=(count, width)).tolist()]


def with_one(width: int, where: int, value: float, others: float = 1.0) -> tuple[float, ...]:
    """A vector of `others`, but for one component."""
    return tuple(value if i == where else others for i in range(width))


# --- linear systems ------------------------------------------------------------------------------


def test_factor_and_solve_solve_the_shifted_system(of_width: Algebra) -> None:
    rng, width = np.random.default_rng(7), of_width.width
    for _ in range(200):
        J, shift = random_system(rng, width)
        r = rng.normal(size=width)
        z = of_width.solve(of_width.factor(rows(J), shift), tuple(r.tolist()))
        assert np.array(z) == pytest.approx(
            np.linalg.solve(shift * np.eye(width) - J, r), rel=1e-12, abs=1e-15 / shift
        )


def test_every_entry_of_the_matrix_counts(of_width: Algebra) -> None:
    # A shift close to the entries, so that none of them is a small correction.
    J = np.array(
        [
            [0.3, -0.7, 0.4, 0.2],
            [0.9, -0.2, 0.6, -0.3],
            [-0.5, 0.8, 0.1, 0.7],
            [0.4, -0.6, 0.5, 0.2],
        ]
    )
    width = of_width.width
    J, r = J[:width, :width], (1.0, -2.0, 3.0, -4.0)[:width]
    z = of_width.solve(of_width.factor(rows(J), 2.0), r)
    assert np.array(z) == pytest.approx(np.linalg.solve(2.0 * np.eye(width) - J, r), rel=1e-13)


def test_a_nearly_infinite_slope_freezes_its_component_and_leaves_the_others() -> None:
    of_three, J = algebra(3), ((0.0, 1.0, 0.0), (-1.0, -1e80, 1.0), (0.0, 1.0, -1.0))
    x, y, z = of_three.solve(of_three.factor(J, 2.0), (1.0, 1.0, 1.0))
    assert abs(y) < 1e-79
    assert (x, z) == pytest.approx((0.5, 1 / 3), rel=1e-14)


# --- vectors -------------------------------------------------------------------------------------


def test_operations_on_vectors_agree_with_numpy(of_width: Algebra) -> None:
    rng, width = np.random.default_rng(12), of_width.width
    for _ in range(50):
        y0, y1, d1, d2, f1 = vectors(rng, width, 5)
        s, h = rng.normal(), rng.uniform(0.1, 1.0)
        assert of_width.add(y0, s, y1) == pytest.approx(np.add(y0, np.multiply(s, y1)), abs=1e-15)
        between = (1 - h) * np.array(y0)
        between += h * (np.array(y1) + (1 - h) * (np.array(d1) + h * np.array(d2)))
        assert of_width.interpolate(h, y0, y1, d1, d2) == pytest.approx(between, abs=1e-14)
        slope = (np.array(y1) - y0 - d1 - d2) / h
        assert of_width.end_slope(f1, y0, y1, d1, d2, h) == pytest.approx(f1 - slope, abs=1e-13)
        assert of_width.choose(True, y0, y1) == y0
        assert of_width.choose(False, y0, y1) == y1
        weight = tuple(abs(x) for x in d1)
        largest = np.abs(np.multiply(y0, weight)).max()
        assert of_width.largest(y0, weight) == pytest.approx(largest, rel=1e-15)
    assert of_width.zero() == (0.0,) * width


def test_the_slope_at_the_end_belongs_to_the_interpolant(of_width: Algebra) -> None:
    rng, h, step = np.random.default_rng(13), 0.3, 1e-6
    y0, y1, d1, d2 = vectors(rng, of_width.width, 4)
    # A cubic: its one-sided difference to third order is exact.
    values = [np.array(of_width.interpolate(1.0 - i * step, y0, y1, d1, d2)) for i in range(4)]
    slope = np.dot([11 / 6, -3, 3 / 2, -1 / 3], values) / step / h
    assert of_width.end_slope(tuple(slope.tolist()), y0, y1, d1, d2, h) == pytest.approx(
        np.zeros(of_width.width), abs=1e-7
    )


# --- NaN and infinity ----------------------------------------------------------------------------


def test_the_largest_error_includes_every_component_and_its_weight(of_width: Algebra) -> None:
    width = of_width.width
    for where in range(width):
        error, weight = with_one(width, where, -6.0, others=1e-3), with_one(width, where, 0.5)
        assert of_width.largest(error, weight) == 3.0


def test_an_error_that_is_not_finite_is_never_dropped(of_width: Algebra) -> None:
    width = of_width.width
    ones = (1.0,) * width
    for where in range(width):
        wrong = with_one(width, where, math.nan)
        assert math.isnan(of_width.largest(wrong, ones))
        assert math.isnan(of_width.largest(ones, wrong))
        assert not of_width.largest(with_one(width, where, math.inf), ones) <= 1.0


def test_the_larger_of_two() -> None:
    assert linear.larger(1.0, 2.0) == linear.larger(2.0, 1.0) == 2.0
    assert linear.larger(math.nan, 2.0) == 2.0
    assert math.isnan(linear.larger(2.0, math.nan))


@pytest.mark.parametrize("value", BAD)
def test_a_component_that_is_not_finite_is_seen(of_width: Algebra, value: float) -> None:
    width = of_width.width
    assert of_width.finite((1.0, -2.0, 3.0, -4.0)[:width])
    for where in range(width):
        assert not of_width.finite(with_one(width, where, value))
    assert not of_width.finite((math.inf, -math.inf, 0.0, 0.0)[:width])  # they do not cancel
