"""A result to open, and pages that are served in threads of this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import xarray as xr
from support.browser import chromium

from sweeps import run
from sweeps.page.subject import Subject

__all__ = ["chromium"]

MAP = {
    "title": "A map",
    "sweep": {
        "temperature": {"linspace": [210, 290], "num": 9},
        "spring_stiffness": {"geomspace": [500, 8000], "num": 9},
    },
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
}


@pytest.fixture(scope="session")
def result() -> xr.Dataset:
    """9 x 9 points of the paper's fluid."""
    return run(MAP, workers=1)


@contextmanager
def served(subject: Subject) -> Iterator[Any]:
    """The server of a page, until the end of the context."""
    from sweeps.page.explorer import server_of

    server = server_of(subject)
    thread = server.run_in_background()
    try:
        yield server
    finally:
        server.stop()
        thread.join(60)
        assert not thread.is_alive()


@pytest.fixture(scope="session")
def serving() -> Callable[[Subject], Any]:
    """`served`, for tests."""
    return served
