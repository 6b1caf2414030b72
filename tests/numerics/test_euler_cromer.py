"""Euler-Cromer: the exact map of one step, first order, bounded energy, budgets and NaN."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip.compiled.decorators import inline
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.numerics.euler_cromer import make_euler_cromer

OSCILLATOR, FORCED, EXPLODES, NAN_FROM_HALF, NEGATIVE = map(float, range(5))
START = (1.0, 0.25, 0.5)
PLENTY = 10**9


@inline
def increments(p, t, dt, y, xi):
    x, v, w = y
    if p == OSCILLATOR:
        return -dt * x, dt * (x + v - w)
    if p == FORCED:
        return dt * (math.cos(3.0 * t) - x - 0.3 * v * w), dt * (x * x - w)
    if p == EXPLODES:
        return dt * 1e6 * v, 0.0
    if p == NEGATIVE:
        return 0.0, -2.0 * dt
    return dt * math.sqrt(0.5 - t), 0.0


@inline
def write_down(p, t, dt, y0, y1, record):
    """Row n of the record: t, dt, the state before and after step n; row 0 counts."""
    n = int(record[0, 0]) + 1
    record[0, 0] = n
    if n < record.shape[0]:
        row = record[n]
        row[0], row[1] = t, dt
        row[2], row[3], row[4] = y0[0], y0[1], y0[2]
        row[5], row[6], row[7] = y1[0], y1[1], y1[2]


compiled = make_euler_cromer(increments, write_down)


def march(p: float, end: float, steps: int, y=START, begin=0.0, budget=PLENTY, rows=0) -> Any:
    record = np.zeros((rows + 1, 8))
    y, done, status = compiled(p, begin, end, steps, y, budget, record)
    return (y, done, status) if rows == 0 else (y, done, status, record)


def test_a_random_number_is_drawn_for_every_step() -> None:
    @inline
    def random_increments(p, t, dt, y, xi):
        return 0.0, xi

    @inline
    def ignore(p, t, dt, y0, y1, record):
        pass

    @inline
    def draw(record):
        record[0] += 1.0
        return record[0]

    drawn = np.zeros(1)
    (_, _, w), done, status = make_euler_cromer(random_increments, ignore, draw)(
        0.0, 0.0, 1.0, 5, START, PLENTY, drawn
    )
    assert (w, done, status, drawn[0]) == (0.5 + 1 + 2 + 3 + 4 + 5, 5, OK, 5.0)


def test_one_step_moves_v_first_and_x_with_the_new_v() -> None:
    x, v, w = START
    dt = 0.125
    y, done, status = march(OSCILLATOR, dt, 1)
    new_v = v - dt * x
    assert (done, status) == (1, OK)
    assert y == (x + dt * new_v, new_v, w + dt * (x + v - w))


def test_the_third_variable_is_reflected_at_zero() -> None:
    y, _, _ = march(NEGATIVE, 1.0, 1, y=(0.0, 0.0, 0.5))
    assert y[2] == 1.5


def test_the_error_is_of_first_order() -> None:
    reference = solve_ivp(
        lambda t, y: [y[1], *increments.py_func(FORCED, t, 1.0, y, 0.0)],
        (0.0, 2.0),
        START,
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
    ).y[:, -1]
    counts = [500, 1000, 2000, 4000]
    errors = [float(np.abs(np.array(march(FORCED, 2.0, n)[0]) - reference).max()) for n in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.2)


def test_every_step_is_seen_and_they_join() -> None:
    _, done, _, record = march(FORCED, 3.0, 12, begin=1.5, rows=12)
    assert done == record[0, 0] == 12
    steps = record[1:]
    assert steps[:, 0] == pytest.approx(1.5 + 0.125 * np.arange(12), rel=1e-15)
    assert np.all(steps[:, 1] == 0.125)
    assert tuple(steps[0, 2:5]) == START
    assert np.array_equal(steps[1:, 2:5], steps[:-1, 5:8])


def test_a_spent_budget_is_reported_and_never_exceeded() -> None:
    y, done, status = march(FORCED, 2.0, 100, budget=7)
    assert (done, status) == (7, STEP_LIMIT)
    assert y == march(FORCED, 0.14, 7)[0]


def test_a_budget_that_just_suffices_is_enough() -> None:
    assert march(FORCED, 2.0, 100, budget=100)[1:] == (100, OK)
    assert march(FORCED, 2.0, 100, budget=99)[2] == STEP_LIMIT


@pytest.mark.parametrize("p", [EXPLODES, NAN_FROM_HALF])
def test_a_state_that_stops_being_finite_ends_the_drive_soon(p: float) -> None:
    # Both are not finite before step 100 000 or so of a million.
    begin = 0.0 if p == EXPLODES else 0.45
    y, done, status = march(p, begin + 1.0, 1_000_000, begin=begin)
    assert status == DIVERGED
    assert done < 100_000
    assert not np.all(np.isfinite(y))


def test_a_state_that_stops_being_finite_in_the_last_steps_diverges() -> None:
    assert march(NAN_FROM_HALF, 1.0, 50)[2] == DIVERGED


def test_a_start_that_is_not_finite_diverges_at_once() -> None:
    assert march(FORCED, 2.0, 100, y=(math.nan, 0.0, 0.0))[1:] == (0, DIVERGED)
