"""Which requests the server of a page answers: those of the page itself, with the right token."""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping
from typing import NamedTuple, TypeAlias
from urllib.parse import parse_qsl

LOOPBACK = "127.0.0.1"

Query: TypeAlias = Mapping[str, str]
"""The decoded parameters of a request, without its token."""

_STRANGE = (
    "open this page with the whole address that `stickslip explore` printed, including the token"
)
_ODD = "this is not a request from a browser"
_NOT_GET = "this page answers only GET"
_TWICE = "a parameter is given more than once"


class RefusedError(Exception):
    """A request that no route gets; its arguments are the HTTP status and a sentence."""


class Request(NamedTuple):
    """A request, as its headers give it."""

    method: str
    path: str
    parameters: list[tuple[str, str]]
    headers: dict[str, str]


# Neither pattern may backtrack, because strangers choose the text.
_FIRST_LINE = re.compile(r"([A-Z]+) (/[!-~]*) HTTP/1\.[01]")
_HEADER = re.compile(r"([!#$%&'*+\-.^_`|~0-9A-Za-z]+):([\t -~\x80-\xff]*)")


def parsed(head: str) -> Request:
    """Return the request with these lines; a folded header and HTTP/0.9 are refused."""
    first, *others = head.split("\r\n")
    start, lines = _FIRST_LINE.fullmatch(first), [_HEADER.fullmatch(line) for line in others]
    if start is None:
        raise RefusedError(400, _ODD)
    headers: dict[str, str] = {}
    for line in lines:
        if line is None:
            raise RefusedError(400, _ODD)
        name, text = line[1].lower(), line[2].strip(" \t")
        # A header may be repeated; two Hosts are joined into one that does not belong to this page.
        headers[name] = f"{headers[name]}, {text}" if name in headers else text
    path, _, query = start[2].partition("?")
    return Request(start[1], path, parse_qsl(query, keep_blank_values=True), headers)


_JUDGED = ("host", "origin", "sec-fetch-site", "sec-fetch-mode")
_OTHER_SITES = {"same-site", "cross-site"}


class Guard:
    """Admits requests that have the token and come from this machine and from this page.

    `Host` and `Origin` must name this page. A foreign page whose name was made to resolve to this
    machine (DNS rebinding) has other names there.
    """

    def __init__(self, token: str, port: int) -> None:
        self._token = token.encode()
        self._hosts = {f"{name}:{port}" for name in (LOOPBACK, "localhost")}
        self._origins = {f"http://{host}" for host in self._hosts}

    def admit(self, request: Request) -> Query:
        """Return the parameters of a request; raises `RefusedError` if it may not be answered."""
        tokens = [text for name, text in request.parameters if name == "token"]
        if not (self._is_right(tokens) and self._is_own(request)):
            raise RefusedError(403, _STRANGE)
        if request.method != "GET":
            raise RefusedError(405, _NOT_GET)
        query = dict(request.parameters)
        if len(query) < len(request.parameters):
            raise RefusedError(400, _TWICE)
        del query["token"]
        return query

    def _is_right(self, tokens: list[str]) -> bool:
        """Return True for the right token, in a time that does not depend on its characters."""
        return len(tokens) == 1 and secrets.compare_digest(tokens[0].encode(), self._token)

    def _is_own(self, request: Request) -> bool:
        """Return True if a request comes from this page, or opens it.

        A file with a link to the page, and a notebook that shows it in a frame, are other sites.
        """
        host, origin, site, mode = map(request.headers.get, _JUDGED)
        opens = request.path == "/" and mode == "navigate"
        return (
            host is not None
            and host.lower() in self._hosts
            and (origin is None or origin.lower() in self._origins)
            and (site in {None, "same-origin", "none"} or (opens and site in _OTHER_SITES))
        )
