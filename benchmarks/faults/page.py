"""Other users of the machine, and many tabs, at the page of `stickslip explore`."""

from __future__ import annotations

import http.client
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import psutil

from faults.arena import PATIENCE, Tally

_SOON = 5.0  # seconds in which the owner gets an answer, and the page ends
_LARGE = 104_000_000  # bytes of a body
_GROWTH = 100_000_000  # bytes that it may take of memory


def run(quick: bool, folder: Path) -> dict[str, Tally]:
    """Attack a page in four ways; after each the owner asks for it, or ends it."""
    halves, bodies, tabs, ends = (Tally() for _ in range(4))
    for _ in range(1 if quick else 3):
        with _page(folder) as page:
            _half_open(page, halves, 100 if quick else 1100)
            _large_bodies(page, bodies, 2 if quick else 8)
    for number in (signal.SIGINT, signal.SIGTERM):
        with _page(folder) as page:
            _open_and_close(page, tabs, 10 if quick else 200)
            _end(page, ends, number)
    return {
        "half-open connections to the page": halves,
        "large requests to the page": bodies,
        "tabs opened and closed": tabs,
        "signals to the page after that": ends,
    }


class _Page(NamedTuple):
    process: subprocess.Popen[bytes]
    log: Path
    port: int
    token: str

    def answers_owner(self) -> bool:
        """Return whether the page comes soon, or a word that too many requests are under way."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=_SOON)
        try:
            connection.request("GET", f"/?token={self.token}")
            return connection.getresponse().status in (200, 503)
        except OSError:
            return False
        finally:
            connection.close()

    def connected(self) -> socket.socket:
        """Return a new connection."""
        return socket.create_connection(("127.0.0.1", self.port), timeout=_SOON)

    def memory(self) -> int:
        """Return the resident bytes of the process."""
        return int(psutil.Process(self.process.pid).memory_info().rss)

    def tells_nothing(self) -> bool:
        """Return whether neither the process list nor the log holds the token."""
        own = psutil.Process(self.process.pid)
        words = [word for p in (own, *own.children(recursive=True)) for word in p.cmdline()]
        printed = self.log.read_text(errors="replace").count(self.token)
        return self.token not in " ".join(words) and printed == 1


@contextmanager
def _page(folder: Path) -> Iterator[_Page]:
    """Serve a page until the end of the context."""
    log = folder / "log"
    with log.open("w") as file:
        words = [sys.executable, "-m", "sweeps.cli", "explore", "--no-browser"]
        process = subprocess.Popen(words, stdout=file, stderr=file)
    try:
        until = time.monotonic() + PATIENCE
        pattern = re.compile(r"http://127\.0\.0\.1:(\d+)/\?token=(\S+)\n")
        while (found := pattern.search(log.read_text())) is None:
            if time.monotonic() > until or process.poll() is not None:
                raise RuntimeError(log.read_text())
            time.sleep(0.05)
        page = _Page(process, log, int(found[1]), found[2])
        page.answers_owner()  # the first page takes longer
        yield page
    finally:
        process.kill()
        process.wait()


def _half_open(page: _Page, tally: Tally, count: int) -> None:
    """Open connections that never finish their request."""
    with ExitStack() as stack:
        for number in range(count):
            with suppress(OSError):
                stack.enter_context(page.connected()).sendall(b"GET / HTTP/1.1\r\n")
            if number % 100 == 99:
                _judge(tally, f"{number + 1} half-open connections", page)


def _large_bodies(page: _Page, tally: Tally, count: int) -> None:
    """Send what is too large, with a token and without one."""
    before = page.memory()
    for number in range(count):
        with suppress(OSError), page.connected() as connection:
            query = f"token={page.token}" if number % 2 else ""
            head = f"POST /?{query} HTTP/1.1\r\nHost: x\r\nContent-Length: {_LARGE}\r\n\r\n"
            connection.sendall(head.encode())
            for _ in range(_LARGE >> 20):
                connection.sendall(bytes(1 << 20))
        _judge(tally, f"{number + 1} large requests", page)
        if page.memory() - before > _GROWTH:
            tally.count("wrong", f"{page.memory() - before} bytes more memory")


def _open_and_close(page: _Page, tally: Tally, count: int) -> None:
    """Open tabs one after another, each with an orbit that nobody awaits: it is served soon."""
    for number in range(count):
        begun = time.monotonic()
        if not page.answers_owner():
            tally.count("hung", f"tab {number}: no page")
        query = f"token={page.token}&tab={number}&number=1&T={200 + number % 90}"
        with suppress(OSError), page.connected() as connection:
            head = f"GET /orbit?{query} HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\n\r\n"
            connection.sendall(head.encode())
        if (seconds := time.monotonic() - begun) > _SOON:
            tally.count("hung", f"tab {number}: {seconds:.1f} s")
    _judge(tally, f"{count} tabs", page)


def _judge(tally: Tally, what: str, page: _Page) -> None:
    if not page.answers_owner():
        tally.count("hung", f"{what}: the owner gets no answer")
    elif not page.tells_nothing():
        tally.count("wrong", f"{what}: the token is told")
    else:
        tally.count("survived")


def _end(page: _Page, tally: Tally, number: signal.Signals) -> None:
    begun = time.monotonic()
    page.process.send_signal(number)
    try:
        code = page.process.wait(PATIENCE)
    except subprocess.TimeoutExpired:
        tally.count("hung", f"{number.name}: not heard")
        return
    seconds = time.monotonic() - begun
    sound = code == 0 and seconds < 1.0
    tally.count("survived" if sound else "wrong", f"{number.name}: {code} after {seconds:.1f} s")
