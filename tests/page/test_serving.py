"""Who may use the page, how long and how much of a request is heard, and how it is answered."""

from __future__ import annotations

import contextlib
import http.client
import logging
import os
import resource
import signal
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any
from urllib.parse import quote, urlsplit

import psutil
import pytest
from support.sweeps.processes import Running

from sweeps.exits import Exit
from sweeps.page import serving as module
from sweeps.page.serving import Answer, PageServer, PortError, Query, Route

HANGS = 60.0  # seconds: longer than anything takes, on any machine
FOR_EVER = 1e4  # a limit that no test reaches


def giving(answer: Answer) -> Route:
    """A route that always gives this."""

    def give(query: Query) -> Answer:
        return answer

    return give


HELLO = giving(Answer("text/html", b"hello"))


@contextmanager
def served(**routes: Route) -> Iterator[PageServer]:
    """A server with these routes, until the end of the context; `home` is that of "/"."""
    home = routes.pop("home", HELLO)
    server = PageServer({"/": home, **{f"/{name}": route for name, route in routes.items()}})
    thread = server.run_in_background()
    try:
        yield server
    finally:
        server.stop()
        thread.join(HANGS)
        assert not thread.is_alive()


@pytest.fixture(scope="module")
def server() -> Iterator[PageServer]:
    """A server whose limits of time are those of users."""
    with served(echo=lambda query: Answer("text/plain", repr(query).encode())) as server:
        yield server


