"""Who computes when: few at a time, the longest waiting first, of each tab the latest alone."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator

import pytest

from sweeps.page import turns as module
from sweeps.page.turns import Turns, Void

HANGS = 60.0


class Request:
    """A request in a thread of its own, which computes until it is told to end."""

    def __init__(self, turns: Turns, tab: str, number: int, told: queue.SimpleQueue[str]) -> None:
        self._turns, self._tab, self._number, self._told = turns, tab, number, told
        self._end = threading.Event()
        self.check: Callable[[], None] | None = None
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def end(self) -> None:
        self._end.set()
        self.thread.join(HANGS)
        assert not self.thread.is_alive()

    def _run(self) -> None:
        name = f"{self._tab}{self._number}"
        waits = lambda: self._told.put(f"{name} waits")  # noqa: E731 - shorter than a method
        try:
            with self._turns.take(self._tab, self._number, waits) as self.check:
                self._told.put(f"{name} begins")
                assert self._end.wait(HANGS)
        except Void:
            self._told.put(f"{name} is void")


class Tabs:
    """Requests of tabs; `says` waits for the next thing that one of them tells."""

    def __init__(self, slots: int) -> None:
        self.turns = Turns(slots)
        self._told: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._requests: list[Request] = []

    def ask(self, tab: str, number: int) -> Request:
        self._requests.append(Request(self.turns, tab, number, self._told))
        return self._requests[-1]

    def says(self) -> str:
        return self._told.get(timeout=HANGS)

    def says_no_more(self) -> bool:
        return self._told.empty()

    def end(self) -> None:
        for request in self._requests:
            request.end()


@pytest.fixture
def tabs() -> Iterator[Callable[[int], Tabs]]:
    opened: list[Tabs] = []

    def open_tabs(slots: int) -> Tabs:
        opened.append(Tabs(slots))
        return opened[-1]

    yield open_tabs
    for some in opened:
        some.end()


def test_as_many_begin_as_there_are_places_and_the_next_one_waits(tabs: Callable[[int], Tabs]):
    some = tabs(2)
    first = some.ask("a", 1)
    assert some.says() == "a1 begins"
    some.ask("b", 1)
    assert some.says() == "b1 begins"
    some.ask("c", 1)
    assert some.says() == "c1 waits"
    assert some.says_no_more()
    first.end()
    assert some.says() == "c1 begins"


def test_two_compute_at_once_unless_told_otherwise():
    turns = Turns()
    waited: list[str] = []
    with (
        turns.take("a", 1, lambda: waited.append("a")),
        turns.take("b", 1, lambda: waited.append("b")),
    ):
        assert waited == []
        with pytest.raises(ZeroDivisionError), turns.take("c", 1, lambda: 1 / 0):
            pass


def test_the_longest_waiting_begins_first(tabs: Callable[[int], Tabs]):
    some = tabs(1)
    requests = [some.ask("a", 1)]
    assert some.says() == "a1 begins"
    for tab in "bcdef":
        requests.append(some.ask(tab, 1))
        assert some.says() == f"{tab}1 waits"
    for request, following in zip(requests, "bcdef", strict=False):
        request.end()
        assert some.says() == f"{following}1 begins"


def test_a_later_request_of_its_tab_makes_one_that_waits_void(tabs: Callable[[int], Tabs]):
    some = tabs(1)
    first = some.ask("a", 1)
    assert some.says() == "a1 begins"
    for tab in "bc":
        some.ask(tab, 1)
        assert some.says() == f"{tab}1 waits"
    some.ask("b", 2)
    assert {some.says(), some.says()} == {"b1 is void", "b2 waits"}
    first.end()
    assert some.says() == "c1 begins"


def test_a_later_request_of_its_tab_makes_one_that_computes_void(tabs: Callable[[int], Tabs]):
    some = tabs(2)
    first = some.ask("a", 1)
    assert some.says() == "a1 begins"
    assert first.check is not None
    first.check()
    some.ask("b", 2)
    assert some.says() == "b2 begins"
    first.check()  # another tab's numbers are its own
    some.ask("a", 2)
    assert some.says() == "a2 waits"
    with pytest.raises(Void):
        first.check()
    first.end()
    assert some.says() == "a2 begins"


def test_a_request_that_comes_too_late_never_takes_a_place(tabs: Callable[[int], Tabs]):
    some = tabs(1)
    later = some.ask("a", 2)
    assert some.says() == "a2 begins"
    some.ask("a", 1)
    assert some.says() == "a1 is void"
    assert later.check is not None
    later.check()


def test_requests_of_one_number_are_all_answered(tabs: Callable[[int], Tabs]):
    some = tabs(2)
    first = some.ask("a", 1)
    assert some.says() == "a1 begins"
    some.ask("a", 1)
    assert some.says() == "a1 begins"
    assert first.check is not None
    first.check()


def test_a_place_is_given_back_when_a_computation_fails():
    turns = Turns(1)
    for number in range(3):
        with pytest.raises(ZeroDivisionError), turns.take("a", number):
            _ = 1 / 0


def test_a_wait_that_cannot_be_announced_keeps_nobody_waiting(tabs: Callable[[int], Tabs]):
    some = tabs(1)
    first = some.ask("a", 1)
    assert some.says() == "a1 begins"

    def fail_late() -> None:
        some.ask("c", 1)
        assert some.says() == "c1 waits"
        first.end()  # the place is free, and not for c yet
        assert some.says_no_more()
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError), some.turns.take("b", 1, fail_late):
        pass
    assert some.says() == "c1 begins"


def test_tabs_that_were_not_heard_of_for_long_are_forgotten(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "MOST_TABS", 3)
    turns = Turns()
    for tab in "abc":
        with turns.take(tab, 5):
            pass
    with turns.take("a", 5), turns.take("d", 5):
        pass
    with turns.take("b", 1):  # forgotten, and known again: c is the oldest now
        pass
    for tab in "ad":
        with pytest.raises(Void), turns.take(tab, 4):
            pass
    with turns.take("c", 1):
        pass


def test_many_threads_never_hold_more_places_than_there_are():
    turns, holding, most = Turns(2), [], []

    def ask(tab: str) -> None:
        for number in range(50):
            with turns.take(tab, number):
                holding.append(tab)
                most.append(len(holding))
                holding.remove(tab)

    threads = [threading.Thread(target=ask, args=[str(n)], daemon=True) for n in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(HANGS)
    assert not any(thread.is_alive() for thread in threads)
    assert len(most) == 16 * 50
    assert max(most) <= 2
