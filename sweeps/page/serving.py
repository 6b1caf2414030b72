"""The server of the page: the standard library on the loopback, with limits on everything.

Any user of this machine can connect. One thread reads the headers of all connections; only a
request with the token gets another thread.
"""

from __future__ import annotations

import contextlib
import logging
import math
import os
import secrets
import selectors
import signal
import socket
import struct
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import TypeAlias

from sweeps.exits import Exit, ExpectedError
from sweeps.page.admission import LOOPBACK, Guard, Query, RefusedError, parsed

# Connections without the token are limited in number, time and bytes, so that they exhaust neither
# the file descriptors nor the memory of this process.
_STRANGERS = 64
_REQUEST_SECONDS = 10.0
_HEADER_BYTES = 1 << 14
# Few, so that known connections are read before many new ones make them the oldest.
_ACCEPTED_AT_ONCE = 16
_BACKLOG = 1024  # a client without a place in the queue tries again a second later
_NO_FILES_SECONDS = 0.05
# A signal does not end a wait that begins just after it, or a wait in a thread other than the one
# that gets it. Python acts on it when the wait is over.
_DEAF_SECONDS = 0.5

_ADMITTED = 64
_STALLED_SECONDS = 30.0
_SEND_BYTES = 1 << 18  # in the system's buffer, which takes more when a third has been read

_LONG = f"the headers of a request may have at most {_HEADER_BYTES} bytes"
_NOWHERE = "there is nothing at this path"
_TOO_MANY = "too many requests are under way; close some tabs, and reload this one"

_ALWAYS = {
    "Connection": "close",
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Answer:
    """The answer to a request; an iterator is sent piece by piece, until the connection closes.

    An empty piece sends nothing, but checks whether the client is still there. If it is gone, the
    iterator is closed, like a generator.
    """

    content_type: str
    body: bytes | Iterator[bytes]
    headers: Mapping[str, str] = field(default_factory=dict)
    status: int = 200


Route: TypeAlias = Callable[[Query], Answer]
"""Answers the requests at a path, each in a thread."""


class PortError(ExpectedError):
    """The server cannot listen on the port; the message says why."""

    code = Exit.STORAGE


class PageServer:
    """Answers GET requests that have its token. Call `run` once, and `stop` from any thread."""

    def __init__(self, routes: Mapping[str, Route], port: int = 0) -> None:
        try:
            self._listening = socket.create_server((LOOPBACK, port), backlog=_BACKLOG)
        except OSError as error:
            why = os.strerror(error.errno or 0)
            raise PortError(
                f"port {port} on {LOOPBACK} cannot be used: {why}; give another --port, or leave "
                "it out to use a free one"
            ) from None
        self._listening.setblocking(False)
        self.port: int = self._listening.getsockname()[1]
        token = secrets.token_urlsafe(32)
        self.address = f"http://{LOOPBACK}:{self.port}/?token={token}"
        self._routes, self._guard = routes, Guard(token, self.port)
        self._strangers: dict[socket.socket, _Stranger] = {}  # the oldest first
        self._admitted: set[socket.socket] = set()
        self._lock = threading.Lock()  # of the admitted connections, which threads close
        self._stopping, self._stopped = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        for heard in (self._listening, self._stopped):
            self._selector.register(heard, selectors.EVENT_READ)

    def run(self) -> None:
        """Serve until `stop` is called, which cuts off answers that are under way."""
        try:
            while self._hear():
                pass
        finally:
            self._close()

    def stop(self) -> None:
        """Make `run` return."""
        self._stopping.close()  # which wakes the other end of the pair

    def run_in_background(self) -> threading.Thread:
        """Serve in a daemon thread, and return it."""
        thread = threading.Thread(target=self.run, daemon=True)
        thread.start()
        return thread

    def run_until_signal(self, at_end: Callable[[], None]) -> None:
        """Serve until Ctrl-C or a signal, which ends the process after `at_end`.

        The process ends at once, whatever the compiled code in threads is doing, because there is
        nothing to keep. Ignored signals, as under nohup, stay ignored.
        """

        def end(*_: object) -> None:
            at_end()
            os._exit(Exit.DONE)

        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, end)
        self.run()

    # --- strangers, in the thread of `run`, which never waits for any one of them ---

    def _hear(self) -> bool:
        """Wait for something to arrive, and handle it; return False once `stop` was called."""
        events = self._selector.select(min(self._patience(), _DEAF_SECONDS))
        ready = {key.fileobj for key, _ in events}
        for known in [client for client in self._strangers if client in ready]:
            self._read(known)
        if self._listening in ready:
            self._accept()
        while self._patience() == 0.0:
            self._drop(next(iter(self._strangers)))
        return self._stopped not in ready

    def _patience(self) -> float:
        """Return the seconds until the oldest stranger times out; infinite if there are none."""
        oldest = next(iter(self._strangers.values()), None)
        return math.inf if oldest is None else max(0.0, oldest.until - time.monotonic())

    def _accept(self) -> None:
        for _ in range(_ACCEPTED_AT_ONCE):
            try:
                client, _address = self._listening.accept()
            except (BlockingIOError, ConnectionError):
                return
            except OSError:  # no file descriptor is left; an immediate retry would fail again
                time.sleep(_NO_FILES_SECONDS)
                return
            if len(self._strangers) >= _STRANGERS:
                self._drop(next(iter(self._strangers)))
            client.setblocking(False)
            self._strangers[client] = _Stranger(time.monotonic() + _REQUEST_SECONDS)
            self._selector.register(client, selectors.EVENT_READ)
            self._read(client)

    def _read(self, client: socket.socket) -> None:
        """Read the part of the headers that has arrived, and answer once they are complete."""
        received = self._strangers[client].received
        before = len(received)
        try:
            piece = client.recv(_HEADER_BYTES - before)
        except BlockingIOError:
            return
        except OSError:
            piece = b""
        received += piece
        end = received.find(b"\r\n\r\n", max(0, before - 3))
        if not piece:
            self._drop(client)
        elif end >= 0:
            self._answer(client, received[:end].decode("latin-1"))
        elif len(received) == _HEADER_BYTES:
            self._refuse(client, 431, _LONG)

    def _answer(self, client: socket.socket, head: str) -> None:
        """Answer an admitted request in a thread; refuse any other."""
        try:
            request = parsed(head)
            query = self._guard.admit(request)
            route = self._routes.get(request.path)
            if route is None:
                raise RefusedError(404, _NOWHERE)
            with self._lock:
                if len(self._admitted) >= _ADMITTED:
                    raise RefusedError(503, _TOO_MANY)
                self._admitted.add(client)
        except RefusedError as refused:
            self._refuse(client, *refused.args)
            return
        self._forget(client)
        try:
            threading.Thread(target=self._serve, args=(client, route, query), daemon=True).start()
        except RuntimeError:  # this process gets no more threads
            self._finish(client)

    def _refuse(self, client: socket.socket, status: int, sentence: str) -> None:
        """Send a sentence, for which a new connection always has room, and close the connection."""
        with contextlib.suppress(OSError):
            client.send(_plain(status, sentence))
        self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        self._forget(client)
        client.close()

    def _forget(self, client: socket.socket) -> None:
        del self._strangers[client]
        self._selector.unregister(client)

    def _close(self) -> None:
        self._selector.close()
        for ended in (self._listening, self._stopped, self._stopping, *self._strangers):
            ended.close()
        with self._lock:
            for client in self._admitted:
                with contextlib.suppress(OSError):
                    client.shutdown(socket.SHUT_RDWR)  # so that its thread does not wait

    # --- admitted connections, each in a thread ---

    def _serve(self, client: socket.socket, route: Route, query: Query) -> None:
        try:
            with contextlib.suppress(OSError):  # the client is gone, or does not read
                _deliver(client, route, query)
        finally:
            self._finish(client)

    def _finish(self, client: socket.socket) -> None:
        with self._lock:
            self._admitted.remove(client)
            client.close()