@pytest.fixture
def limit(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Changes limits of the module."""

    def change(**limits: float) -> None:
        for name, value in limits.items():
            monkeypatch.setattr(module, f"_{name.upper()}", value)

    return change


def token_of(server: PageServer) -> str:
    return urlsplit(server.address).query.removeprefix("token=")


def connected(server: PageServer) -> socket.socket:
    return socket.create_connection(("127.0.0.1", server.port), timeout=HANGS)


def answer(
    server: PageServer, path: str, method: str = "GET", **headers: str
) -> tuple[int, str, http.client.HTTPMessage]:
    """Status, text and headers; TOKEN in the path stands for the right one."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=HANGS)
    with closing(connection):
        named = {name.replace("_", "-"): text for name, text in headers.items()}
        connection.request(method, path.replace("TOKEN", token_of(server)), headers=named)
        response = connection.getresponse()
        return response.status, response.read().decode(), response.headers


def status(server: PageServer, path: str = "/?token=TOKEN", **headers: str) -> int:
    return answer(server, path, **headers)[0]


def request(server: PageServer, path: str = "/") -> bytes:
    """A request with the right token, as it is sent."""
    line = f"GET {path}?token={token_of(server)} HTTP/1.1\r\n"
    return f"{line}Host: 127.0.0.1:{server.port}\r\n\r\n".encode()


def all_of(connection: socket.socket) -> bytes:
    """All that arrives until the other side closes."""
    return b"".join(iter(lambda: connection.recv(1 << 16), b""))


def sent(server: PageServer, text: str) -> bytes:
    """The answer to this, in which TOKEN and PORT stand for those of the server."""
    text = text.replace("TOKEN", token_of(server)).replace("PORT", str(server.port))
    received = b""
    with connected(server) as connection, contextlib.suppress(ConnectionResetError):
        connection.sendall(text.encode("latin-1"))
        while part := connection.recv(1 << 16):
            received += part
    return received  # a reset may follow, where the server has left something unread


def status_of(received: bytes) -> int:
    return int(received.split(b" ", 2)[1]) if received else 0


class Pieces:
    """The body of an answer, of pieces that are handed to it; notes when it is closed."""

    def __init__(self, source: Iterator[bytes]) -> None:
        self._source, self.closed = source, threading.Event()

    def __iter__(self) -> Iterator[bytes]:
        return self

    def __next__(self) -> bytes:
        return next(self._source)

    def close(self) -> None:
        self.closed.set()


# --- the token, and the pages that may ask ---


def test_the_printed_address_opens_the_page(server: PageServer):
    address = urlsplit(server.address)
    assert (address.scheme, address.hostname, address.path) == ("http", "127.0.0.1", "/")
    assert address.port == server.port
    assert answer(server, f"/?{address.query}")[:2] == (200, "hello")


def test_the_right_token_is_admitted_under_both_names_of_the_machine(server: PageServer):
    assert status(server) == 200
    assert status(server, Host=f"localhost:{server.port}") == 200
    assert status(server, Origin=f"http://127.0.0.1:{server.port}") == 200
    assert status(server, Origin=f"http://localhost:{server.port}") == 200


@pytest.mark.parametrize(
    "query",
    ["", "?token=", "?token=wrong", "?token=TOKE", "?token=TOKENx", "?token=TOKEN&token=x",
     "?token=TOKEN&token=", "?token=TOKEN&token=TOKEN", "?token=%C3%A9", "?token=%FF", "?TOKEN",
     "?Token=TOKEN", "?x=TOKEN"],
)  # fmt: skip
@pytest.mark.parametrize("path", ["/", "/echo", "/nowhere"])
def test_without_the_token_everything_is_forbidden(server: PageServer, path: str, query: str):
    if query == "?token=TOKE":
        query = f"?token={token_of(server)[:-1]}"
    told, text, _ = answer(server, path + query)
    assert told == 403
    assert "with its token" in text


def test_the_token_counts_in_the_query_alone(server: PageServer):
    assert status(server, "/", Cookie=f"token={token_of(server)}") == 403
    assert status(server, "/", Authorization=f"Bearer {token_of(server)}") == 403
    assert status(server, "/token=TOKEN") == 403


@pytest.mark.parametrize("host", ["", "evil.example", "evil.example:PORT", "127.0.0.1:80",
                                  "127.0.0.1", "127.0.0.2:PORT", "127.0.0.1:PORT, x",
                                  "\xa0localhost:PORT"])  # fmt: skip
def test_another_host_is_forbidden(server: PageServer, host: str):
    assert status(server, Host=host.replace("PORT", str(server.port))) == 403


def test_a_request_without_a_host_or_with_two_is_forbidden(server: PageServer):
    line, host = "GET /?token=TOKEN HTTP/1.1\r\n", "Host: 127.0.0.1:PORT\r\n"
    assert status_of(sent(server, f"{line}{host}\r\n")) == 200
    assert status_of(sent(server, f"{line}\r\n")) == 403
    assert status_of(sent(server, f"{line}{host}{host}\r\n")) == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "https://127.0.0.1:PORT", "http://127.0.0.1:80", "null", ""]
)
def test_another_origin_is_forbidden(server: PageServer, origin: str):
    assert status(server, Origin=origin.replace("PORT", str(server.port))) == 403


FRAME = {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "iframe"}


@pytest.mark.parametrize("site", ["same-origin", "none"])
def test_the_page_itself_and_a_typed_address_may_ask_for_anything(server: PageServer, site: str):
    assert status(server, "/echo?token=TOKEN", Sec_Fetch_Site=site, Sec_Fetch_Mode="cors") == 200
    assert status(server, Sec_Fetch_Site=site, **FRAME) == 200


@pytest.mark.parametrize("site", ["same-site", "cross-site"])
def test_another_site_may_open_the_page_and_nothing_else(server: PageServer, site: str):
    assert status(server, Sec_Fetch_Site=site, **FRAME) == 200
    assert status(server, Sec_Fetch_Site=site) == 403
    for mode in ("cors", "no-cors", "same-origin", "websocket", ""):
        assert status(server, Sec_Fetch_Site=site, Sec_Fetch_Mode=mode) == 403
    assert status(server, "/echo?token=TOKEN", Sec_Fetch_Site=site, **FRAME) == 403


def test_an_unknown_site_is_forbidden(server: PageServer):
    assert status(server, Sec_Fetch_Site="elsewhere", **FRAME) == 403


def test_tokens_are_long_and_differ():
    tokens = set()
    for _ in range(5):
        with served() as server:
            tokens.add(token_of(server))
    assert len(tokens) == 5
    assert min(map(len, tokens)) >= 40


