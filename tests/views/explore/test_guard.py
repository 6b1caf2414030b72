"""Who may use the page: only requests with the token, from this machine's own page."""

from __future__ import annotations

import base64
import http.client
import os
import socket
from collections.abc import Iterator
from contextlib import ExitStack, closing
from typing import Any
from urllib.parse import urlsplit

import psutil
import pytest
from bokeh.models import Div
from tornado.httputil import HTTPHeaders, HTTPServerRequest, RequestStartLine
from tornado.web import Application

from sweeps.views.explore.guard import Guard, new_token


def request(uri: str = "/?token=right", **headers: str) -> HTTPServerRequest:
    """A request as the server sees it; a header that is empty is left out."""
    given = {"Host": "127.0.0.1:4321", **headers}
    lines = HTTPHeaders({name: text for name, text in given.items() if text})
    start = RequestStartLine("GET", uri, "HTTP/1.0")
    return HTTPServerRequest(start_line=start, headers=lines, connection=_Connection())


class _Connection:
    context = None


GUARD = Guard(Application(), "right", 4321)


def test_the_right_token_is_admitted():
    assert GUARD.admits(request())
    assert GUARD.admits(request(Host="localhost:4321"))
    assert GUARD.admits(request("/ws?token=right", Origin="http://127.0.0.1:4321"))


TOKENS = ["", "?token=", "?token=wrong", "?token=righ", "?token=rightt", "?token=right&token=x",
          "?token=%C3%A9", "?token=%FF"]  # fmt: skip
HOSTS = ["", "evil.example", "evil.example:4321", "127.0.0.1:80"]
ORIGINS = ["http://evil.example", "https://127.0.0.1:4321", "http://127.0.0.1:80", "null"]


@pytest.mark.parametrize(
    "refused",
    [
        *(request(f"/{query}") for query in TOKENS),
        *(request(Host=host) for host in HOSTS),
        *(request(Origin=origin) for origin in ORIGINS),
    ],
)
def test_another_token_name_or_page_is_not(refused: HTTPServerRequest):
    assert not GUARD.admits(refused)


def test_tokens_are_long_and_differ():
    tokens = {new_token() for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) >= 40


# --- over the wire ---


@pytest.fixture(scope="module")
def server(serving: Any) -> Iterator[Any]:
    with serving(lambda document: document.add_root(Div(text="hello"))) as there:
        yield there


