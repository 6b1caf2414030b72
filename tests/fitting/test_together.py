"""Several fits ask, and are answered in one call."""

from __future__ import annotations

import pytest

from sweeps.fitting.together import Together


def test_all_are_answered_at_once_until_they_end() -> None:
    calls: list[list[int]] = []

    def answer(questions: list[int]) -> list[int]:
        calls.append(sorted(questions))
        return [10 * question for question in questions]

    together = Together(answer)

    def work(times: int) -> int:
        return sum(together.ask(times) for _ in range(times))

    assert together.run(work, [1, 2, 3]) == [10, 40, 90]
    assert calls == [[1, 2, 3], [2, 3], [3]]
    assert together.run(work, []) == []


def test_an_error_reaches_all() -> None:
    def answer(questions: list[int]) -> list[int]:
        raise ValueError(str(len(questions)))

    together = Together(answer)
    with pytest.raises(ValueError, match="2"):
        together.run(together.ask, [1, 2])