# --- what is no request of the page ---


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "HEAD", "PATCH", "CONNECT"])
def test_a_method_other_than_get_is_refused(server: PageServer, method: str):
    told = sent(server, f"{method} /?token=TOKEN HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n")
    assert status_of(told) == 405
    assert b"\r\nAllow: GET\r\n" in told


def test_an_unknown_path_is_told(server: PageServer):
    for path in ("/nowhere", "/echo/", "//echo", "/%65cho", "/../echo"):
        assert status(server, f"{path}?token=TOKEN") == 404


def test_parameters_are_decoded_and_the_token_is_not_among_them(server: PageServer):
    path = f"/echo?token=TOKEN&T=2.5e%2B2&name={quote('φ & ω')}&a+b=c+d&empty="
    told, text, _ = answer(server, path)
    assert told == 200
    assert text == repr({"T": "2.5e+2", "name": "φ & ω", "a b": "c d", "empty": ""})


@pytest.mark.parametrize("twice", ["T=1&T=2", "T=1&T=1", "T=&T=1", "T=1&%54=2"])
def test_a_parameter_given_twice_is_refused(server: PageServer, twice: str):
    told, text, _ = answer(server, f"/echo?token=TOKEN&{twice}")
    assert told == 400
    assert text == "400: a parameter is given more than once.\n"


HOST = "Host: 127.0.0.1:PORT\r\n"
ODD = {
    "HTTP/0.9": "GET /?token=TOKEN\r\n\r\n",
    "version": f"GET /?token=TOKEN HTTP/9.9\r\n{HOST}\r\n",
    "HTTP/2": f"PRI * HTTP/2.0\r\n{HOST}\r\n",
    "words": f"GET /?token=TOKEN x HTTP/1.1\r\n{HOST}\r\n",
    "spaces": f"GET  /?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "tab": f"GET\t/?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "first space": f" GET /?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "small letters": f"get /?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "whole address": f"GET http://127.0.0.1:PORT/?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "no path": f"GET ?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "no ASCII": f"GET /?token=TOKEN&x=\xe9 HTTP/1.1\r\n{HOST}\r\n",
    "NUL": f"GET /?token=TOKEN&x=\x00 HTTP/1.1\r\n{HOST}\r\n",
    "empty line": f"\r\nGET /?token=TOKEN HTTP/1.1\r\n{HOST}\r\n",
    "nothing": "\r\n\r\n",
    "fold": f"GET /?token=TOKEN HTTP/1.1\r\n{HOST}X: a\r\n b\r\n\r\n",
    "first fold": f"GET /?token=TOKEN HTTP/1.1\r\n {HOST}\r\n",
    "no colon": f"GET /?token=TOKEN HTTP/1.1\r\n{HOST}X\r\n\r\n",
    "no name": f"GET /?token=TOKEN HTTP/1.1\r\n{HOST}: a\r\n\r\n",
    "space in a name": "GET /?token=TOKEN HTTP/1.1\r\nHost : 127.0.0.1:PORT\r\n\r\n",
    "lone LF": f"GET /?token=TOKEN HTTP/1.1\r\n{HOST}X: a\nY: b\r\n\r\n",
    "lone CR": f"GET /?token=TOKEN HTTP/1.1\r\n{HOST}X: a\rY: b\r\n\r\n",
    "TLS": "\x16\x03\x01\x02\x00\x01\r\n\r\n",
}


@pytest.mark.parametrize("odd", ODD)
def test_what_no_browser_sends_is_refused(server: PageServer, odd: str):
    told = sent(server, ODD[odd])
    assert status_of(told) == 400
    assert told.endswith(b"\r\n\r\n400: this is no request of a browser.\n")


def test_headers_may_have_16_kib_and_no_more(server: PageServer):
    line = f"GET /?token={token_of(server)} HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nX: "
    most = (1 << 14) - len(line) - len("\r\n\r\n")
    assert status_of(sent(server, f"{line}{'x' * most}\r\n\r\n")) == 200
    assert status_of(sent(server, f"{line}{'x' * (most + 1)}\r\n\r\n")) == 431
    assert status_of(sent(server, "x" * (1 << 14))) == 431


