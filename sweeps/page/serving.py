"""The server of the page: the standard library on the loopback, with a limit to everything.

Any user of this machine can connect. One thread reads the headers of all; only a request that has
shown the token gets a thread of its own.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
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
from typing import NamedTuple, TypeAlias
from urllib.parse import parse_qsl

from sweeps.exits import Exit, ExpectedError

_LOOPBACK = "127.0.0.1"

# What has not shown the token is limited in number, time and bytes, so that it takes neither the
# files nor the memory of this process.
_STRANGERS = 64
_REQUEST_SECONDS = 10.0
_HEADER_BYTES = 1 << 14
# Few, so that those who are known are read before they are the oldest of many new ones.
_ACCEPTED_AT_ONCE = 16
_BACKLOG = 1024  # a connection that finds no place in the queue is tried again a second later
_NO_FILES_SECONDS = 0.05

_ADMITTED = 64
_STALLED_SECONDS = 30.0
_SEND_BYTES = 1 << 18  # of the system: more is taken when a third of them has been read

_STRANGE = (
    "this page opens with the whole address that `stickslip explore` has printed, with its token"
)
_ODD = "this is no request of a browser"
_LONG = f"the headers of a request have at most {_HEADER_BYTES} bytes"
_NOT_GET = "this page answers GET alone"
_TWICE = "a parameter is given more than once"
_NOWHERE = "there is nothing at this path"
_TOO_MANY = "as many requests are under way as may be: close some tabs, and reload this one"

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
    """The answer to a request; an iterator is sent piece by piece, and closing marks its end.

    An empty piece sends nothing, but looks whether the client is still there; if it is gone, the
    iterator is closed, as a generator is.
    """

    content_type: str
    body: bytes | Iterator[bytes]
    headers: Mapping[str, str] = field(default_factory=dict)
    status: int = 200


Query: TypeAlias = Mapping[str, str]
"""The decoded parameters of a request, without its token."""

Route: TypeAlias = Callable[[Query], Answer]
"""What answers at a path, in a thread of the request."""


class PortError(ExpectedError):
    """The port cannot be listened on; the message says why."""

    code = Exit.STORAGE


class PageServer:
    """Answers GET requests that have its token; `run` once, and `stop` from any thread."""

    def __init__(self, routes: Mapping[str, Route], port: int = 0) -> None:
        try:
            self._listening = socket.create_server((_LOOPBACK, port), backlog=_BACKLOG)
        except OSError as error:
            why = os.strerror(error.errno or 0)
            raise PortError(
                f"port {port} of {_LOOPBACK} cannot be used: {why}; give another --port, or none "
                "for a free one"
            ) from None
        self._listening.setblocking(False)
        self.port: int = self._listening.getsockname()[1]
        token = secrets.token_urlsafe(32)
        self.address = f"http://{_LOOPBACK}:{self.port}/?token={token}"
        self._routes, self._guard = routes, _Guard(token, self.port)
        self._strangers: dict[socket.socket, _Stranger] = {}  # the oldest first
        self._admitted: set[socket.socket] = set()
        self._lock = threading.Lock()  # of the admitted, which threads close
        self._stopping, self._stopped = socket.socketpair()
        self._selector = selectors.DefaultSelector()
        for heard in (self._listening, self._stopped):
            self._selector.register(heard, selectors.EVENT_READ)

    def run(self) -> None:
        """Serve until `stop` is called; answers that are under way are cut off then."""
        try:
            while self._hear():
                pass
        finally:
            self._close()

    def stop(self) -> None:
        """Make `run` return."""
        self._stopping.close()  # the other end of the pair hears it

    def run_in_background(self) -> threading.Thread:
        """Serve in a daemon thread, and return it."""
        thread = threading.Thread(target=self.run, daemon=True)
        thread.start()
        return thread

    def run_until_signal(self, at_end: Callable[[], None]) -> None:
        """Serve until Ctrl-C or a signal, which ends the process after `at_end`.

        It ends at once, whatever the compiled code in threads is doing: there is nothing to keep.
        Signals that are ignored, as under nohup, stay ignored.
        """

        def end(*_: object) -> None:
            at_end()
            os._exit(Exit.DONE)

        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, end)
        self.run()

    # --- strangers, in the thread of `run`: nothing here waits for one of them ---

    def _hear(self) -> bool:
        """Wait for something to arrive, and take it in; False once `stop` was called."""
        ready = {key.fileobj for key, _ in self._selector.select(self._patience())}
        for known in [client for client in self._strangers if client in ready]:
            self._read(known)
        if self._listening in ready:
            self._accept()
        while self._patience() == 0.0:
            self._drop(next(iter(self._strangers)))
        return self._stopped not in ready

    def _patience(self) -> float | None:
        """Return the seconds until the oldest stranger times out; None if there is none."""
        oldest = next(iter(self._strangers.values()), None)
        return None if oldest is None else max(0.0, oldest.until - time.monotonic())

    def _accept(self) -> None:
        for _ in range(_ACCEPTED_AT_ONCE):
            try:
                client, _address = self._listening.accept()
            except (BlockingIOError, ConnectionError):
                return
            except OSError:  # this process has no file left; it would be told so again at once
                time.sleep(_NO_FILES_SECONDS)
                return
            if len(self._strangers) >= _STRANGERS:
                self._drop(next(iter(self._strangers)))
            client.setblocking(False)
            self._strangers[client] = _Stranger(time.monotonic() + _REQUEST_SECONDS)
            self._selector.register(client, selectors.EVENT_READ)
            self._read(client)

    def _read(self, client: socket.socket) -> None:
        """Read what has arrived of the headers, and answer once they are complete."""
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
        """Answer an admitted request in a thread, and refuse any other."""
        try:
            request = _parsed(head)
            query = self._guard.admit(request)
            route = self._routes.get(request.path)
            if route is None:
                raise _RefusedError(404, _NOWHERE)
            with self._lock:
                if len(self._admitted) >= _ADMITTED:
                    raise _RefusedError(503, _TOO_MANY)
                self._admitted.add(client)
        except _RefusedError as refused:
            self._refuse(client, *refused.args)
            return
        self._forget(client)
        try:
            threading.Thread(target=self._serve, args=(client, route, query), daemon=True).start()
        except RuntimeError:  # this process gets no more threads
            self._finish(client)

    def _refuse(self, client: socket.socket, status: int, sentence: str) -> None:
        """Send a sentence, for which a new connection always has room, and close."""
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
                    client.shutdown(socket.SHUT_RDWR)  # its thread waits no longer

    # --- those that are admitted, each in a thread ---

    def _serve(self, client: socket.socket, route: Route, query: Query) -> None:
        try:
            with contextlib.suppress(OSError):  # it is gone, or has stopped reading
                _deliver(client, route, query)
        finally:
            self._finish(client)

    def _finish(self, client: socket.socket) -> None:
        with self._lock:
            self._admitted.remove(client)
            client.close()


@dataclass
class _Stranger:
    """A connection that has not shown the token."""

    until: float
    received: bytearray = field(default_factory=bytearray)


class _RefusedError(Exception):
    """A request that no route gets; its arguments are the status and a sentence."""


class _BrokenError(Exception):
    """An answer that failed when its beginning had been sent."""


class _Request(NamedTuple):
    method: str
    path: str
    parameters: list[tuple[str, str]]
    headers: dict[str, str]


# Neither may backtrack: a stranger chooses what they read.
_FIRST_LINE = re.compile(r"([A-Z]+) (/[!-~]*) HTTP/1\.[01]")
_HEADER = re.compile(r"([!#$%&'*+\-.^_`|~0-9A-Za-z]+):([\t -~\x80-\xff]*)")


def _parsed(head: str) -> _Request:
    """The request of these lines; a folded header and HTTP/0.9 are refused."""
    first, *others = head.split("\r\n")
    start, lines = _FIRST_LINE.fullmatch(first), [_HEADER.fullmatch(line) for line in others]
    if start is None:
        raise _RefusedError(400, _ODD)
    headers: dict[str, str] = {}
    for line in lines:
        if line is None:
            raise _RefusedError(400, _ODD)
        name, text = line[1].lower(), line[2].strip(" \t")
        # A header may be repeated; a second Host makes one that is not this page's.
        headers[name] = f"{headers[name]}, {text}" if name in headers else text
    path, _, query = start[2].partition("?")
    return _Request(start[1], path, parse_qsl(query, keep_blank_values=True), headers)


_JUDGED = ("host", "origin", "sec-fetch-site", "sec-fetch-mode")
_OTHER_SITES = {"same-site", "cross-site"}


class _Guard:
    """Who may use the page: whoever knows the token, from this machine, on a page of its own.

    The name in `Host` and the `Origin` must be those of this page: a foreign page whose name was
    made to lead to this machine (DNS rebinding) has others.
    """

    def __init__(self, token: str, port: int) -> None:
        self._token = token.encode()
        self._hosts = {f"{name}:{port}" for name in (_LOOPBACK, "localhost")}
        self._origins = {f"http://{host}" for host in self._hosts}

    def admit(self, request: _Request) -> Query:
        """The parameters of a request that may be answered; raises `_RefusedError` otherwise."""
        tokens = [text for name, text in request.parameters if name == "token"]
        if not (self._is_right(tokens) and self._is_own(request)):
            raise _RefusedError(403, _STRANGE)
        if request.method != "GET":
            raise _RefusedError(405, _NOT_GET)
        query = dict(request.parameters)
        if len(query) < len(request.parameters):
            raise _RefusedError(400, _TWICE)
        del query["token"]
        return query

    def _is_right(self, tokens: list[str]) -> bool:
        """Tell whether the token is right, in a time that does not depend on its letters."""
        return len(tokens) == 1 and secrets.compare_digest(tokens[0].encode(), self._token)

    def _is_own(self, request: _Request) -> bool:
        """Tell whether a request comes from this page, or opens it.

        A file that leads to it, and a notebook that shows it in a frame, are other sites.
        """
        host, origin, site, mode = map(request.headers.get, _JUDGED)
        opens = request.path == "/" and mode == "navigate"
        return (
            host is not None
            and host.lower() in self._hosts
            and (origin is None or origin.lower() in self._origins)
            and (site in {None, "same-origin", "none"} or (opens and site in _OTHER_SITES))
        )


def _plain(status: int, sentence: str) -> bytes:
    """An answer of one sentence, as it is sent."""
    text = f"{status}: {sentence}.\n".encode(errors="replace")  # a failure may tell of any bytes
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
    """An answer as it is sent, its head with the first piece; a failure before that is a 500."""
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
    """Send the answer of a route; one that breaks off is reset, since an end would look whole."""
    # Otherwise a small piece waits until the one before it is acknowledged.
    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BYTES)
    try:
        with contextlib.closing(_pieces(route, query)) as pieces:
            for piece in pieces:
                _send(client, piece)
    except _BrokenError:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def _send(client: socket.socket, piece: bytes) -> None:
    """Send a piece; raises OSError where the client is gone, or reads nothing for too long."""
    client.setblocking(False)
    with contextlib.suppress(BlockingIOError):
        if not client.recv(1, socket.MSG_PEEK):  # sending would not tell before the second piece
            raise ConnectionAbortedError
    client.settimeout(_STALLED_SECONDS)
    rest = memoryview(piece)
    while rest:
        rest = rest[client.send(rest) :]  # each with a time of its own
