"""A computation ends between two kernels when its check says so."""

from __future__ import annotations

import pytest

from stickslip import Parameters, stationary_orbit
from stickslip.kernels.adaptive import passes
from stickslip.kernels.interruption import check_interruption, checked_by


class EndError(Exception):
    """Nobody awaits the result any more."""


def test_a_search_that_lasts_ends_with_what_its_check_raises(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(passes, "WORK", 10)
    calls = []

    def check() -> None:
        calls.append(1)
        raise EndError

    with checked_by(check), pytest.raises(EndError):
        stationary_orbit(Parameters(temperature=250))
    assert calls == [1]


def test_after_it_there_is_no_check():
    with checked_by(lambda: None):
        check_interruption()
    check_interruption()
