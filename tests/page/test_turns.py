"""Who computes when: a few at a time, the longest waiting first, only the latest of each tab."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator

import pytest
from support.sweeps.processes import wait_until

from sweeps.page import turns as module
from sweeps.page.turns import Turns, Void

HANGS = 60.0


class Request:
    """A request in a thread, which computes until its `end`."""

    def __init__(self, turns: Turns, tab: str, number: int, said: queue.SimpleQueue[str]) -> None:
        self._turns, self._tab, self._number, self._said = turns, tab, number, said
        self._end = threading.Event()
        self.check: Callable[[], None]
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def end(self) -> None:
        self._end.set()
        self._thread.join(HANGS)
        assert not self._thread.is_alive()

    def _run(self) -> None:
        name = f"{self._tab}{self._number}"
        try:
            with self._turns.take(self._tab, self._number) as self.check:
                self._said.put(f"{name} begins")
                assert self._end.wait(HANGS)
        except Void:
            self._said.put(f"{name} is void")


class Tabs:
    """Requests of tabs to `Turns`, and what happens to them, in order."""

    def __init__(self, turns: Turns) -> None:
        self.turns = turns
        self._said: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._requests: list[Request] = []

    def ask(self, tab: str, number: int) -> Request:
        self._requests.append(Request(self.turns, tab, number, self._said))
        return self._requests[-1]

    def begins(self, tab: str, number: int) -> Request:
        """Send a request that begins to compute at once."""
        request = self.ask(tab, number)
        assert self.says() == f"{tab}{number} begins"
        return request

    def waits(self, tab: str, number: int) -> Request:
        """Send a request that waits."""
        before = self.turns.waiting
        request = self.ask(tab, number)
        wait_until(lambda: self.turns.waiting == before + 1)
        assert self._said.empty()
        return request

    def says(self) -> str:
        return self._said.get(timeout=HANGS)

    def end(self) -> None:
        for request in self._requests:
            request.end()


Opened = Callable[[Turns], Tabs]


@pytest.fixture
def tabs() -> Iterator[Opened]:
    opened: list[Tabs] = []

    def open_tabs(turns: Turns) -> Tabs:
        opened.append(Tabs(turns))
        return opened[-1]

    yield open_tabs
    for some in opened:
        some.end()


def test_two_compute_at_once_and_the_next_one_waits(tabs: Opened):
    some = tabs(Turns())
    first = some.begins("a", 1)
    some.begins("b", 1)
    some.waits("c", 1)
    first.end()
    assert some.says() == "c1 begins"


def test_the_longest_waiting_begins_first(tabs: Opened):
    some = tabs(Turns(1))
    requests = [some.begins("a", 1), *(some.waits(tab, 1) for tab in "bcdef")]
    for request, following in zip(requests, "bcdef", strict=False):
        request.end()
        assert some.says() == f"{following}1 begins"


def test_a_later_request_of_its_tab_makes_one_that_waits_void(tabs: Opened):
    some = tabs(Turns(1))
    first = some.begins("a", 1)
    some.waits("b", 1)
    some.waits("c", 1)
    some.ask("b", 2)
    assert some.says() == "b1 is void"
    first.end()
    assert some.says() == "c1 begins"


def test_a_later_request_of_its_tab_makes_one_that_computes_void(tabs: Opened):
    some = tabs(Turns(2))
    first = some.begins("a", 1)
    first.check()
    some.begins("b", 2)
    first.check()  # tabs number their requests independently
    some.waits("a", 2)
    with pytest.raises(Void):
        first.check()
    first.end()
    assert some.says() == "a2 begins"


def test_a_request_that_comes_too_late_never_gets_a_slot(tabs: Opened):
    some = tabs(Turns(1))
    later = some.begins("a", 2)
    some.ask("a", 1)
    assert some.says() == "a1 is void"
    later.check()


def test_requests_of_one_number_are_all_answered(tabs: Opened):
    some = tabs(Turns(2))
    first = some.begins("a", 1)
    some.begins("a", 1)
    first.check()


def test_a_computation_that_fails_gives_its_slot_back():
    turns = Turns(1)
    for number in range(3):
        with pytest.raises(ZeroDivisionError), turns.take("a", number):
            _ = 1 / 0


def test_tabs_that_were_silent_for_long_are_forgotten(monkeypatch: pytest.MonkeyPatch):
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


def test_many_threads_never_hold_more_slots_than_there_are():
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
