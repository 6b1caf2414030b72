"""Step control: the law, its limits, and what NaN and infinity do."""

import math

import numpy as np
import pytest

from stickslip.numerics import step_control as control


def test_the_inverse_fourth_root_is_good_enough_for_a_step() -> None:
    for x in np.logspace(-300, 300, 20_001).tolist() + np.linspace(1, 16, 2001).tolist():
        assert control.inverse_fourth_root(x) == pytest.approx(x**-0.25, rel=5e-5)


@pytest.mark.parametrize(
    ("error", "factor"), [(1.0, 0.9), (16.0, 0.45), (1e8, 0.1), (1e300, 0.1), (1.5, 0.81324)]
)
def test_after_a_rejection_the_step_follows_the_fourth_root(error: float, factor: float) -> None:
    assert control.after_rejection(error) == pytest.approx(factor, rel=5e-5)


def test_after_nan_the_step_is_a_quarter_and_after_infinity_no_nan() -> None:
    assert control.after_rejection(math.nan) == 0.25
    assert 0.1 <= control.after_rejection(math.inf) <= 0.25


def test_after_a_rejection_a_step_always_shrinks() -> None:
    for error in np.logspace(0.0, 300.0, 1001):
        assert 0.1 <= control.after_rejection(float(error)) <= 0.90002


@pytest.mark.parametrize("error", [1e-4, 1e-2, 0.3, 1.0])
@pytest.mark.parametrize("before", [1e-4, 1e-2, 0.3, 1.0])
def test_after_a_success_error_and_history_count_with_their_exponents(
    error: float, before: float
) -> None:
    _, remembered = control.after_success(before, control.START)
    factor, _ = control.after_success(error, remembered)
    law = 0.9 * error ** (-1 / 8) * before ** (1 / 16)
    assert factor == pytest.approx(min(max(law, 0.1), 6.0), rel=1e-4)


def test_the_memory_is_the_sixteenth_root_of_the_error() -> None:
    for error in (1e-9, 1e-4, 0.5, 1.0):
        assert control.after_success(error, 1.0)[1] == pytest.approx(error ** (1 / 16), rel=1e-4)


@pytest.mark.parametrize("error", [0.0, 1e-300, 1e-12])
def test_after_a_success_without_error_the_step_grows_within_limits(error: float) -> None:
    factor, remembered = control.after_success(error, 1.0)
    assert factor == 6.0
    assert remembered == pytest.approx(1e-10 ** (1 / 16), rel=1e-4)
    # ... and the next one is not held back for long.
    assert control.after_success(error, remembered)[0] > 2.0


def test_the_control_converges_to_a_constant_error() -> None:
    h, remembered, error = 1.0, control.START, math.nan
    for _ in range(60):
        error = 3e-3 * h**4
        if error > 1.0:
            h *= control.after_rejection(error)
            continue
        factor, remembered = control.after_success(error, remembered)
        h *= factor
    assert error == pytest.approx(0.9**16, rel=1e-3)
