"""The drive in lanes against the scalar drive: the same steps, each lane on its own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from stickslip.compiled.decorators import inline
from stickslip.compiled.simd import LANES
from stickslip.numerics import adaptive_lanes as lanes
from stickslip.numerics import step_control
from stickslip.numerics.adaptive import OK, make_adaptive
from stickslip.numerics.tableaus import RODAS4P2

START = (0.4, 1.0, 0.7)


@inline
def rhs(p, t, y):
    """A rigid body that turns about all its axes, faster and faster."""
    a, b, c = y
    s = p * (1.0 + 0.1 * t)
    return s * b * c, -s * a * c, -0.51 * s * a * b


@inline
def jacobian(p, t, y):
    a, b, c = y
    s, s_t = p * (1.0 + 0.1 * t), 0.1 * p
    return (
        (0.0, s * c, s * b),
        (-s * c, 0.0, -s * a),
        (-0.51 * s * b, -0.51 * s * a, 0.0),
        (s_t * b * c, -s_t * a * c, -0.51 * s_t * a * b),
    )


@inline
def unit_weight(p, y, J):
    return 1.0, 1.0, 1.0


@inline
def count(p, t, h, y0, y1, d1, d2, record):
    record[0] += 1.0


@inline
def speed(values, lane):
    return lanes.at(values, lanes.PARAMETERS, lane)


attempt = lanes.make_attempt(rhs, jacobian, unit_weight, speed, RODAS4P2)
scalar = make_adaptive(rhs, jacobian, unit_weight, count, RODAS4P2)


def loaded(speeds: np.ndarray, rtols: np.ndarray, ends: np.ndarray, h: float = 1e-3) -> np.ndarray:
    """Lanes at the start, one problem in each."""
    table = np.zeros((lanes.PARAMETERS + 1, LANES))
    for slot, value in (
        (lanes.END, ends), (lanes.STEP, h), (lanes.RTOL, rtols), (lanes.GROWS, 1.0),
        (lanes.REMEMBERED, step_control.START), (lanes.LIMIT, np.inf), (lanes.PARAMETERS, speeds),
        (lanes.Y0, START[0]), (lanes.Y1, START[1]), (lanes.Y2, START[2]),
    ):  # fmt: skip
        table[slot] = value
    return table.ravel()


def table_of(values: np.ndarray) -> np.ndarray:
    return values.reshape(-1, LANES)


SPEEDS = np.linspace(0.3, 3.0, LANES)
RTOLS = 10.0 ** -np.linspace(3.0, 9.0, LANES)
ENDS = np.linspace(9.0, 1.0, LANES)


def attempts_to_the_end(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Attempts and states of all lanes when each has arrived."""
    used, states = np.zeros(LANES), np.zeros((LANES, 3))
    for number in range(1, 5000):
        attempt(values)
        table = table_of(values)
        there = (table[lanes.TIME] >= table[lanes.END]) & (used == 0)
        used[there] = number
        states[there] = table[[lanes.Y0, lanes.Y1, lanes.Y2]].T[there]
        if np.all(used > 0):
            return used, states
    raise AssertionError("a lane does not arrive")


@pytest.mark.parametrize("h", [1e-3, 3.0, 100.0])
def test_every_lane_takes_the_steps_of_the_scalar_drive(h: float) -> None:
    # A first step that is too long is rejected a few times, and may not grow right afterwards.
    used, states = attempts_to_the_end(loaded(SPEEDS, RTOLS, ENDS, h))
    for lane in range(LANES):
        y, _, attempts, status = scalar(
            SPEEDS[lane], RTOLS[lane], 0.0, ENDS[lane], START, h, 10_000, np.zeros(1)
        )
        assert status == OK
        assert used[lane] == attempts
        assert states[lane] == pytest.approx(y, rel=1e-10)


def test_a_lane_that_has_arrived_stays_there() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS)
    _, states = attempts_to_the_end(values)
    table = table_of(values)
    for _ in range(20):
        attempt(values)
    np.testing.assert_array_equal(table[[lanes.Y0, lanes.Y1, lanes.Y2]].T, states)
    np.testing.assert_array_equal(table[lanes.TIME], ENDS)


def test_lanes_do_not_feel_each_other() -> None:
    together = attempts_to_the_end(loaded(SPEEDS, RTOLS, ENDS))
    for lane in (0, 5, LANES - 1):
        ones = np.ones(LANES)
        alone = attempts_to_the_end(loaded(SPEEDS[lane] * ones, RTOLS[lane] * ones, ENDS[lane]))
        assert alone[0][0] == together[0][lane]
        np.testing.assert_array_equal(alone[1][(lane + 3) % LANES], together[1][lane])


def test_events_are_arrival_limit_and_rounding() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS)
    table = table_of(values)
    table[lanes.LIMIT, 2] = 4.0
    table[lanes.Y0, 7] = math.nan
    seen: dict[int, int] = {}
    for number in range(1, 2000):
        attempt(values)
        for lane in np.flatnonzero(table[lanes.EVENT] > 0).tolist():
            seen.setdefault(lane, number)
        if len(seen) == LANES:
            break
    assert seen[2] == 4
    assert table[lanes.STUCK, 7] == 1.0
    assert table[lanes.TIME, 7] == 0.0
    assert table[lanes.ATTEMPTS, 7] >= 100.0 / math.log2(10.0)  # a quarter each time, to rounding
    others = [lane for lane in range(LANES) if lane not in (2, 7)]
    assert np.all(table[lanes.TIME][others] == ENDS[others])
    assert np.all(table[lanes.STUCK][others] == 0.0)


def test_the_step_tried_last_is_there_for_its_continuous_extension() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS)
    table: Any = table_of(values)
    for _ in range(12):
        before = table[[lanes.TIME, lanes.Y0, lanes.Y1, lanes.Y2]].copy()
        attempt(values)
        np.testing.assert_array_equal(
            table[[lanes.FROM, lanes.OLD0, lanes.OLD1, lanes.OLD2]],
            before,
        )
        accepted = table[lanes.ACCEPTED] > 0
        moved = table[lanes.TIME] > before[0]
        np.testing.assert_array_equal(accepted, moved)
        np.testing.assert_allclose(
            (table[lanes.FROM] + table[lanes.USED])[accepted],
            table[lanes.TIME][accepted],
            rtol=1e-15,
        )


def test_after_a_rejection_an_accepted_step_does_not_grow() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS, 1e-5)
    table = table_of(values)
    table[lanes.GROWS, ::2] = 0.0  # as a rejection leaves it
    attempt(values)
    assert np.all(table[lanes.ACCEPTED] == 1.0)
    assert np.all(table[lanes.GROWS] == 1.0)
    assert np.all(table[lanes.STEP, ::2] == 1e-5)
    assert np.all(table[lanes.STEP, 1::2] > 1.1e-5)