@pytest.mark.parametrize("odd", ["X:" + " " * 16000 + "\x00", "X" * 16000, "X: a\r\n" * 2600])
def test_long_headers_take_no_long_time_to_judge(odd: str):
    start = time.thread_time()
    with contextlib.suppress(Exception):
        module._parsed(f"GET / HTTP/1.1\r\n{odd}")
    assert time.thread_time() - start < 0.2


@pytest.mark.parametrize("path", ["/?token=TOKEN", "/", "/echo?token=TOKEN"])
def test_a_large_body_is_not_taken_in(server: PageServer, path: str):
    size, taken, piece = 1 << 30, 0, bytes(1 << 20)
    line = f"POST {path.replace('TOKEN', token_of(server))} HTTP/1.1\r\n"
    head = f"{line}Host: 127.0.0.1:{server.port}\r\nContent-Length: {size}\r\n\r\n"
    with connected(server) as connection:
        connection.sendall(head.encode())
        with contextlib.suppress(ConnectionError):
            while taken < size:
                taken += connection.send(piece)
    assert taken < size / 8  # what fits into the sockets


def test_the_headers_of_an_answer_keep_it_on_this_page(server: PageServer):
    paths = ("/?token=TOKEN", "/echo?token=TOKEN", "/", "/nowhere?token=TOKEN", "/?token=TOKEN&a&a")
    for path in paths:
        _, _, headers = answer(server, path)
        assert headers["Cache-Control"] == "no-store"
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert headers["Connection"] == "close"


def test_a_route_gives_type_status_and_headers():
    told = Answer("text/html; charset=utf-8", b"<p>", {"Content-Security-Policy": "x"}, 409)
    with served(home=giving(told)) as server:
        code, text, headers = answer(server, "/?token=TOKEN")
    assert (code, text) == (409, "<p>")
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert headers["Content-Security-Policy"] == "x"
    assert headers["Content-Length"] == "3"
    assert headers["Cache-Control"] == "no-store"


# --- connections that never show the token ---


@contextmanager
def many_files() -> Iterator[None]:
    """As many open files as these tests want."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < 2048:
        pytest.skip("this machine allows too few open files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 2048), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def established(server: PageServer) -> int:
    """The connections that the server keeps."""
    there = [
        c
        for c in psutil.Process().net_connections(kind="inet")
        if c.laddr.port == server.port and c.raddr
    ]
    return sum(c.status == psutil.CONN_ESTABLISHED for c in there)


def test_1100_half_sent_requests_leave_room_for_the_owner(limit: Callable[..., None]):
    limit(request_seconds=FOR_EVER)
    with served() as server, many_files(), ExitStack() as stack:
        for _ in range(1100):
            half = stack.enter_context(connected(server))
            half.sendall(b"GET / HTTP/1.1\r\n")
        assert status(server) == 200
        assert established(server) <= 64


FEEDERS = """
import socket, sys

address, number = ("127.0.0.1", int(sys.argv[1])), int(sys.argv[2])
clients = [socket.create_connection(address) for _ in range(number)]
while True:
    for place, client in enumerate(clients):
        try:
            client.send(b"x")
        except OSError:
            client.close()
            clients[place] = socket.create_connection(address)
    print("again", flush=True)
