"""Which requests the server of a page answers: token, host, origin, method, form, size."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from urllib.parse import quote, urlsplit

import pytest
from support.serving import answer, connected, filled, sent, served, status, status_of, token_of

from sweeps.page.admission import parsed
from sweeps.page.serving import Answer, PageServer


@pytest.fixture(scope="module")
def server() -> Iterator[PageServer]:
    with served(echo=lambda query: Answer("text/plain", repr(query).encode())) as server:
        yield server


# --- the token, and the pages that may send requests ---


def test_the_printed_address_opens_the_page(server: PageServer):
    address = urlsplit(server.address)
    assert (address.scheme, address.hostname, address.path) == ("http", "127.0.0.1", "/")
    assert address.port == server.port
    assert answer(server, f"/?{address.query}")[:2] == (200, "hello")


def test_tokens_are_long_and_differ():
    tokens = set()
    for _ in range(5):
        with served() as server:
            tokens.add(token_of(server))
    assert len(tokens) == 5
    assert min(map(len, tokens)) >= 40


@pytest.mark.parametrize(
    "query",
    ["", "?token=", "?token=wrong", "?token=SHORT", "?token=TOKENx", "?token=TOKEN&token=x",
     "?token=TOKEN&token=", "?token=TOKEN&token=TOKEN", "?token=%C3%A9", "?token=%FF", "?TOKEN",
     "?Token=TOKEN", "?x=TOKEN"],
)  # fmt: skip
@pytest.mark.parametrize("path", ["/", "/echo", "/nowhere"])
def test_without_the_token_everything_is_forbidden(server: PageServer, path: str, query: str):
    code, text, _ = answer(server, path + query.replace("SHORT", token_of(server)[:-1]))
    assert code == 403
    assert "including the token" in text


def test_the_token_counts_only_in_the_query(server: PageServer):
    assert status(server, "/", Cookie="token=TOKEN") == 403
    assert status(server, "/", Authorization="Bearer TOKEN") == 403
    assert status(server, "/token=TOKEN") == 403


FRAME = {"Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "iframe"}


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Host": "localhost:PORT"},
        {"Origin": "http://127.0.0.1:PORT"},
        {"Origin": "http://localhost:PORT"},
        *({"Sec_Fetch_Site": site, **FRAME} for site in ("same-origin", "none")),
        *({"Sec_Fetch_Site": site, **FRAME} for site in ("same-site", "cross-site")),
    ],
)
def test_this_machine_and_a_link_may_open_the_page(server: PageServer, headers: dict[str, str]):
    assert status(server, **headers) == 200


@pytest.mark.parametrize("site", ["same-origin", "none"])
def test_the_page_itself_may_request_anything(server: PageServer, site: str):
    assert status(server, "/echo?token=TOKEN", Sec_Fetch_Site=site, Sec_Fetch_Mode="cors") == 200


HOSTS = ("", "evil.example", "evil.example:PORT", "127.0.0.1:80", "127.0.0.1", "127.0.0.2:PORT",
         "127.0.0.1:PORT, x", "\xa0localhost:PORT")  # fmt: skip
ORIGINS = ("http://evil.example", "https://127.0.0.1:PORT", "http://127.0.0.1:80", "null", "")
MODES = ("cors", "no-cors", "same-origin", "websocket", "")
OTHERS = ("same-site", "cross-site")


@pytest.mark.parametrize(
    "headers",
    [
        *({"Host": host} for host in HOSTS),
        *({"Origin": origin} for origin in ORIGINS),
        {"Sec_Fetch_Site": "elsewhere", **FRAME},
        *({"Sec_Fetch_Site": site} for site in OTHERS),
        *({"Sec_Fetch_Site": site, "Sec_Fetch_Mode": mode} for site in OTHERS for mode in MODES),
    ],
)
def test_another_host_origin_or_site_is_forbidden(server: PageServer, headers: dict[str, str]):
    assert status(server, **headers) == 403


@pytest.mark.parametrize("site", OTHERS)
def test_another_site_may_open_the_page_and_nothing_else(server: PageServer, site: str):
    assert status(server, "/echo?token=TOKEN", Sec_Fetch_Site=site, **FRAME) == 403


def test_a_request_without_a_host_or_with_two_is_forbidden(server: PageServer):
    line = "GET /?token=TOKEN HTTP/1.1\r\n"
    codes = [status_of(sent(server, f"{line}{hosts}\r\n")) for hosts in (HOST, "", HOST + HOST)]
    assert codes == [200, 403, 403]


# --- requests that the page never sends ---


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "HEAD", "PATCH", "CONNECT"])
def test_a_method_other_than_get_is_refused(server: PageServer, method: str):
    received = sent(server, f"{method} /?token=TOKEN HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n")
    assert status_of(received) == 405
    assert b"\r\nAllow: GET\r\n" in received


@pytest.mark.parametrize("path", ["/nowhere", "/echo/", "//echo", "/%65cho", "/../echo"])
def test_an_unknown_path_is_not_found(server: PageServer, path: str):
    assert status(server, f"{path}?token=TOKEN") == 404


def test_parameters_are_decoded_and_the_token_is_not_among_them(server: PageServer):
    path = f"/echo?token=TOKEN&T=2.5e%2B2&name={quote('φ & ω')}&a+b=c+d&empty="
    code, text, _ = answer(server, path)
    assert code == 200
    assert text == repr({"T": "2.5e+2", "name": "φ & ω", "a b": "c d", "empty": ""})


@pytest.mark.parametrize("twice", ["T=1&T=2", "T=1&T=1", "T=&T=1", "T=1&%54=2"])
def test_a_parameter_given_twice_is_refused(server: PageServer, twice: str):
    code, text, _ = answer(server, f"/echo?token=TOKEN&{twice}")
    assert code == 400
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
def test_a_request_that_no_browser_sends_is_refused_and_its_token_not_logged(
    server: PageServer,
    odd: str,
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
):
    with caplog.at_level("DEBUG"):
        received = sent(server, ODD[odd])
    assert status_of(received) == 400
    assert received.endswith(b"\r\n\r\n400: this is not a request from a browser.\n")
    assert token_of(server) not in caplog.text
    assert capfd.readouterr() == ("", "")


def test_headers_may_have_16_kib_and_no_more(server: PageServer):
    line = filled(server, f"GET /?token=TOKEN HTTP/1.1\r\n{HOST}X: ")
    most = (1 << 14) - len(line) - len("\r\n\r\n")
    assert status_of(sent(server, f"{line}{'x' * most}\r\n\r\n")) == 200
    assert status_of(sent(server, f"{line}{'x' * (most + 1)}\r\n\r\n")) == 431
    assert status_of(sent(server, "x" * (1 << 14))) == 431


@pytest.mark.parametrize("odd", ["X:" + " " * 16000 + "\x00", "X" * 16000, "X: a\r\n" * 2600])
def test_long_headers_do_not_take_long_to_judge(odd: str):
    start = time.thread_time()
    with contextlib.suppress(Exception):
        parsed(f"GET / HTTP/1.1\r\n{odd}")
    assert time.thread_time() - start < 0.2


@pytest.mark.parametrize("path", ["/?token=TOKEN", "/", "/echo?token=TOKEN"])
def test_a_large_body_is_not_read(server: PageServer, path: str):
    size, taken, piece = 1 << 30, 0, bytes(1 << 20)
    head = f"POST {path} HTTP/1.1\r\n{HOST}Content-Length: {size}\r\n\r\n"
    with connected(server) as connection:
        connection.sendall(filled(server, head).encode())
        with contextlib.suppress(ConnectionError):
            while taken < size:
                taken += connection.send(piece)
    assert taken < size / 8  # as much as fits into the sockets


def test_the_token_is_in_no_answer(server: PageServer):
    for path in ("/?token=TOKEN&a&a", "/echo?token=TOKEN", "/nowhere?token=TOKEN", "/token=TOKEN"):
        assert token_of(server) not in answer(server, path)[1]
