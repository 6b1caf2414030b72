"""Fits side by side: what they ask for is computed in one call, in the lanes of all."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Generic, TypeVar

_Asked = TypeVar("_Asked")
_Answer = TypeVar("_Answer")
_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


class Together(Generic[_Asked, _Answer]):
    """Answers questions of several threads, all at once when each of them has asked.

    `answer` takes a list of questions and returns their answers; it is called by one thread at a
    time. What it raises is raised in all threads that wait.
    """

    def __init__(self, answer: Callable[[list[_Asked]], list[_Answer]]) -> None:
        self._answer = answer
        self._changed = threading.Condition()
        self._running = 0
        self._asked: list[tuple[_Asked, list[Any]]] = []

    def run(self, work: Callable[[_Item], _Result], items: Sequence[_Item]) -> list[_Result]:
        """Return what `work` returns for each item, each in a thread that may `ask`."""
        self._running = len(items)
        with ThreadPoolExecutor(max(len(items), 1)) as pool:
            return list(pool.map(lambda item: self._worked(work, item), items))

    def ask(self, question: _Asked) -> _Answer:
        """Return the answer to a question, once all others have asked theirs, or ended."""
        slot: list[Any] = []
        with self._changed:
            self._asked.append((question, slot))
            self._answer_if_all_wait()
            self._changed.wait_for(lambda: bool(slot))
        if isinstance(slot[0], BaseException):
            raise slot[0]
        answer: _Answer = slot[0]
        return answer

    def _worked(self, work: Callable[[_Item], _Result], item: _Item) -> _Result:
        try:
            return work(item)
        finally:
            with self._changed:
                self._running -= 1
                self._answer_if_all_wait()

    def _answer_if_all_wait(self) -> None:
        if not self._asked or len(self._asked) < self._running:
            return
        asked, self._asked = self._asked, []
        try:
            answers: Sequence[Any] = self._answer([question for question, _ in asked])
        except BaseException as error:  # noqa: BLE001 - it is raised where the answer is awaited
            answers = [error] * len(asked)
        for (_, slot), answer in zip(asked, answers, strict=True):
            slot.append(answer)
        self._changed.notify_all()