"""


def test_200_clients_that_feed_a_byte_at_a_time_do_not_keep_the_owner_waiting(
    limit: Callable[..., None],
):
    limit(request_seconds=FOR_EVER)
    with served() as server:
        feeders = Running("-c", FEEDERS, str(server.port), "200")
        for times in range(2, 7):
            feeders.says("again", times)
            assert status_soon(server) == 200
        assert feeders.is_alive()
        feeders.end()


def status_soon(server: PageServer) -> int:
    """The status that the owner gets, who opens the page again if it was closed.

    A connection that waits for its processor before it sends may be the oldest of many by then.
    """
    for _ in range(10):
        with contextlib.suppress(ConnectionError, http.client.HTTPException):
            return status(server)
    return 0


def test_the_oldest_stranger_gives_way_to_a_new_one(limit: Callable[..., None]):
    limit(request_seconds=FOR_EVER, strangers=3)
    with served() as server, ExitStack() as stack:
        strangers = [stack.enter_context(connected(server)) for _ in range(4)]
        assert strangers[0].recv(1) == b""
        for later in strangers[1:]:
            later.sendall(request(server))
            assert status_of(all_of(later)) == 200


@pytest.mark.parametrize("what", [b"", b"x"])
def test_the_time_of_a_stranger_ends_whatever_it_sends(limit: Callable[..., None], what: bytes):
    limit(request_seconds=0.3)
    with served() as server, connected(server) as client:
        client.settimeout(0.01)
        latest = time.monotonic() + HANGS
        with contextlib.suppress(ConnectionError):
            while True:
                assert time.monotonic() < latest
                client.sendall(what)
                with contextlib.suppress(TimeoutError):
                    assert client.recv(1) == b""
                    break


def test_an_answer_may_take_longer_than_a_request(limit: Callable[..., None]):
    limit(request_seconds=0.2)
    may_end = threading.Event()

    def wait(query: Query) -> Answer:
        assert may_end.wait(HANGS)
        return Answer("text/plain", b"late")

    with served(wait=wait) as server, connected(server) as owner:
        owner.sendall(request(server, "/wait"))
        with connected(server) as stranger:  # came later, and its time ends first
            assert stranger.recv(1) == b""
        may_end.set()
        assert all_of(owner).endswith(b"late")


def test_strangers_that_do_not_read_their_refusal_do_not_block_it(limit: Callable[..., None]):
    limit(request_seconds=FOR_EVER)
    with served() as server, ExitStack() as stack:
        for _ in range(100):
            client = stack.enter_context(socket.socket())
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
            client.connect(("127.0.0.1", server.port))
            client.sendall(b"GET / HTTP/1.1\r\n\r\n")
        assert status(server) == 200


def test_a_stranger_gets_no_thread(limit: Callable[..., None]):
    limit(request_seconds=FOR_EVER)
    with served() as server, ExitStack() as stack:
        before = threading.active_count()
        for _ in range(50):
            client = stack.enter_context(connected(server))
            client.sendall(b"GET / HTTP/1.1\r\n")
        assert status(server, "/") == 403
        assert threading.active_count() == before


def test_a_request_is_whole_wherever_it_is_cut(server: PageServer):
    whole = request(server)
    for cut in (1, 10, *range(len(whole) - 5, len(whole))):
        with connected(server) as client:
            client.sendall(whole[:cut])
            assert status(server, "/") == 403  # came later: what was sent has been read
            client.sendall(whole[cut:])
            assert status_of(all_of(client)) == 200


def test_a_stranger_that_ends_is_closed(limit: Callable[..., None]):
    limit(request_seconds=FOR_EVER)
    with served() as server, connected(server) as client:
        client.sendall(b"GET / HTTP/1.1\r\n")
        client.shutdown(socket.SHUT_WR)
        assert client.recv(1) == b""


def test_a_stranger_that_resets_its_connection_takes_nothing_with_it(server: PageServer):
    with connected(server) as client:
        client.sendall(b"GET / HTTP/1.1\r\n")
        assert status(server, "/") == 403
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    assert status(server) == 200


def test_it_goes_on_when_this_process_has_no_file_left():
    with served() as server, closing(socket.socket()) as client:
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (client.fileno() + 1, hard))
        try:
            with ExitStack() as stack:
                with contextlib.suppress(OSError):
                    while True:
                        stack.enter_context(socket.socket())
                client.settimeout(0.2)
                client.connect(("127.0.0.1", server.port))
                client.sendall(request(server))
                with pytest.raises(TimeoutError):
                    client.recv(1)
        finally:
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        client.settimeout(HANGS)
        assert status_of(all_of(client)) == 200


def test_it_goes_on_when_this_process_gets_no_more_threads(monkeypatch: pytest.MonkeyPatch):
    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with served() as server:
        for _ in range(100):  # none counts as under way
            with monkeypatch.context() as without, connected(server) as client:
                without.setattr(threading.Thread, "start", refuse)
                client.sendall(request(server))
                assert client.recv(1) == b""
        assert status(server) == 200


# --- answers ---


def test_a_stream_is_read_as_it_is_made():
    may_go_on: list[threading.Event] = [threading.Event() for _ in range(3)]

    def stream(query: Query) -> Answer:
        def pieces() -> Iterator[bytes]:
            for number, event in enumerate(may_go_on):
                yield f"piece {number};".encode()
                assert event.wait(HANGS)

        return Answer("text/plain", pieces())

    with served(stream=stream) as server, connected(server) as client:
        client.sendall(request(server, "/stream"))
        received = b""
        for number, event in enumerate(may_go_on):
            while not received.endswith(f"piece {number};".encode()):
                part = client.recv(1 << 16)
                assert part
                received += part
            event.set()
        assert all_of(client) == b""
    assert b"Content-Length" not in received


def test_a_stream_may_be_empty():
    with served(stream=giving(Answer("text/plain", iter(())))) as server:
        assert answer(server, "/stream?token=TOKEN")[:2] == (200, "")


def test_a_client_that_goes_away_closes_the_stream():
    is_gone, computed = threading.Event(), []

    def source() -> Iterator[bytes]:
        yield b"first"
        assert is_gone.wait(HANGS)
        yield b""
        computed.append("what nobody waits for")

    pieces = Pieces(source())
    with served(stream=giving(Answer("text/plain", pieces))) as server:
        with connected(server) as client:
            client.sendall(request(server, "/stream"))
            received = b""
            while not received.endswith(b"first"):
                received += client.recv(1 << 16)
        assert not pieces.closed.is_set()
        is_gone.set()
        assert pieces.closed.wait(HANGS)
    assert computed == []


def test_a_stream_that_is_read_to_its_end_is_closed_too():
    pieces = Pieces(iter([b"a", b"b"]))
    with served(stream=giving(Answer("text/plain", pieces))) as server:
        assert answer(server, "/stream?token=TOKEN")[1] == "ab"
    assert pieces.closed.wait(HANGS)


def endless() -> Iterator[bytes]:
    while True:
        yield bytes(1 << 20)


def test_a_client_that_does_not_read_is_given_up(limit: Callable[..., None]):
    limit(stalled_seconds=0.2)
    pieces = Pieces(endless())
    with served(stream=giving(Answer("text/plain", pieces))) as server:
        with connected(server) as client:
            client.sendall(request(server, "/stream"))
            assert pieces.closed.wait(HANGS)
        assert status(server) == 200


def test_a_client_that_reads_slowly_is_not(limit: Callable[..., None]):
    """It reads for longer than one that does not read is waited for."""
    size, stalled = 24 << 20, 0.8
    limit(stalled_seconds=stalled)
    with served(large=giving(Answer("text/plain", bytes(size)))) as server:
        for _ in range(5):
            read, longest = read_slowly(server, 2 * stalled)
            if read >= size or longest < stalled / 2:
                break  # else this machine let the reader itself wait: it says nothing
        assert read >= size


def read_slowly(server: PageServer, seconds: float) -> tuple[int, float]:
    """How much is read of /large until it ends, with a pause after each part; the longest pause."""
    read, longest = 0, 0.0
    with closing(socket.socket()) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 16)
        client.settimeout(HANGS)
        client.connect(("127.0.0.1", server.port))
        client.sendall(request(server, "/large"))
        start = before = time.monotonic()
        with contextlib.suppress(ConnectionError):
            while part := client.recv(1 << 14):
                read += len(part)
                if before - start < seconds:
                    time.sleep(0.02)
                now = time.monotonic()
                longest, before = max(longest, now - before), now
    return read, longest


def test_one_request_too_many_is_told_and_the_others_are_answered(limit: Callable[..., None]):
    limit(admitted=2)
    may_end, begun = threading.Event(), threading.Semaphore(0)

    def wait(query: Query) -> Answer:
        begun.release()
        assert may_end.wait(HANGS)
        return Answer("text/plain", b"done")

    with served(wait=wait) as server, connected(server) as one, connected(server) as two:
        for client in (one, two):
            client.sendall(request(server, "/wait"))
            assert begun.acquire(timeout=HANGS)
        told, text, _ = answer(server, "/?token=TOKEN")
        assert told == 503
        assert "close some tabs, and reload" in text
        may_end.set()
        for client in (one, two):
            assert all_of(client).endswith(b"done")
        assert status(server) == 200


def test_as_many_requests_as_a_browser_makes_are_answered_at_once():
    together = threading.Barrier(64)

    def wait(query: Query) -> Answer:
        together.wait(HANGS)
        return Answer("text/plain", b"done")

    with served(wait=wait) as server, ExitStack() as stack:
        clients = [stack.enter_context(connected(server)) for _ in range(64)]
        for client in clients:
            client.sendall(request(server, "/wait"))
        assert {status_of(all_of(client)) for client in clients} == {200}


def fail(query: Query) -> Answer:
    raise TypeError("no <orbit>")


def fail_with_a_name_that_is_no_text(query: Query) -> Answer:
    raise FileNotFoundError(os.fsdecode(b"\xff.nc"))


def breaking() -> Iterator[bytes]:
    yield b"half of it"
    raise TypeError("no <orbit>")


@pytest.mark.parametrize(
    "failing",
    [
        fail,
        giving(Answer("text/plain", (1 // 0 for _ in "x"))),
        giving(Answer("text/plain", b"", {"X": "a\r\nY: b"})),
        giving(Answer("text/plain", b"", {"X": "φ"})),
        giving(Answer("text/plain", b"", status=1)),
        giving(None),
    ],
)
def test_a_route_that_fails_says_so_in_a_sentence_and_shows_no_trace(
    failing: Route, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
):
    with caplog.at_level("DEBUG"), served(fails=failing) as server:
        told, text, headers = answer(server, "/fails?token=TOKEN")
        assert status(server) == 200
    assert told == 500
    assert text.startswith("500: unexpected ")
    assert text.count("\n") == 1
    assert headers["Content-Type"] == "text/plain; charset=utf-8"
    assert capfd.readouterr() == ("", "")
    assert "Traceback" in caplog.text
    assert {record.levelno for record in caplog.records} == {logging.DEBUG}


def test_a_failure_with_a_name_that_is_no_text_is_told_as_any_other():
    with served(fails=fail_with_a_name_that_is_no_text) as server:
        told, text, _ = answer(server, "/fails?token=TOKEN")
    assert told == 500
    assert text.startswith("500: unexpected FileNotFoundError")


def test_the_sentence_of_a_failure_has_its_kind():
    with served(fails=fail) as server:
        text = answer(server, "/fails?token=TOKEN")[1]
    assert text == "500: unexpected TypeError: no <orbit>.\n"


def test_a_stream_that_breaks_off_does_not_look_whole(capfd: pytest.CaptureFixture[str]):
    with served(breaks=giving(Answer("text/plain", breaking()))) as server:
        with connected(server) as client:
            client.sendall(request(server, "/breaks"))
            with pytest.raises(ConnectionResetError):
                all_of(client)
        assert status(server) == 200
    assert capfd.readouterr() == ("", "")


def test_a_stream_whose_end_fails_takes_nothing_with_it(capfd: pytest.CaptureFixture[str]):
    class Failing(Pieces):
        def close(self) -> None:
            super().close()
            raise OSError("cannot be closed")

    pieces = Failing(endless())
    with served(stream=giving(Answer("text/plain", pieces))) as server:
        with connected(server) as client:
            client.sendall(request(server, "/stream"))
            assert client.recv(1)
        assert pieces.closed.wait(HANGS)
        assert status(server) == 200
    assert capfd.readouterr() == ("", "")


# --- what is told of it, and its end ---


def test_nothing_is_printed_and_the_token_is_never_logged(
    caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
):
    with caplog.at_level("DEBUG"), served(fails=fail) as server:
        token = token_of(server)
        for path in ("/", "/nowhere", "/fails"):
            status(server, f"{path}?token=TOKEN")
            status(server, f"{path}?token=TOKEN&a=1&a=2")
            status(server, f"{path}?token=TOKEN", Host="x")
        for odd in ODD.values():
            sent(server, odd)
        with connected(server) as client:
            client.sendall(f"GET /?token={token}".encode())
    assert caplog.records
    assert token not in caplog.text
    assert capfd.readouterr() == ("", "")


def test_the_token_is_not_in_an_answer(server: PageServer):
    for path in ("/?token=TOKEN&a&a", "/echo?token=TOKEN", "/nowhere?token=TOKEN", "/token=TOKEN"):
        assert token_of(server) not in answer(server, path)[1]


def test_it_listens_on_the_loopback_alone(server: PageServer):
    connections = psutil.Process().net_connections(kind="inet")
    listening = [c.laddr for c in connections if c.status == psutil.CONN_LISTEN]
    assert [address.ip for address in listening if address.port == server.port] == ["127.0.0.1"]


def test_a_port_in_use_is_an_error_with_a_remedy(server: PageServer):
    with pytest.raises(PortError, match=r"cannot be used: .* in use; give another --port") as told:
        PageServer({}, server.port)
    assert told.value.code is Exit.STORAGE


def test_it_ends_soon_while_connections_hang(limit: Callable[..., None]):
    limit(request_seconds=FOR_EVER, stalled_seconds=FOR_EVER)
    may_end, begun = threading.Event(), threading.Semaphore(0)
    pieces = Pieces(endless())

    def wait(query: Query) -> Answer:
        begun.release()
        assert may_end.wait(HANGS)
        return Answer("text/plain", b"done")

    def stream(query: Query) -> Answer:
        begun.release()
        return Answer("text/plain", pieces)

    with ExitStack() as stack:
        with served(wait=wait, stream=stream) as server:
            half, waiting, not_reading = (stack.enter_context(connected(server)) for _ in range(3))
            half.sendall(b"GET / HTTP/1.1\r\n")
            waiting.sendall(request(server, "/wait"))
            not_reading.sendall(request(server, "/stream"))
            for _ in range(2):
                assert begun.acquire(timeout=HANGS)
        assert half.recv(1) == b""
        assert waiting.recv(1) == b""
        assert pieces.closed.wait(HANGS)
        may_end.set()
        with closing(socket.socket()) as probe:
            assert probe.connect_ex(("127.0.0.1", server.port)) != 0


def test_it_may_be_stopped_before_it_runs_and_more_than_once():
    server = PageServer({})
    server.stop()
    server.run()
    server.stop()


class _Ended(BaseException):
    """What stands for the end of the process."""


@pytest.fixture
def signals(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    """What is done at a signal; the process goes on."""
    done: list[Any] = []

    def end(code: int) -> None:
        done.append(code)
        raise _Ended

    monkeypatch.setattr(os, "_exit", end)
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.signal(number, signal.SIG_DFL) for number in numbers]
    yield done
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


def once_it_answers(server: PageServer, *numbers: int) -> threading.Thread:
    """Send signals to this process, before each of which the server still answers."""

    def act() -> None:
        for number in numbers:
            status(server)
            os.kill(os.getpid(), number)

    thread = threading.Thread(target=act, daemon=True)
    thread.start()
    return thread


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_process(signals: list[Any], number: signal.Signals):
    server = PageServer({"/": HELLO})
    thread = once_it_answers(server, number)
    with pytest.raises(_Ended):
        server.run_until_signal(lambda: signals.append("at the end"))
    thread.join(HANGS)
    assert signals == ["at the end", Exit.DONE]


def test_signals_that_are_ignored_stay_ignored(signals: list[Any]):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    server = PageServer({"/": HELLO})
    thread = once_it_answers(server, signal.SIGHUP, signal.SIGHUP, signal.SIGTERM)
    with pytest.raises(_Ended):
        server.run_until_signal(lambda: signals.append("at the end"))
    thread.join(HANGS)
    assert signals == ["at the end", Exit.DONE]
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
