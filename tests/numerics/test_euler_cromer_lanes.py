"""Euler-Cromer in lanes: the exact map of one step, a true sine, queues, budgets and NaN."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import sine_and_cosine
from stickslip.numerics.adaptive import DIVERGED, OK
from stickslip.numerics.euler_cromer_lanes import (
    CHANGE,
    DRIVE,
    PENDING,
    STEPS_BETWEEN_CHECKS,
    TURN,
    WIDTH,
    Chance,
    Tasks,
    V,
    W,
    X,
    first_free,
    get,
    make_euler_cromer_lanes,
    put,
)

SPRING, LOSS, ANGLE, SEEN, LARGEST, SLOTS = range(first_free(1), first_free(1) + 6)
PLENTY = 10**12


class System(NamedTuple):
    spring: float
    loss: float
    angle: float


@inline
def parameters(lanes, lane):
    return System(get(lanes, SPRING, lane), get(lanes, LOSS, lane), get(lanes, ANGLE, lane))


@inline
def increments(p, drive, y, xi):
    x, v, w = y
    return p.spring * (drive - x) - p.loss * v * w, p.loss * (x - w)


@inline
def write_down(p, drive, y, lanes, lane):
    put(lanes, SEEN, lane, get(lanes, SEEN, lane) + 1.0)
    largest = get(lanes, LARGEST, lane)
    put(lanes, LARGEST, lane, max(y[0], largest))


@inline
def sine(p, n):
    slope = sine_and_cosine(p.angle * (n - 0.5))[1]
    return sine_and_cosine(p.angle * n)[0], 2.0 * math.sin(0.5 * p.angle) * slope


march = make_euler_cromer_lanes(parameters, increments, write_down, (sine,), SLOTS)


def tasks_of(systems, steps, start=(1.0, 2.0**-10, 0.5)) -> Tasks:
    """One row for each (spring, loss, angle)."""
    rows = np.zeros((len(systems), SLOTS))
    rows[:, [X, V, W]] = start
    rows[:, SPRING : ANGLE + 1] = systems
    rows[:, TURN] = 4.0 * np.sin(0.5 * rows[:, ANGLE]) ** 2
    rows[:, LARGEST] = -np.inf
    count = len(systems)
    total = np.broadcast_to(steps, count).astype(np.int64)
    return Tasks(rows, np.zeros(count, np.int64), total, np.full(count, PENDING))


def run(tasks: Tasks, budget: int = PLENTY) -> Tasks:
    assert march(tasks, np.arange(len(tasks.rows)), budget) >= 0
    return tasks


def many(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Different systems with different numbers of steps, around the number between two checks."""
    rng = np.random.default_rng(seed)
    systems = np.column_stack(
        [
            rng.uniform(1e-6, 1e-4, count),
            rng.uniform(1e-4, 1e-2, count),
            rng.uniform(1e-4, 0.1, count),
        ]
    )
    return systems, rng.integers(1, 3 * STEPS_BETWEEN_CHECKS, count)


def test_one_step_moves_v_first_and_x_with_the_new_v() -> None:
    tasks = run(tasks_of([(0.25, 0.5, 0.0)], 1))
    new_v = 2.0**-10 - 0.25 * 1.0 - 0.5 * 2.0**-10 * 0.5
    assert tuple(tasks.rows[0, [X, V, W]]) == (1.0 + new_v, new_v, 0.5 + 0.5 * (1.0 - 0.5))
    assert (tasks.done[0], tasks.status[0]) == (1, OK)


GROUP, LEFT = SLOTS, SLOTS + 1


@inline
def random_increments(p, drive, y, xi):
    return 0.0, xi


@inline
def refresh(lane, lanes):
    put(lanes, GROUP, lane, get(lanes, GROUP, lane) + 1.0)
    put(lanes, LEFT, lane, 0.0)


@inline
def draw(lanes, lane):
    drawn = get(lanes, LEFT, lane) + 1.0
    put(lanes, LEFT, lane, drawn)
    return 100.0 * get(lanes, GROUP, lane) + drawn


