"""The progress of a sweep: counts, points in flight, and the time that the rest takes."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.sweeps.watching import Clock, advanced, block_of, found, task

from stickslip.dispatch.in_flight import InFlight
from sweeps.engine.progress import Counts, stop_text
from sweeps.engine.signals import Stop


def line(counts: Counts) -> str:
    """A line of a log."""
    return ", ".join(filter(None, (counts.headline, counts.outlook)))


def test_points_found_and_points_added_by_this_run_are_counted(clock: Clock) -> None:
    store = found(ok=30, diverged=2)
    counts = Counts(100, store)
    clock.now += 77.0  # compiling
    workers = 1
    counts.begin(lambda: workers)
    assert (counts.total, counts.computed) == (100, 0)
    assert (counts.done, counts.left, counts.failed) == (32, 68, 2)
    assert (counts.seconds, counts.rate, counts.seconds_left) == (0.0, 0.0, None)
    clock.now += 2.0
    advanced(counts, store, 3.4, ok=13, not_stationary=4)
    assert (counts.computed, counts.done, counts.left) == (17, 49, 51)
    assert (counts.failed, counts.seconds, counts.rate) == (6, 2.0, 8.5)
    assert counts.seconds_left == pytest.approx(51 * 3.4 / 17)
    workers = 2  # one more has come
    assert counts.seconds_left == pytest.approx(51 * 3.4 / 17 / 2)
    expected = "49/100 points, 6 failed, 0:02 elapsed, 8.5 points/s, about 5.1 s left"
    assert line(counts) == expected
    advanced(counts, store, ok=51)
    assert (counts.left, counts.seconds_left) == (0, None)
    assert line(counts) == "100/100 points, 6 failed, 0:02 elapsed, 34.0 points/s"


def test_a_heartbeat_has_the_same_numbers(clock: Clock) -> None:
    store = found(ok=1)
    counts = Counts(10, store)
    assert counts.as_dict()["seconds_left"] is None
    clock.now += 4.0
    advanced(counts, store, 4.0, ok=1, step_limit=1)
    expected = {
        "points": 10,
        "done": 3,
        "failed": 1,
        "pending": 7,
        "computed": 2,
        "statuses": {"ok": 2, "step_limit": 1},
        "seconds": 4.0,
        "points_per_second": 0.5,
        "seconds_left": 14.0,
        "slots": 1,
    }
    assert counts.as_dict() == expected
    counts.in_flight.begin(task(3, 7))
    clock.now += 30.0  # twice as long as expected
    assert counts.as_dict()["seconds_left"] is None


# --- the time left ---


def computing(clock: Clock, slots: int, flying: list[int], stop: Stop | None = None) -> Counts:
    """A sweep of 100 points that has computed 40, each in half a second, with tasks in flight."""
    store = found()
    counts = Counts(100, store)
    counts.begin(lambda: slots, stop)
    clock.now += 10.0
    advanced(counts, store, 20.0, ok=40)
    counts.in_flight.begin(task(0, 1))
    counts.in_flight.end(block_of(task(0, 1)))  # a block has come back just now
    for number, points in enumerate(flying):
        counts.in_flight.begin(task(100 * number, points))
    return counts


@pytest.mark.parametrize(
    ("slots", "flying", "age", "left"),
    [
        (2, [10, 10], 0.0, 60 * 0.5 / 2),
        (2, [10, 10], 3.0, 60 * 0.5 / 2 - 3.0),  # what is in flight counts as partly done
        (1, [10, 10], 3.0, 60 * 0.5 - 3.0),  # what waits at a worker is not begun
        (8, [60], 0.0, 60 * 0.5),  # the last block takes its own time, however many are idle
    ],
)
def test_the_time_left_counts_blocks_in_flight_as_partly_done(
    clock: Clock, slots: int, flying: list[int], age: float, left: float
) -> None:
    counts = computing(clock, slots, flying)
    clock.now += age
    assert counts.seconds_left == pytest.approx(left)


@pytest.mark.parametrize("flying", [[1], [10, 10], [50, 10], [60]])
def test_the_time_left_never_grows_while_no_block_comes_back(
    clock: Clock, flying: list[int]
) -> None:
    counts, left = computing(clock, 2, flying), []
    for _ in range(200):
        left.append(counts.seconds_left or 0.0)
        clock.now += 1.0
    assert left == sorted(left, reverse=True)
    assert left[-1] >= 0.0


def test_after_a_request_to_stop_the_time_left_is_that_until_the_end(clock: Clock) -> None:
    stop = Stop()
    counts = computing(clock, 2, [10, 10], stop)
    stop.request("enough")
    assert counts.seconds_left == pytest.approx(5.0)
    assert counts.outlook == "stopping, 4.0 points/s, about 5.0 s left, 20 points in flight"


# --- blocks that take long ---


def test_an_overdue_block_shows_its_age_and_no_time_left(clock: Clock) -> None:
    counts = computing(clock, 1, [60])
    clock.now += 29.0
    expected = "1.0 points/s, about 1.0 s left, 60 points in flight, the oldest for 0:29"
    assert counts.outlook == expected
    clock.now += 12.0
    assert counts.outlook == "0.8 points/s, 60 points in flight, the oldest for 0:41"
    assert counts.as_dict()["seconds_left"] is None


def test_a_line_shows_the_age_of_the_first_block(clock: Clock) -> None:
    counts = Counts(1200, found())
    clock.now += 60.0  # compiling
    counts.begin(lambda: 2)
    assert line(counts) == "0/1200 points, 0 failed, 0:00 elapsed"
    counts.in_flight.begin(task(0, 256))
    clock.now += 4.0
    assert line(counts) == "0/1200 points, 0 failed, 0:04 elapsed, 256 points in flight"
    clock.now += 36.0
    assert line(counts) == (
        "0/1200 points, 0 failed, 0:40 elapsed, 256 points in flight, the oldest for 0:40"
    )


# --- what is in flight ---


def test_tasks_are_in_flight_from_their_beginning_to_their_end(clock: Clock) -> None:
    in_flight, first, second = InFlight(), task(0, 3), task(7, 5)
    in_flight.begin(first)
    clock.now += 4.0
    in_flight.begin(second)
    clock.now += 1.0
    assert (in_flight.points, in_flight.ages) == (8, [(3, 5.0), (5, 1.0)])
    for _ in range(2):  # what has come back already changes nothing
        in_flight.end(block_of(first))
    assert (in_flight.points, in_flight.ages) == (5, [(5, 1.0)])


def test_tasks_that_are_given_up_are_forgotten(clock: Clock) -> None:
    in_flight, tasks = InFlight(), [task(0, 1), task(1, 1)]
    for each in tasks:
        in_flight.begin(each)
    assert in_flight.clear() == tasks
    assert (in_flight.points, in_flight.clear()) == (0, [])


def test_a_stop_waits_for_what_has_a_limit_and_gives_up_the_rest(clock: Clock) -> None:
    flying = InFlight()
    assert stop_text(flying) == ""
    flying.begin(replace(task(0, 10), patience=64))
    clock.now += 6.0
    waits = "finishing 10 points in flight, the oldest for 0:06, for 20 s at most"
    assert stop_text(flying) == waits
    flying.begin(task(20, 1))
    gives_up = "leaving 1 point, which may take minutes, for the next run"
    assert stop_text(flying) == f"{waits}; {gives_up}"
    flying.end(block_of(replace(task(0, 10), patience=64)))
    assert stop_text(flying) == gives_up
    flying.clear()
    flying.begin(replace(task(0, 10), line=5))  # lines that are followed are ordinary blocks
    assert stop_text(flying) == "finishing 10 points in flight, for 20 s at most"
