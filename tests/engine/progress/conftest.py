"""Time that stands still unless a test moves it."""

from __future__ import annotations

import pytest
from support.sweeps.watching import Clock

from sweeps.engine.progress import compiling, counts, in_flight


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    for module in (compiling, counts, in_flight):
        monkeypatch.setattr(module, "time", clock)
    return clock
