"""Servers of pages in threads of this process, and requests to them."""

from __future__ import annotations

import contextlib
import http.client
import socket
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from urllib.parse import urlsplit

from sweeps.page.admission import Query
from sweeps.page.serving import Answer, PageServer, Route

HANGS = 60.0  # seconds: longer than anything takes, on any machine


def giving(answer: Answer) -> Route:
    """Return a route that always gives this answer."""

    def give(query: Query) -> Answer:
        return answer

    return give


HELLO = giving(Answer("text/html", b"hello"))


@contextmanager
def running(server: PageServer) -> Iterator[PageServer]:
    """Run a server until the end of the context."""
    thread = server.run_in_background()
    try:
        yield server
    finally:
        server.stop()
        thread.join(HANGS)
        assert not thread.is_alive()


def served(home: Route = HELLO, **routes: Route) -> AbstractContextManager[PageServer]:
    """Return a context with a server of these routes; `home` is the route of "/"."""
    paths = {f"/{name}": route for name, route in routes.items()}
    return running(PageServer({"/": home, **paths}))


def token_of(server: PageServer) -> str:
    return urlsplit(server.address).query.removeprefix("token=")


def connected(server: PageServer) -> socket.socket:
    return socket.create_connection(("127.0.0.1", server.port), timeout=HANGS)


def answer(
    server: PageServer, path: str, **headers: str
) -> tuple[int, str, http.client.HTTPMessage]:
    """Return status, text and headers; TOKEN and PORT in the request stand for the right ones."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=HANGS)
    named = {name.replace("_", "-"): filled(server, text) for name, text in headers.items()}
    with closing(connection):
        connection.request("GET", filled(server, path), headers=named)
        response = connection.getresponse()
        return response.status, response.read().decode(), response.headers


def status(server: PageServer, path: str = "/?token=TOKEN", **headers: str) -> int:
    return answer(server, path, **headers)[0]


def request(server: PageServer, path: str = "/") -> bytes:
    """Return a request with the right token, as a client sends it."""
    text = f"GET {path}?token=TOKEN HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n"
    return filled(server, text).encode()


def filled(server: PageServer, text: str) -> str:
    return text.replace("TOKEN", token_of(server)).replace("PORT", str(server.port))


def all_of(connection: socket.socket) -> bytes:
    """Return everything that arrives until the server closes the connection."""
    return b"".join(iter(lambda: connection.recv(1 << 16), b""))


def sent(server: PageServer, text: str) -> bytes:
    """Return the answer to a text, in which TOKEN and PORT stand for the right ones."""
    received = b""
    with connected(server) as connection, contextlib.suppress(ConnectionResetError):
        connection.sendall(filled(server, text).encode("latin-1"))
        while part := connection.recv(1 << 16):
            received += part
    return received  # a reset may follow, if the server has left something unread


def status_of(received: bytes) -> int:
    return int(received.split(b" ", 2)[1]) if received else 0
