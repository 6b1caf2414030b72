"""Elementary functions without library calls: their stated errors, NaN, extremes, exactness.

A unit in the last place is 1.1e-16, as in the module.
"""

import math
from typing import Any

import numpy as np
import pytest

from stickslip.compiled.decorators import jit_making_arrays
from stickslip.compiled.elementary import (
    cube_root,
    exponentials,
    inverse_cube_root,
    logarithm,
    power,
    reciprocal,
    sine_and_cosine,
)

ULP = 1.1e-16

# Errors are measured with a mantissa of 64 bits, where a double has 53.
wide = np.longdouble
needs_wide = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1.1e-19, reason="no type wider than a double on this machine"
)

RNG = np.random.default_rng(20130720)
EXPONENTS = 10.0 ** RNG.uniform(-300.0, 300.0, 50_000)
PHASES = np.linspace(1.0, 8.0, 50_001)  # three exponents, the period of the guesses of the roots


@jit_making_arrays
def _column(function: Any, x: np.ndarray) -> np.ndarray:
    values = np.empty(x.shape[0])
    for i in range(x.shape[0]):
        values[i] = function(x[i])
    return values


@jit_making_arrays
def _pair_of_columns(function: Any, x: np.ndarray) -> np.ndarray:
    values = np.empty((2, x.shape[0]))
    for i in range(x.shape[0]):
        values[0, i], values[1, i] = function(x[i])
    return values


def ulps(values: np.ndarray, exact: np.ndarray) -> float:
    """Return the largest relative error in units in the last place."""
    return float(np.max(np.abs((values - exact) / exact))) / ULP


# --- roots ---------------------------------------------------------------------------------------


@needs_wide
@pytest.mark.parametrize("x", [EXPONENTS, PHASES], ids=["exponents", "phases"])
def test_roots_and_reciprocals_are_as_exact_as_stated(x: np.ndarray) -> None:
    exact = wide(x)
    assert ulps(_column(inverse_cube_root, x), 1 / np.cbrt(exact)) < 2
    assert ulps(_column(cube_root, x), np.cbrt(exact)) < 5
    assert ulps(_column(reciprocal, x), 1 / exact) < 2.1


def test_roots_of_zero_and_of_subnormal_numbers() -> None:
    assert cube_root(0.0) == 0.0
    assert 1e100 < inverse_cube_root(0.0) < 1e150
    for x in (5e-324, 1e-310):
        assert 0.0 <= cube_root(x) < 1e-102


@pytest.mark.parametrize("scale", [2.0**-900, 2.0**-3, 2.0**3, 2.0**900])
def test_powers_of_eight_scale_roots_exactly(scale: float) -> None:
    for x in PHASES[::500].tolist():
        assert cube_root(x * scale) == cube_root(x) * round_root(scale)
        assert inverse_cube_root(x * scale) == inverse_cube_root(x) / round_root(scale)


def round_root(scale: float) -> float:
    return 2.0 ** (math.log2(scale) / 3)


def test_the_root_is_monotonic() -> None:
    x = np.concatenate([[0.0], np.logspace(-300, 300, 50_001), PHASES])
    roots = _column(cube_root, np.unique(x))
    assert np.all(np.diff(roots) > 0)


# --- exponentials and the logarithm --------------------------------------------------------------

MODERATE = np.concatenate(
    [
        RNG.uniform(-345.0, 345.0, 50_000),
        RNG.uniform(-1.0, 1.0, 50_000),
        RNG.uniform(-40, 2, 50_000),
    ]
)


@needs_wide
def test_exponentials_are_exact_to_4_ulp() -> None:
    rising, falling = _pair_of_columns(exponentials, MODERATE)
    assert ulps(rising, np.exp(wide(MODERATE))) < 4
    assert ulps(falling, np.exp(-wide(MODERATE))) < 4


def test_exponentials_of_opposite_arguments_are_exchanged_bit_for_bit() -> None:
    rising, falling = _pair_of_columns(exponentials, MODERATE)
    np.testing.assert_array_equal(_pair_of_columns(exponentials, -MODERATE), [falling, rising])


def test_exponentials_are_cut_off_where_their_squares_are_still_normal() -> None:
    for x in (345.0, 346.0, 1e300, math.inf):
        assert exponentials(x) == exponentials(345.0)
        assert exponentials(-x) == exponentials(-345.0)
    large, small = exponentials(345.0)
    assert small * small > 2.3e-308
    assert large * large < 1e308
    assert exponentials(344.9) != exponentials(345.0)


def test_the_exponential_of_zero_is_one() -> None:
    assert exponentials(0.0) == exponentials(-0.0) == (1.0, 1.0)