def test_random_numbers_come_in_groups_of_steps_with_any_budget() -> None:
    chance = Chance(32, refresh, draw)
    march = make_euler_cromer_lanes(
        parameters, random_increments, write_down, (sine,), SLOTS + 2, chance
    )
    rng = np.random.default_rng(1)
    steps = 32 * rng.integers(1, 300, 2 * WIDTH)
    expected = 0.5 + 100.0 * 32 * (groups := steps // 32) * (groups + 1) / 2 + groups * 33 * 16
    for budget in (PLENTY, 32, 32 * 77):
        tasks = tasks_of(np.full((2 * WIDTH, 3), 0.1), steps)
        rows = np.zeros((2 * WIDTH, SLOTS + 2))
        rows[:, :SLOTS] = tasks.rows
        tasks = tasks._replace(rows=rows)
        while np.any(tasks.status == PENDING):
            march(tasks, np.arange(2 * WIDTH), budget)
        np.testing.assert_array_equal(tasks.rows[:, W], expected)


def test_the_third_variable_is_reflected_at_zero() -> None:
    tasks = run(tasks_of([(0.0, 0.5, 0.0)], 1, start=(-7.0, 0.0, 0.5)))
    assert tasks.rows[0, W] == -(0.5 + 0.5 * (-7.0 - 0.5))


@pytest.mark.parametrize("angle", [1e-9, 3.1e-5, 1e-3, 0.05])
def test_the_drive_stays_a_sine(angle: float) -> None:
    steps = min(50 * STEPS_BETWEEN_CHECKS - 1, int(6.2 / angle))  # a period at most
    tasks = run(tasks_of([(1e-3, 1e-3, angle)], steps))
    assert tasks.rows[0, DRIVE] == pytest.approx(math.sin(angle * steps), abs=3e-13)


def test_the_drive_is_set_right_before_its_roundings_add_up() -> None:
    # A second difference that is wrong by a part in 1e6 is kept within bounds by the sine itself.
    tasks = tasks_of([(1e-3, 1e-3, 1e-3)], 200 * STEPS_BETWEEN_CHECKS - 1)
    tasks.rows[0, TURN] *= 1.0 + 1e-6
    run(tasks)
    assert tasks.rows[0, DRIVE] == pytest.approx(math.sin(1e-3 * tasks.total[0]), abs=1e-5)


def test_steps_agree_with_a_plain_loop() -> None:
    spring, loss, angle = 2e-5, 3e-3, 4e-3
    tasks = run(tasks_of([(spring, loss, angle)], 5000))
    x, v, w, largest = 1.0, 2.0**-10, 0.5, -np.inf
    for n in range(5000):
        largest = max(largest, x)
        dv, dw = spring * (math.sin(angle * n) - x) - loss * v * w, loss * (x - w)
        v += dv
        x += v
        w = abs(w + dw)
    np.testing.assert_allclose(tasks.rows[0, [X, V, W]], [x, v, w], atol=1e-12)
    assert tasks.rows[0, SEEN] == 5000
    assert tasks.rows[0, LARGEST] == pytest.approx(largest, rel=1e-11)


@pytest.mark.parametrize("count", [1, 15, 17, WIDTH, WIDTH + 1, 3 * WIDTH + 5])
def test_a_row_does_not_depend_on_the_other_lanes(count: int) -> None:
    systems, steps = many(count)
    together = run(tasks_of(systems, steps))
    assert np.all(together.status == OK)
    np.testing.assert_array_equal(together.done, steps)
    for i in {0, count // 2, count - 1}:
        alone = run(tasks_of(systems[i : i + 1], steps[i : i + 1]))
        np.testing.assert_array_equal(together.rows[i], alone.rows[0])
    order = np.random.default_rng(1).permutation(count)
    shuffled = run(tasks_of(systems[order], steps[order]))
    np.testing.assert_array_equal(shuffled.rows, together.rows[order])


@pytest.mark.parametrize("budget", [1, 777, STEPS_BETWEEN_CHECKS])
def test_results_do_not_depend_on_where_a_budget_ends(budget: int) -> None:
    systems, steps = many(WIDTH + 9)
    if budget == 1:
        steps %= 50
        steps += 1
    whole, parts = run(tasks_of(systems, steps)), tasks_of(systems, steps)
    while np.any(parts.status == PENDING):
        run(parts, budget)
    np.testing.assert_array_equal(parts.rows, whole.rows)
    np.testing.assert_array_equal(parts.done, steps)


def test_a_budget_is_never_exceeded_and_the_rest_is_returned() -> None:
    tasks = tasks_of([(1e-3, 1e-3, 1e-3)] * 3, 1000)
    assert march(tasks, np.arange(3), 300) == 0
    assert tasks.done.tolist() == [300] * 3
    assert march(tasks, np.arange(3), 1000) == 300
    assert tasks.status.tolist() == [OK] * 3
    assert march(tasks, np.arange(3), 1000) == 1000


def test_only_pending_rows_of_the_queue_are_marched() -> None:
    tasks = tasks_of([(1e-3, 1e-3, 1e-3)] * 4, 1000)
    tasks.status[1] = OK
    before = tasks.rows.copy()
    march(tasks, np.array([0, 1]), PLENTY)
    assert tasks.done.tolist() == [1000, 0, 0, 0]
    assert tasks.status.tolist() == [OK, OK, PENDING, PENDING]
    np.testing.assert_array_equal(tasks.rows[1:], before[1:])


@pytest.mark.parametrize("bad", [math.nan, math.inf, 1e3])
def test_a_state_that_stops_being_finite_ends_its_row_soon_and_no_other(bad: float) -> None:
    systems, steps = many(2 * WIDTH)
    alone = run(tasks_of(np.delete(systems, 40, axis=0), np.delete(steps, 40)))
    systems[40, 0], steps[40] = bad, 10 * STEPS_BETWEEN_CHECKS  # a spring that explodes
    tasks = run(tasks_of(systems, steps))
    assert tasks.status[40] == DIVERGED
    assert tasks.done[40] <= STEPS_BETWEEN_CHECKS
    assert np.all(np.delete(tasks.status, 40) == OK)
    np.testing.assert_array_equal(np.delete(tasks.rows, 40, axis=0), alone.rows)


def test_a_state_that_stops_being_finite_in_the_last_steps_diverges() -> None:
    assert run(tasks_of([(1e3, 0.0, 0.0)], 200)).status[0] == DIVERGED


def test_a_start_that_is_not_finite_diverges_at_once() -> None:
    tasks = run(tasks_of([(1e-3, 1e-3, 1e-3)], 100, start=(math.nan, 0.0, 0.0)))
    assert (tasks.done[0], tasks.status[0]) == (0, DIVERGED)


def test_the_change_of_the_drive_belongs_to_the_last_step() -> None:
    tasks = run(tasks_of([(1e-3, 1e-3, 0.1)], 9))
    expected = math.sin(0.9) - math.sin(0.8)
    assert tasks.rows[0, CHANGE] == pytest.approx(expected, rel=1e-13)
