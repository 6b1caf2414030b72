"""Who may use the page: whoever knows the token, from this machine, on a page of its own."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from typing import Any
from urllib.parse import parse_qs

from tornado.httputil import HTTPMessageDelegate, HTTPServerRequest
from tornado.routing import Router
from tornado.web import Application, RequestHandler

_STRANGE = (
    "this page opens with the whole address that `stickslip explore` has printed, with its token"
)
_TOO_MANY = "as many tabs are open as may be: close some, and reload this one half a minute later"


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(32)


class Guard(Router):
    """Hands requests to an application; what lacks the token or comes from elsewhere gets 403.

    What has the token gets 503 where it is `full`.

    The name in `Host` and the `Origin` must be those of this page: a foreign page whose name was
    made to lead to this machine (DNS rebinding) has others.
    """

    def __init__(
        self,
        application: Application,
        token: str,
        port: int,
        admitted: Callable[[HTTPServerRequest], None] = lambda _: None,
        full: Callable[[HTTPServerRequest], bool] = lambda _: False,
    ) -> None:
        self._application, self._token = application, token.encode()
        self._admitted, self._full = admitted, full
        self._hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self._origins = {f"http://{host}" for host in self._hosts}
        self._strange, self._too_many = _refusing(403, _STRANGE), _refusing(503, _TOO_MANY)

    def find_handler(self, request: HTTPServerRequest, **kwargs: Any) -> HTTPMessageDelegate | None:
        """Return the handler of a request."""
        if not self.admits(request):
            return self._strange.find_handler(request, **kwargs)
        self._admitted(request)
        if self._full(request):
            return self._too_many.find_handler(request, **kwargs)
        return self._application.find_handler(request, **kwargs)

    def admits(self, request: HTTPServerRequest) -> bool:
        """Tell whether a request may be answered."""
        origin = request.headers.get("Origin")
        return (
            self._has_token(request)
            and request.headers.get("Host", "").lower() in self._hosts
            and (origin is None or origin.lower() in self._origins)
        )

    def _has_token(self, request: HTTPServerRequest) -> bool:
        """Tell whether the token is right, in a time that does not depend on how much of it is."""
        tokens = parse_qs(request.query, encoding="utf-8", errors="replace").get("token", [])
        return len(tokens) == 1 and secrets.compare_digest(tokens[0].encode(), self._token)


def _refusing(status: int, sentence: str) -> Application:
    """Return what answers every request with this sentence."""
    answer = {"status": status, "sentence": sentence}
    return Application(
        default_handler_class=_Refusal, default_handler_args=answer, log_function=lambda _: None
    )


class _Refusal(RequestHandler):
    def initialize(self, status: int, sentence: str) -> None:
        self._answer = status, sentence

    def prepare(self) -> None:
        status, sentence = self._answer
        self.set_status(status)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status}: {sentence}.\n")
