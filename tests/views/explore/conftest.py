"""A result to open, and pages that are served in a thread of this process."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import xarray as xr
from support.browser import chromium

from sweeps import run

__all__ = ["chromium"]

pytest.importorskip("bokeh", reason="bokeh is not installed")

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
def served(open_page: Callable[[Any], None]) -> Iterator[Any]:
    """The server of a page, until the end of the context."""
    from sweeps.views.explore.serving import PageServer

    there, servers = threading.Event(), []

    def serve() -> None:
        servers.append(PageServer(open_page))
        there.set()
        servers[0].run()

    thread = threading.Thread(target=serve)
    thread.start()
    assert there.wait(60)
    try:
        yield servers[0]
    finally:
        servers[0].stop()
        thread.join(60)
        assert not thread.is_alive()


@pytest.fixture(scope="session")
def serving() -> Callable[..., Any]:
    """`served`, for tests."""
    return served