@dataclass
class _Stranger:
    """A connection that has not yet shown the token."""

    until: float
    received: bytearray = field(default_factory=bytearray)


class _BrokenError(Exception):
    """An answer that failed after its beginning was sent."""


def _plain(status: int, sentence: str) -> bytes:
    """Return an answer of one sentence, as it is sent."""
    text = f"{status}: {sentence}.\n".encode(errors="replace")  # a file name may hold any bytes
    return _head(Answer("text/plain; charset=utf-8", text, {"Allow": "GET"}, status)) + text


def _head(answer: Answer) -> bytes:
    headers = {**answer.headers, "Content-Type": answer.content_type, **_ALWAYS}
    if isinstance(answer.body, bytes):
        headers["Content-Length"] = str(len(answer.body))
    lines = [f"HTTP/1.1 {answer.status} {HTTPStatus(answer.status).phrase}"]
    lines += [f"{name}: {text}" for name, text in headers.items()]
    if not all(line.isprintable() for line in lines):
        raise ValueError("a header has a character that cannot be printed")
    return "\r\n".join([*lines, "", ""]).encode("latin-1")


def _pieces(route: Route, query: Query) -> Generator[bytes, None, None]:
    """Yield an answer as it is sent, head and first piece together; an earlier failure is a 500."""
    begun = False
    try:
        answer = route(query)
        body = iter((answer.body,)) if isinstance(answer.body, bytes) else answer.body
        try:
            start = _head(answer) + next(body, b"")
            begun = True
            yield start
            yield from body
        finally:
            getattr(body, "close", lambda: None)()
    except Exception as error:
        log.debug("unexpected", exc_info=True)
        if begun:
            raise _BrokenError from None
        yield _plain(500, f"unexpected {type(error).__name__}: {error}")


def _deliver(client: socket.socket, route: Route, query: Query) -> None:
    """Send a route's answer; if cut short, it must not look whole, so the connection is reset."""
    # Otherwise a small piece would wait until the previous one is acknowledged.
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BYTES)
    try:
        with contextlib.closing(_pieces(route, query)) as pieces:
            for piece in pieces:
                _send(client, piece)
    except _BrokenError:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def _send(client: socket.socket, piece: bytes) -> None:
    """Send a piece; raises OSError if the client is gone, or reads nothing for too long."""
    client.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        if not client.recv(1, socket.MSG_PEEK):  # otherwise only a second piece would fail
            raise ConnectionAbortedError
    client.settimeout(_STALLED_SECONDS)
    rest = memoryview(piece)
    while rest:
        rest = rest[client.send(rest) :]  # each call has its own time limit
