"""What is in flight: which tasks, how many points, since when."""

from __future__ import annotations

from support.sweeps.watching import Clock, task

from sweeps.engine.progress.in_flight import InFlight


def test_tasks_are_in_flight_from_their_beginning_to_their_end(clock: Clock) -> None:
    in_flight, first, second = InFlight(), task(0, 3), task(7, 5)
    in_flight.begin(first)
    clock.now += 4.0
    in_flight.begin(second)
    clock.now += 1.0
    assert (in_flight.points, in_flight.ages) == (8, [(3, 5.0), (5, 1.0)])
    assert in_flight.end(0) is first
    assert in_flight.end(0) is None
    assert (in_flight.points, in_flight.ages) == (5, [(5, 1.0)])


def test_silence_lasts_until_a_task_comes_back(clock: Clock) -> None:
    in_flight = InFlight()
    clock.now += 3.0
    in_flight.begin(task(0, 1))
    clock.now += 4.0
    assert in_flight.silence == 7.0
    in_flight.end(0)
    assert in_flight.silence == 0.0


def test_tasks_that_are_given_up_are_forgotten(clock: Clock) -> None:
    in_flight, tasks = InFlight(), [task(0, 1), task(1, 1)]
    for each in tasks:
        in_flight.begin(each)
    assert in_flight.clear() == tasks
    assert (in_flight.points, in_flight.clear()) == (0, [])


def test_it_is_told_in_words(clock: Clock) -> None:
    in_flight = InFlight()
    assert str(in_flight) == ""
    in_flight.begin(task(0, 1))
    assert str(in_flight) == "1 point in flight"
    clock.now += 63.0
    in_flight.begin(task(1, 255))
    assert str(in_flight) == "256 points in flight, the oldest for 1:03"
