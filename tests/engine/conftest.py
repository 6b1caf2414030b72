"""A clock that tests move by hand."""

from __future__ import annotations

import pytest
from support.sweeps.watching import Clock

from stickslip.dispatch import in_flight, stop
from sweeps.engine import progress, signals


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Time that stands still unless a test moves it."""
    clock = Clock()
    for module in (in_flight, progress, signals, stop):
        monkeypatch.setattr(module, "time", clock)
    return clock