@needs_wide
def test_the_logarithm_is_as_exact_as_stated() -> None:
    for x in (EXPONENTS, np.linspace(0.5, 2.0, 50_001)):
        exact = np.log(wide(x))
        error = np.abs(_column(logarithm, x) - exact)
        assert np.all((error <= 2e-16) | (error <= 2 * ULP * np.abs(exact)))


def test_logarithms_of_zero_one_and_powers_of_two() -> None:
    assert logarithm(1.0) == 0.0
    assert logarithm(0.0) == pytest.approx(-709.0, abs=0.5)
    for n in (-1022, -1, 1, 52, 1023):
        assert logarithm(2.0**n) == pytest.approx(n * math.log(2.0), rel=2 * ULP)


# --- the general power ---------------------------------------------------------------------------


@needs_wide
def test_the_error_of_a_power_is_proportional_to_its_logarithm() -> None:
    # Both the logarithm and its product with the exponent are rounded.
    x, exponents = 10.0 ** RNG.uniform(-60, 60, 20_000), RNG.uniform(0.01, 3.0, 20_000)
    logarithms = exponents * np.log(wide(x))
    values = np.array([power(a, b) for a, b in zip(x.tolist(), exponents.tolist(), strict=True)])
    normal = np.abs(logarithms) < 340
    error = np.abs(values / np.exp(logarithms) - 1)[normal]
    assert np.all(error <= 2.5e-16 * (1 + np.abs(logarithms[normal])))


def test_the_power_of_zero_is_zero_and_tiny_powers_are_nearly_zero() -> None:
    assert power(0.0, 0.3) == power(0.0, 3.0) == 0.0
    assert 0.0 <= power(1e-300, 0.9) < 1e-149
    assert 0.0 <= power(5e-324, 1.0) < 1e-149


# --- sine and cosine -----------------------------------------------------------------------------


@needs_wide
@pytest.mark.parametrize(("largest", "bound"), [(4.0, 2e-16), (100.0, 2e-16), (1e5, 1e-15)])
def test_sine_and_cosine_are_as_exact_as_stated(largest: float, bound: float) -> None:
    x = RNG.uniform(-largest, largest, 50_000)
    sine, cosine = _pair_of_columns(sine_and_cosine, x)
    assert np.max(np.abs(sine - np.sin(wide(x)))) < bound
    assert np.max(np.abs(cosine - np.cos(wide(x)))) < bound


def test_sine_is_odd_and_cosine_even_bit_for_bit() -> None:
    x = np.linspace(0.0, 20.0, 10_001)
    sine, cosine = _pair_of_columns(sine_and_cosine, x)
    np.testing.assert_array_equal(_pair_of_columns(sine_and_cosine, -x), [-sine, cosine])


def test_sine_and_cosine_at_the_quarters_of_a_turn() -> None:
    assert sine_and_cosine(0.0) == (0.0, 1.0)
    for quarter, expected in enumerate([(0, 1), (1, 0), (0, -1), (-1, 0), (0, 1)]):
        found = sine_and_cosine(quarter * math.pi / 2)
        assert found == pytest.approx(expected, abs=1e-15)


# --- all of them ---------------------------------------------------------------------------------

SCALAR = [inverse_cube_root, cube_root, reciprocal, logarithm]
PAIRS = [exponentials, sine_and_cosine]


def test_nan_is_propagated() -> None:
    for function in (*SCALAR, *PAIRS):
        assert np.all(np.isnan(function(math.nan))), function.__name__
    assert math.isnan(power(math.nan, 0.5))
    assert math.isnan(power(0.3, math.nan))


@pytest.mark.parametrize("function", [*SCALAR, *PAIRS], ids=lambda function: function.__name__)
@pytest.mark.parametrize("x", [1e-300, 1e-3, 0.7, 1.0, 5.0, 300.0])
def test_compiled_and_plain_python_agree(function: Any, x: float) -> None:
    with np.errstate(over="ignore"):  # unsigned bits wrap around, by design
        plain = np.ravel(function.py_func(x)).astype(float)
    assert np.ravel(function(x)) == pytest.approx(plain, rel=1e-15, abs=2e-16)


def test_no_function_calls_a_library() -> None:
    assembly = "".join(
        text
        for function in (*SCALAR, *PAIRS, power)
        for text in function.alone.inspect_asm().values()
    )
    assert assembly
    for name in ("cbrt", "pow", "exp", "log", "sin", "cos"):
        assert f"callq\t{name}\n" not in assembly
        assert f"${name}, " not in assembly
