"""A real browser, the Chromium of the system, headless and with an empty profile."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import pytest

_NAMES = ("chromium", "chromium-browser", "google-chrome")
_QUIET = [
    f"--{flag}"
    for flag in (
        "headless",
        "no-sandbox",
        "disable-gpu",
        "disable-quic",
        "no-first-run",
        "disable-background-networking",
        "disable-component-update",
        "disable-sync",
    )
]
_WAIT = 120_000  # milliseconds, longer than anything takes, compilation included


class Tab:
    """A tab of the browser, with the addresses that it requested, its errors and warnings."""

    def __init__(self, page: Any) -> None:
        self.page, self.requests, self.errors = page, list[str](), list[str]()
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("websocket", lambda socket: self.requests.append(socket.url))
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", self._hear)

    def _hear(self, message: Any) -> None:
        if message.type in ("error", "warning"):
            self.errors.append(message.text)

    def requests_elsewhere(self, *here: str) -> list[str]:
        """Return the addresses that begin with none of these and are no data URLs."""
        known = (*here, "data:", "blob:")
        return [address for address in self.requests if not address.startswith(known)]


class Tabs:
    """Opens files in tabs and reuses them, since a new tab costs as much as its page."""

    def __init__(self, browser: Any, contexts: ExitStack) -> None:
        self._browser, self._contexts = browser, contexts
        self._free: dict[str, list[Tab]] = {}
        self._used: list[tuple[str, Tab]] = []

    def open(self, address: str, **window: Any) -> Any:
        """Return the page of a tab in a window with these options."""
        free = self._free.setdefault(key := repr(window), [])
        tab = free.pop() if free else self._new(window)
        self._used.append((key, tab))
        tab.page.goto("about:blank")  # else an address that differs only after # loads nothing
        tab.requests.clear()
        tab.page.goto(address)
        tab.page.wait_for_selector("body[data-ready]")
        return tab.page

    def check(self) -> None:
        """Assert that the pages had no errors and requested nothing elsewhere; free their tabs."""
        used, self._used = self._used, []
        for key, tab in used:
            self._free[key].append(tab)
        for _, tab in used:
            errors = tab.errors.copy()
            tab.errors.clear()
            assert errors == []
            assert tab.requests_elsewhere("file:") == []

    def _new(self, window: dict[str, Any]) -> Tab:
        return Tab(self._contexts.enter_context(opened_tab(self._browser, **window)))


@pytest.fixture(scope="module")
def tabs(chromium: Any) -> Iterator[Tabs]:
    """The tabs of a test module, in which each test ends with a `check`."""
    with ExitStack() as contexts:
        yield Tabs(chromium, contexts)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """The browser, one for each test module, so that no event loop outlives it."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = [path for path in map(shutil.which, _NAMES) if path]
    if not found:
        pytest.skip(f"there is no browser: none of {', '.join(_NAMES)}")
    with sync_api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found[0], args=_QUIET)
        yield browser
        browser.close()


@contextmanager
def opened_tab(browser: Any, width: int = 1500, height: int = 950, **device: Any) -> Iterator[Any]:
    """Open an empty tab with its own cookies and storage; a `device` may be a phone."""
    context = browser.new_context(viewport={"width": width, "height": height}, **device)
    context.set_default_timeout(_WAIT)
    try:
        yield context.new_page()
    finally:
        context.close()
