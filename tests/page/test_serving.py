"""How long and how much of a request the server reads, how it answers, and how it ends."""

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

import psutil
import pytest
from support.serving import (
    HANGS,
    HELLO,
    all_of,
    answer,
    connected,
    giving,
    request,
    served,
    status,
    status_of,
    token_of,
)
from support.sweeps.processes import Running

from sweeps.exits import Exit
from sweeps.page import serving as module
from sweeps.page.admission import Query
from sweeps.page.serving import Answer, PageServer, PortError, Route

FOREVER = 1e4  # a limit that no test reaches


@pytest.fixture(scope="module")
def server() -> Iterator[PageServer]:
    """A server with the time limits that users have."""
    with served() as server:
        yield server


@pytest.fixture
def limit(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Change limits of the module."""

    def change(**limits: float) -> None:
        for name, value in limits.items():
            monkeypatch.setattr(module, f"_{name.upper()}", value)

    return change


@pytest.fixture
def patient(limit: Callable[..., None]) -> Iterator[PageServer]:
    """A server that waits forever for the requests of strangers."""
    limit(request_seconds=FOREVER)
    with served() as server:
        yield server


def streaming(body: Iterator[bytes]) -> Route:
    return giving(Answer("text/plain", body))


class Pieces:
    """The body of an answer, made of given pieces; it notes when it is closed."""

    def __init__(self, source: Iterator[bytes]) -> None:
        self._source, self.closed = source, threading.Event()

    def __iter__(self) -> Iterator[bytes]:
        return self

    def __next__(self) -> bytes:
        return next(self._source)

    def close(self) -> None:
        self.closed.set()


def endless() -> Iterator[bytes]:
    while True:
        yield bytes(1 << 20)


class Waiting:
    """A route whose answers wait for `may_end`; `begun` counts the requests that reach it."""

    def __init__(self) -> None:
        self.may_end, self.begun = threading.Event(), threading.Semaphore(0)

    def __call__(self, _: Query) -> Answer:
        self.begun.release()
        assert self.may_end.wait(HANGS)
        return Answer("text/plain", b"done")

    def wait_for_requests(self, count: int) -> None:
        for _ in range(count):
            assert self.begun.acquire(timeout=HANGS)


# --- connections that never show the token ---


@contextmanager
def limited_files(most: int) -> Iterator[None]:
    """Limit this process to this number of open files."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < most:
        pytest.skip("this machine allows too few open files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def established(server: PageServer) -> int:
    """Return the number of connections that the server keeps."""
    connections = psutil.Process().net_connections(kind="inet")
    own = [c for c in connections if c.laddr.port == server.port and c.raddr]
    return sum(c.status == psutil.CONN_ESTABLISHED for c in own)


@pytest.mark.faults
def test_1100_half_sent_requests_leave_room_for_the_owner(patient: PageServer):
    with limited_files(2048), ExitStack() as stack:
        for _ in range(1100):
            half = stack.enter_context(connected(patient))
            half.sendall(b"GET / HTTP/1.1\r\n")
        assert status(patient) == 200
        assert established(patient) <= 64


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


def test_200_clients_that_send_a_byte_at_a_time_do_not_keep_the_owner_waiting(patient: PageServer):
    feeders = Running("-c", FEEDERS, str(patient.port), "200")
    for times in range(2, 7):
        feeders.says("again", times)
        assert status_soon(patient) == 200
    assert feeders.is_alive()
    feeders.end()


def status_soon(server: PageServer) -> int:
    """Return the status that the owner gets, who tries again if the connection was closed.

    If the owner gets no processor time before sending, its connection may be the oldest of many.
    """
    for _ in range(10):
        with contextlib.suppress(ConnectionError, http.client.HTTPException):
            return status(server)
    return 0


def test_the_oldest_stranger_gives_way_to_a_new_one(limit: Callable[..., None]):
    limit(request_seconds=FOREVER, strangers=3)
    with served() as server, ExitStack() as stack:
        strangers = [stack.enter_context(connected(server)) for _ in range(4)]
        assert strangers[0].recv(1) == b""
        for later in strangers[1:]:
            later.sendall(request(server))
            assert status_of(all_of(later)) == 200


@pytest.mark.parametrize("piece", [b"", b"x"])
def test_the_time_of_a_stranger_ends_whatever_it_sends(limit: Callable[..., None], piece: bytes):
    limit(request_seconds=0.3)
    with served() as server, connected(server) as client:
        client.settimeout(0.01)
        latest = time.monotonic() + HANGS
        with contextlib.suppress(ConnectionError):
            while True:
                assert time.monotonic() < latest
                client.sendall(piece)
                with contextlib.suppress(TimeoutError):
                    assert client.recv(1) == b""
                    break


def test_an_answer_may_take_longer_than_a_request(limit: Callable[..., None]):
    limit(request_seconds=0.2)
    wait = Waiting()
    with served(wait=wait) as server, connected(server) as owner:
        owner.sendall(request(server, "/wait"))
        with connected(server) as stranger:  # came later, and its time ends first
            assert stranger.recv(1) == b""
        wait.may_end.set()
        assert all_of(owner).endswith(b"done")


def test_strangers_that_do_not_read_their_refusal_do_not_block_it(patient: PageServer):
    with ExitStack() as stack:
        for _ in range(100):
            client = stack.enter_context(socket.socket())
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
            client.connect(("127.0.0.1", patient.port))
            client.sendall(b"GET / HTTP/1.1\r\n\r\n")
        assert status(patient) == 200


def test_a_stranger_gets_no_thread(patient: PageServer):
    before = threading.active_count()
    with ExitStack() as stack:
        for _ in range(50):
            client = stack.enter_context(connected(patient))
            client.sendall(b"GET / HTTP/1.1\r\n")
        assert status(patient, "/") == 403
        assert threading.active_count() == before


def test_a_request_is_whole_wherever_it_is_cut(server: PageServer):
    whole = request(server)
    for cut in (1, 10, *range(len(whole) - 5, len(whole))):
        with connected(server) as client:
            client.sendall(whole[:cut])
            assert status(server, "/") == 403  # came later, so the first part has been read
            client.sendall(whole[cut:])
            assert status_of(all_of(client)) == 200


def test_a_stranger_that_ends_is_closed(patient: PageServer):
    with connected(patient) as client:
        client.sendall(b"GET / HTTP/1.1\r\n")
        client.shutdown(socket.SHUT_WR)
        assert client.recv(1) == b""


def test_the_server_survives_a_stranger_that_resets_its_connection(server: PageServer):
    with connected(server) as client:
        client.sendall(b"GET / HTTP/1.1\r\n")
        assert status(server, "/") == 403
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    assert status(server) == 200


def test_the_server_goes_on_when_this_process_has_no_file_left():
    with served() as server, closing(socket.socket()) as client:
        with limited_files(client.fileno() + 1), ExitStack() as stack:
            with contextlib.suppress(OSError):
                while True:
                    stack.enter_context(socket.socket())
            client.settimeout(0.2)
            client.connect(("127.0.0.1", server.port))
            client.sendall(request(server))
            with pytest.raises(TimeoutError):
                client.recv(1)
        client.settimeout(HANGS)
        assert status_of(all_of(client)) == 200


def test_the_server_goes_on_when_this_process_gets_no_more_threads(monkeypatch: pytest.MonkeyPatch):
    def refuse(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with served() as server:
        for _ in range(100):  # none of them counts as under way
            with monkeypatch.context() as without, connected(server) as client:
                without.setattr(threading.Thread, "start", refuse)
                client.sendall(request(server))
                assert client.recv(1) == b""
        assert status(server) == 200


# --- answers ---


@pytest.mark.parametrize(
    "path", ["/?token=TOKEN", "/", "/nowhere?token=TOKEN", "/?token=TOKEN&a&a"]
)
def test_the_headers_of_an_answer_keep_it_on_this_page(server: PageServer, path: str):
    headers = answer(server, path)[2]
    assert headers["Cache-Control"] == "no-store"
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
    assert headers["Connection"] == "close"


def test_a_route_gives_type_status_and_headers():
    given = Answer("text/html; charset=utf-8", b"<p>", {"Content-Security-Policy": "x"}, 409)
    with served(home=giving(given)) as server:
        code, text, headers = answer(server, "/?token=TOKEN")
    assert (code, text) == (409, "<p>")
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert headers["Content-Security-Policy"] == "x"
    assert headers["Content-Length"] == "3"
    assert headers["Cache-Control"] == "no-store"


def test_a_stream_is_read_as_it_is_made():
    may_go_on = [threading.Event() for _ in range(3)]

    def pieces() -> Iterator[bytes]:
        for number, event in enumerate(may_go_on):
            yield f"piece {number};".encode()
            assert event.wait(HANGS)

    with served(stream=streaming(pieces())) as server, connected(server) as client:
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


def test_a_client_that_goes_away_closes_the_stream():
    is_gone, computed = threading.Event(), []

    def source() -> Iterator[bytes]:
        yield b"first"
        assert is_gone.wait(HANGS)
        yield b""
        computed.append("what nobody waits for")

    pieces = Pieces(source())
    with served(stream=streaming(pieces)) as server:
        with connected(server) as client:
            client.sendall(request(server, "/stream"))
            received = b""
            while not received.endswith(b"first"):
                received += client.recv(1 << 16)
        assert not pieces.closed.is_set()
        is_gone.set()
        assert pieces.closed.wait(HANGS)
    assert computed == []


@pytest.mark.parametrize("parts", [[], [b"a", b"b"]])
def test_a_stream_that_is_read_to_its_end_is_closed_too(parts: list[bytes]):
    pieces = Pieces(iter(parts))
    with served(stream=streaming(pieces)) as server:
        assert answer(server, "/stream?token=TOKEN")[:2] == (200, b"".join(parts).decode())
    assert pieces.closed.wait(HANGS)


def test_a_client_that_does_not_read_is_given_up(limit: Callable[..., None]):
    limit(stalled_seconds=0.2)
    pieces = Pieces(endless())
    with served(stream=streaming(pieces)) as server:
        with connected(server) as client:
            client.sendall(request(server, "/stream"))
            assert pieces.closed.wait(HANGS)
        assert status(server) == 200


def test_a_client_that_reads_slowly_is_not_given_up(limit: Callable[..., None]):
    """It reads for longer than the server waits for a client that does not read."""
    size, stalled = 24 << 20, 0.8
    limit(stalled_seconds=stalled)
    with served(large=giving(Answer("text/plain", bytes(size)))) as server:
        for _ in range(5):
            read, longest = read_slowly(server, 2 * stalled)
            if read >= size or longest < stalled / 2:
                break  # otherwise this machine delayed the reader, which proves nothing
        assert read >= size


def read_slowly(server: PageServer, seconds: float) -> tuple[int, float]:
    """Read /large with a pause after each part; return the bytes read and the longest pause."""
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


def test_one_request_too_many_is_refused_and_the_others_are_answered(limit: Callable[..., None]):
    limit(admitted=2)
    wait = Waiting()
    with served(wait=wait) as server, connected(server) as one, connected(server) as two:
        for client in (one, two):
            client.sendall(request(server, "/wait"))
        wait.wait_for_requests(2)
        code, text, _ = answer(server, "/?token=TOKEN")
        assert code == 503
        assert "close some tabs, and reload" in text
        wait.may_end.set()
        for client in (one, two):
            assert all_of(client).endswith(b"done")
        assert status(server) == 200


def test_as_many_requests_as_a_browser_makes_are_answered_at_once():
    wait = Waiting()
    with served(wait=wait) as server, ExitStack() as stack:
        clients = [stack.enter_context(connected(server)) for _ in range(64)]
        for client in clients:
            client.sendall(request(server, "/wait"))
        wait.wait_for_requests(64)
        wait.may_end.set()
        assert {status_of(all_of(client)) for client in clients} == {200}


def fail(query: Query) -> Answer:
    raise TypeError("no <orbit>")


def fail_with_a_name_of_odd_bytes(query: Query) -> Answer:
    raise FileNotFoundError(os.fsdecode(b"\xff.nc"))


def breaking() -> Iterator[bytes]:
    yield b"half of it"
    raise TypeError("no <orbit>")


@pytest.mark.parametrize(
    ("failing", "sentence"),
    [
        (fail, "TypeError: no <orbit>.\n"),
        (streaming(1 // 0 for _ in "x"), "ZeroDivisionError"),
        (giving(Answer("text/plain", b"", {"X": "a\r\nY: b"})), "ValueError"),
        (giving(Answer("text/plain", b"", {"X": "φ"})), "UnicodeEncodeError"),
        (giving(Answer("text/plain", b"", status=1)), "ValueError"),
        (giving(None), "AttributeError"),
    ],
)
def test_a_route_that_fails_says_so_in_a_sentence_and_shows_no_trace(
    failing: Route,
    sentence: str,
    capfd: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
):
    with caplog.at_level("DEBUG"), served(fails=failing) as server:
        code, text, headers = answer(server, "/fails?token=TOKEN")
        assert status(server) == 200
    assert code == 500
    assert text.startswith(f"500: unexpected {sentence}")
    assert text.count("\n") == 1
    assert headers["Content-Type"] == "text/plain; charset=utf-8"
    assert capfd.readouterr() == ("", "")
    assert "Traceback" in caplog.text
    assert {record.levelno for record in caplog.records} == {logging.DEBUG}


def test_a_route_that_fails_with_a_name_of_odd_bytes_says_so():
    # Alone and without a log: pytest-xdist cannot hand over a log with such a name.
    with served(fails=fail_with_a_name_of_odd_bytes) as server:
        code, text, _ = answer(server, "/fails?token=TOKEN")
    assert code == 500
    assert text.startswith("500: unexpected FileNotFoundError")


def test_a_stream_that_breaks_off_does_not_look_whole(capfd: pytest.CaptureFixture[str]):
    with served(breaks=streaming(breaking())) as server:
        with connected(server) as client:
            client.sendall(request(server, "/breaks"))
            with pytest.raises(ConnectionResetError):
                all_of(client)
        assert status(server) == 200
    assert capfd.readouterr() == ("", "")


def test_the_server_survives_a_stream_that_cannot_be_closed(capfd: pytest.CaptureFixture[str]):
    class Failing(Pieces):
        def close(self) -> None:
            super().close()
            raise OSError("cannot be closed")

    pieces = Failing(endless())
    with served(stream=streaming(pieces)) as server:
        with connected(server) as client:
            client.sendall(request(server, "/stream"))
            assert client.recv(1)
        assert pieces.closed.wait(HANGS)
        assert status(server) == 200
    assert capfd.readouterr() == ("", "")


# --- what the server reports, and its end ---


def test_nothing_is_printed_and_the_token_is_never_logged(
    caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
):
    with caplog.at_level("DEBUG"), served(fails=fail) as server:
        token = token_of(server)
        for path in ("/", "/nowhere", "/fails"):
            status(server, f"{path}?token=TOKEN")
            status(server, f"{path}?token=TOKEN&a=1&a=2")
            status(server, f"{path}?token=TOKEN", Host="x")
        with connected(server) as client:
            client.sendall(f"GET /?token={token}".encode())
    assert caplog.records
    assert token not in caplog.text
    assert capfd.readouterr() == ("", "")


def test_the_server_listens_on_the_loopback_alone(server: PageServer):
    connections = psutil.Process().net_connections(kind="inet")
    listening = [c.laddr for c in connections if c.status == psutil.CONN_LISTEN]
    assert [address.ip for address in listening if address.port == server.port] == ["127.0.0.1"]


def test_a_port_in_use_is_an_error_with_a_remedy(server: PageServer):
    with pytest.raises(PortError, match=r"cannot be used: .* in use; give another --port") as error:
        PageServer({}, server.port)
    assert error.value.code is Exit.STORAGE


def test_the_server_ends_soon_while_connections_hang(limit: Callable[..., None]):
    limit(request_seconds=FOREVER, stalled_seconds=FOREVER)
    wait, pieces = Waiting(), Pieces(endless())
    with ExitStack() as stack:
        with served(wait=wait, stream=streaming(pieces)) as server:
            half, waiting, not_reading = (stack.enter_context(connected(server)) for _ in range(3))
            half.sendall(b"GET / HTTP/1.1\r\n")
            waiting.sendall(request(server, "/wait"))
            not_reading.sendall(request(server, "/stream"))
            wait.wait_for_requests(1)
            assert not_reading.recv(1)
        assert half.recv(1) == b""
        assert waiting.recv(1) == b""
        assert pieces.closed.wait(HANGS)
        wait.may_end.set()
        with closing(socket.socket()) as probe:
            assert probe.connect_ex(("127.0.0.1", server.port)) != 0


def test_a_server_may_be_stopped_before_it_runs_and_more_than_once():
    server = PageServer({})
    server.stop()
    server.run()
    server.stop()


class _Ended(BaseException):
    """Stands for the end of the process."""


@pytest.fixture
def signals(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    """Record what is done at a signal; the process goes on."""
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


def to_process(number: int) -> None:
    os.kill(os.getpid(), number)


def to_own_thread(number: int) -> None:
    signal.pthread_kill(threading.get_ident(), number)


def run_with_signals(
    done: list[Any], *numbers: int, send: Callable[[int], None] = to_process
) -> None:
    """Run a server while this process gets signals; the server answers before each of them."""
    server, ended = PageServer({"/": HELLO}), threading.Event()

    def act() -> None:
        for number in numbers:
            status(server)
            send(number)
        if not ended.wait(HANGS):
            done.append("it hangs")
            server.stop()

    thread = threading.Thread(target=act, daemon=True)
    thread.start()
    with pytest.raises(_Ended):
        server.run_until_signal(lambda: done.append("at the end"))
    ended.set()
    thread.join(HANGS)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_process(signals: list[Any], number: signal.Signals):
    run_with_signals(signals, number)
    assert signals == ["at the end", Exit.DONE]


def test_a_signal_that_does_not_end_the_wait_is_heard_all_the_same(signals: list[Any]):
    run_with_signals(signals, signal.SIGTERM, send=to_own_thread)
    assert signals == ["at the end", Exit.DONE]


def test_ignored_signals_stay_ignored(signals: list[Any]):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    run_with_signals(signals, signal.SIGHUP, signal.SIGHUP, signal.SIGTERM)
    assert signals == ["at the end", Exit.DONE]
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