def answer(server: Any, path: str, **headers: str) -> tuple[int, str]:
    """Status and body; the query of the address is that of the path."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    with closing(connection):
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        return response.status, response.read().decode()


def socket_answer(server: Any, path: str, **headers: str) -> int:
    """The status that the handshake of a websocket gets."""
    key = base64.b64encode(os.urandom(16)).decode()
    asked = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
    return answer(server, path, **asked, **{"Sec-WebSocket-Key": key}, **headers)[0]


def test_the_printed_address_opens_the_page(server: Any):
    address = urlsplit(server.address)
    assert (address.scheme, address.hostname, address.path) == ("http", "127.0.0.1", "/")
    status, page = answer(server, f"/?{address.query}")
    assert status == 200
    assert "Bokeh" in page


@pytest.mark.parametrize(
    "path", ["/", "/?token=wrong", "/ws", "/static/js/bokeh.min.js", "/metadata", "/nowhere"]
)
def test_without_the_token_everything_is_forbidden(server: Any, path: str):
    status, page = answer(server, path)
    assert status == 403
    assert "with its token" in page


def test_websockets_are_forbidden_too(server: Any):
    query = urlsplit(server.address).query
    assert socket_answer(server, "/ws") == 403
    assert socket_answer(server, "/ws?token=wrong") == 403
    assert socket_answer(server, f"/ws?{query}", Origin="http://evil.example") == 403
    assert socket_answer(server, f"/ws?{query}", Host="evil.example") == 403


def test_half_sent_requests_leave_room_for_the_owner(server: Any):
    query = urlsplit(server.address).query
    with ExitStack() as stack:
        for _ in range(400):
            half = stack.enter_context(socket.create_connection(("127.0.0.1", server.port)))
            half.sendall(b"GET / HTTP/1.1\r\n")
        assert answer(server, f"/?{query}")[0] == 200
        connections = psutil.Process().net_connections(kind="inet")
        there = [c for c in connections if c.laddr.port == server.port and c.raddr]
        assert sum(c.status == psutil.CONN_ESTABLISHED for c in there) <= 70


@pytest.mark.parametrize("query", ["", "token=wrong", "the owner's"])
def test_a_large_body_is_not_taken_in(server: Any, query: str):
    owners = urlsplit(server.address).query
    head = f"POST /?{owners if query.startswith('the') else query} HTTP/1.1\r\n"
    with socket.create_connection(("127.0.0.1", server.port), timeout=60) as connection:
        connection.sendall(f"{head}Host: x\r\nContent-Length: 104000000\r\n\r\n".encode())
        assert connection.recv(100).startswith(b"HTTP/1.1 4") or not connection.recv(100)


def test_requests_that_are_malformed_do_not_log_the_token(
    server: Any, caplog: pytest.LogCaptureFixture
):
    query = urlsplit(server.address).query
    with caplog.at_level("DEBUG", "tornado"):
        for line in (f"GET /?{query}", f"GET /?{query} HTTP/9.9", f"GET /?{query} x HTTP/1.1"):
            with socket.create_connection(("127.0.0.1", server.port), timeout=60) as connection:
                connection.sendall(f"{line}\r\nHost: x\r\n\r\n".encode())
                connection.recv(100)
    assert query.removeprefix("token=") not in caplog.text


def test_one_tab_too_many_is_refused_and_the_open_ones_are_served(serving: Any):
    from bokeh.client import pull_session

    from sweeps.views.explore.serving import TABS

    with serving(lambda document: document.add_root(Div(text="hello"))) as server, ExitStack() as s:
        url, token = server.address.split("/?token=")
        for _ in range(TABS):
            session = pull_session(url=url, arguments={"token": token})
            s.callback(session.close)
        assert session.document.roots[0].text == "hello"
        status, text = answer(server, f"/?token={token}")
        assert status == 503
        assert "close some, and reload" in text
        with pytest.raises(OSError, match="503"):
            pull_session(url=url, arguments={"token": token})
        session.close()
        again = pull_session(url=url, arguments={"token": token}, session_id=session.id)
        s.callback(again.close)
        assert again.document.roots[0].text == "hello"


def test_it_listens_on_the_loopback_alone(server: Any):
    connections = psutil.Process().net_connections(kind="inet")
    listening = [c.laddr for c in connections if c.status == psutil.CONN_LISTEN]
    assert [address.ip for address in listening if address.port == server.port] == ["127.0.0.1"]


def test_a_port_in_use_is_an_error_with_a_remedy(server: Any):
    from sweeps.exits import Exit
    from sweeps.views.explore.serving import PageServer, PortError

    with pytest.raises(PortError, match=r"cannot be used: .* in use; give another --port") as told:
        PageServer(lambda _: None, server.port)
    assert told.value.code is Exit.STORAGE


def test_a_page_that_fails_says_so_and_shows_no_trace(
    serving: Any, capfd: pytest.CaptureFixture[str]
):
    def fail(_: object) -> None:
        raise RuntimeError("no <chart>")

    with serving(fail) as server:
        status, _ = answer(server, f"/?{urlsplit(server.address).query}")
    out, err = capfd.readouterr()
    assert status == 200
    assert "Traceback" not in out + err
    assert urlsplit(server.address).query not in out + err


def test_nothing_listens_any_more_in_the_end(serving: Any):
    with serving(lambda _: None) as server:
        pass
    with closing(socket.socket()) as probe:
        assert probe.connect_ex(("127.0.0.1", server.port)) != 0
