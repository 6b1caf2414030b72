"""A check can end a computation between two kernels."""

from __future__ import annotations

import pytest

from stickslip import Parameters, stationary_orbit
from stickslip.kernels.adaptive import passes
from stickslip.kernels.interruption import check_interruption, checked_by


class EndError(Exception):
    """Nobody awaits the result any more."""


def test_a_long_search_ends_with_the_error_of_its_check(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(passes, "WORK", 10)
    calls = []

    def check() -> None:
        calls.append(1)
        raise EndError

    with checked_by(check), pytest.raises(EndError):
        stationary_orbit(Parameters(temperature=250))
    assert calls == [1]


def test_a_check_ends_with_its_context():
    with checked_by(lambda: None):
        check_interruption()
    check_interruption()
