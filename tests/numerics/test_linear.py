"""Vectors of three and their linear systems against NumPy; NaN and infinity are not lost."""

import math

import numpy as np
import pytest

from stickslip.numerics import linear

BAD = [math.nan, math.inf, -math.inf]


def random_system(rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """A Jacobian with entries of very different size, and a shift that dominates its diagonal."""
    J = rng.normal(size=(3, 3)) * 10.0 ** rng.uniform(-2, 2, size=(3, 3))
    return J, 4.0 * float(np.abs(J).sum())


def rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())


def test_factor_and_solve_solve_the_shifted_system() -> None:
    rng = np.random.default_rng(7)
    for _ in range(300):
        J, shift = random_system(rng)
        r = rng.normal(size=3)
        z = linear.solve(linear.factor(rows(J), shift), tuple(r.tolist()))
        assert np.array(z) == pytest.approx(
            np.linalg.solve(shift * np.eye(3) - J, r), rel=1e-12, abs=1e-15 / shift
        )


def test_every_entry_of_the_matrix_counts() -> None:
    # A shift close to the entries, so that none of them is a small correction.
    J = np.array([[0.3, -0.7, 0.4], [0.9, -0.2, 0.6], [-0.5, 0.8, 0.1]])
    r = (1.0, -2.0, 3.0)
    z = linear.solve(linear.factor(rows(J), 2.0), r)
    assert np.array(z) == pytest.approx(np.linalg.solve(2.0 * np.eye(3) - J, r), rel=1e-13)


def test_a_nearly_infinite_slope_freezes_its_component_and_leaves_the_others() -> None:
    J = ((0.0, 1.0, 0.0), (-1.0, -1e80, 1.0), (0.0, 1.0, -1.0))
    x, y, z = linear.solve(linear.factor(J, 2.0), (1.0, 1.0, 1.0))
    assert abs(y) < 1e-79
    assert (x, z) == pytest.approx((0.5, 1 / 3), rel=1e-14)


def test_plain_python_solves_the_same_system() -> None:
    J, shift = random_system(np.random.default_rng(8))
    LU = linear.factor(rows(J), shift)
    plain = linear.factor.py_func(rows(J), shift)
    assert np.array(LU) == pytest.approx(np.array(plain), rel=1e-13)
    r = (1.0, 2.0, 3.0)
    assert linear.solve(LU, r) == pytest.approx(linear.solve.py_func(LU, r), rel=1e-13)


def test_add_adds_a_multiple() -> None:
    assert linear.add((1.0, 2.0, 3.0), 2.0, (0.5, -1.0, 4.0)) == (2.0, 0.0, 11.0)


@pytest.mark.parametrize("where", range(3))
def test_the_largest_error_looks_at_every_component_and_its_weight(where: int) -> None:
    error = [1e-3, 1e-3, 1e-3]
    error[where] = -6.0
    weight = [1.0, 1.0, 1.0]
    weight[where] = 0.5
    assert linear.largest(tuple(error), tuple(weight)) == 3.0


@pytest.mark.parametrize("in_weight", [False, True])
@pytest.mark.parametrize("where", range(3))
def test_an_error_that_is_nan_is_never_dropped(where: int, in_weight: bool) -> None:
    error, weight = [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]
    (weight if in_weight else error)[where] = math.nan
    assert math.isnan(linear.largest(tuple(error), tuple(weight)))


@pytest.mark.parametrize("where", range(3))
def test_an_infinite_error_is_never_small(where: int) -> None:
    error = [1.0, 1.0, 1.0]
    error[where] = math.inf
    assert not linear.largest(tuple(error), (1.0, 1.0, 1.0)) <= 1.0


def test_the_larger_of_two() -> None:
    assert linear.larger(1.0, 2.0) == linear.larger(2.0, 1.0) == 2.0
    assert linear.larger(math.nan, 2.0) == 2.0
    assert math.isnan(linear.larger(2.0, math.nan))


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("where", range(3))
def test_a_component_that_is_not_finite_is_seen(where: int, value: float) -> None:
    y = [1.0, -2.0, 3.0]
    assert linear.finite(tuple(y))
    y[where] = value
    assert not linear.finite(tuple(y))


def test_opposite_infinities_do_not_cancel() -> None:
    assert not linear.finite((math.inf, -math.inf, 0.0))
