"""The drive in lanes takes the same steps as the scalar integrator, independently in each lane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from stickslip.compiled.decorators import inline
from stickslip.compiled.simd import LANES
from stickslip.numerics import step_control
from stickslip.numerics.adaptive import OK, make_adaptive
from stickslip.numerics.adaptive_lanes import Slots, make_attempt, slots_for
from stickslip.numerics.lane_array import lane_array
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2

START = (0.4, 1.0, 0.7)
SLOTS = slots_for(3, 1)
STATE, OLD = (list(range(first, first + 3)) for first in (SLOTS.state, SLOTS.old))

_get = lane_array(LANES).get


@inline
def rhs(p, t, y):
    """The rotation of a rigid body about all its axes, faster and faster."""
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
def unit_weight(p, y, y1, J):
    return 1.0, 1.0, 1.0


@inline
def count(p, t, h, y0, y1, d1, d2, record):
    record[0] += 1.0


@inline
def speed(values, lane):
    return _get(values, SLOTS.parameters, lane)


attempt = make_attempt(rhs, jacobian, unit_weight, speed, RODAS4P2, algebra(3), 1)
scalar = make_adaptive(rhs, jacobian, unit_weight, count, RODAS4P2, algebra(3))


def loaded(
    speeds: np.ndarray,
    rtols: np.ndarray,
    ends: np.ndarray,
    h: float = 1e-3,
    longest: float = np.inf,
) -> np.ndarray:
    """Lanes at the start, with one problem in each."""
    table = np.zeros((SLOTS.total, LANES))
    for slot, value in (
        (SLOTS.end, ends), (SLOTS.step, h), (SLOTS.rtol, rtols), (SLOTS.grows, 1.0),
        (SLOTS.remembered, step_control.START), (SLOTS.limit, np.inf), (SLOTS.longest, longest),
        (SLOTS.parameters, speeds),
        *zip(STATE, START, strict=True),
    ):  # fmt: skip
        table[slot] = value
    return table.ravel()


def table_of(values: np.ndarray) -> np.ndarray:
    return values.reshape(-1, LANES)


SPEEDS = np.linspace(0.3, 3.0, LANES)
RTOLS = 10.0 ** -np.linspace(3.0, 9.0, LANES)
ENDS = np.linspace(9.0, 1.0, LANES)


def attempts_to_the_end(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The attempts and states of all lanes at their ends."""
    used, states = np.zeros(LANES), np.zeros((LANES, 3))
    for number in range(1, 5000):
        attempt(values)
        table = table_of(values)
        there = (table[SLOTS.time] >= table[SLOTS.end]) & (used == 0)
        used[there] = number
        states[there] = table[STATE].T[there]
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
    np.testing.assert_array_equal(table[STATE].T, states)
    np.testing.assert_array_equal(table[SLOTS.time], ENDS)


def test_lanes_do_not_affect_each_other() -> None:
    together = attempts_to_the_end(loaded(SPEEDS, RTOLS, ENDS))
    for lane in (0, 5, LANES - 1):
        ones = np.ones(LANES)
        alone = attempts_to_the_end(loaded(SPEEDS[lane] * ones, RTOLS[lane] * ones, ENDS[lane]))
        assert alone[0][0] == together[0][lane]
        np.testing.assert_array_equal(alone[1][(lane + 3) % LANES], together[1][lane])


def test_no_step_after_the_first_is_longer_than_the_longest() -> None:
    values, longest = loaded(SPEEDS, RTOLS, ENDS, longest=2e-3), 0.0
    for _ in range(50):
        attempt(values)
        used = table_of(values)[SLOTS.used].max()
        assert used <= 2e-3
        longest = max(longest, used)
    assert longest == 2e-3


def test_events_are_arrival_limit_and_rounding() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS)
    table = table_of(values)
    table[SLOTS.limit, 2] = 4.0
    table[SLOTS.state, 7] = math.nan
    seen: dict[int, int] = {}
    for number in range(1, 2000):
        attempt(values)
        for lane in np.flatnonzero(table[SLOTS.event] > 0).tolist():
            seen.setdefault(lane, number)
        if len(seen) == LANES:
            break
    assert seen[2] == 4
    assert table[SLOTS.stuck, 7] == 1.0
    assert table[SLOTS.time, 7] == 0.0
    assert table[SLOTS.attempts, 7] >= 100.0 / math.log2(10.0)  # a quarter each time, to rounding
    others = [lane for lane in range(LANES) if lane not in (2, 7)]
    assert np.all(table[SLOTS.time][others] == ENDS[others])
    assert np.all(table[SLOTS.stuck][others] == 0.0)


def test_the_last_attempted_step_is_stored_for_its_continuous_extension() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS)
    table: Any = table_of(values)
    for _ in range(12):
        before = table[[SLOTS.time, *STATE]].copy()
        attempt(values)
        np.testing.assert_array_equal(table[[SLOTS.begin, *OLD]], before)
        accepted = table[SLOTS.accepted] > 0
        moved = table[SLOTS.time] > before[0]
        np.testing.assert_array_equal(accepted, moved)
        np.testing.assert_allclose(
            (table[SLOTS.begin] + table[SLOTS.used])[accepted],
            table[SLOTS.time][accepted],
            rtol=1e-15,
        )


def test_after_a_rejection_an_accepted_step_does_not_grow() -> None:
    values = loaded(SPEEDS, RTOLS, ENDS, 1e-5)
    table = table_of(values)
    table[SLOTS.grows, ::2] = 0.0  # as a rejection leaves it
    attempt(values)
    assert np.all(table[SLOTS.accepted] == 1.0)
    assert np.all(table[SLOTS.grows] == 1.0)
    assert np.all(table[SLOTS.step, ::2] == 1e-5)
    assert np.all(table[SLOTS.step, 1::2] > 1.1e-5)


# --- the layout ----------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_the_slots_of_a_lane_do_not_overlap(width: int) -> None:
    slots = slots_for(width, 7)
    vectors = ("state", "old", "d1", "d2")
    taken = [
        getattr(slots, name) + i
        for name in Slots._fields
        for i in range(width if name in vectors else 7 if name == "parameters" else 1)
    ]
    assert taken == list(range(slots.total + 1))  # no gap either
