"""The cube root without a library call: exact to rounding over the whole range."""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.model.elementary import cube_root


def relative_error(x: float) -> float:
    """Error of cube_root(x), from its exact cube: (r^3 - x)/(3 x)."""
    with localcontext() as context:
        context.prec = 60
        r, exact = Decimal(cube_root(x)), Decimal(x)
        return abs(float((r**3 - exact) / (3 * exact)))


@given(exponent=st.floats(-300.0, 300.0))
def test_the_relative_error_is_below_1_1e_15(exponent: float) -> None:
    assert relative_error(10.0**exponent) < 1.1e-15


def test_the_relative_error_is_below_1_1e_15_over_all_phases_of_the_exponent() -> None:
    mantissas = np.linspace(1.0, 8.0, 4001)  # three exponents: the guess has this period
    for scale in (2.0**-990, 1.0, 2.0**990):
        assert max(relative_error(float(m) * scale) for m in mantissas) < 1.1e-15


@pytest.mark.parametrize("root", [1.0, 2.0, 20.0, 1e-5, 3e80])
def test_cubes_have_their_roots(root: float) -> None:
    assert cube_root(root**3) == pytest.approx(root, rel=1.1e-15)


def test_the_root_of_zero_is_zero() -> None:
    assert cube_root(0.0) == 0.0


def test_subnormal_numbers_have_a_small_root_that_is_not_negative() -> None:
    for x in (5e-324, 1e-310):
        assert 0.0 <= cube_root(x) < 1e-102


def test_nan_goes_through() -> None:
    assert math.isnan(cube_root(math.nan))


def test_the_root_rises_with_its_argument() -> None:
    x = np.concatenate([[0.0], np.logspace(-300, 300, 50_001), np.linspace(1.0, 8.0, 50_001)])
    x.sort()
    x = np.unique(x)
    roots = np.array([cube_root(float(value)) for value in x])
    assert np.all(np.diff(roots) > 0)


@pytest.mark.parametrize("x", [0.0, 1e-300, 1e-3, 0.7, 1.0, 5.0, 8000.0, 1e300])
def test_compiled_and_plain_python_agree(x: float) -> None:
    assert cube_root(x) == pytest.approx(float(cube_root.py_func(x)), rel=1e-15)
