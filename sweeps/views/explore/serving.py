"""The server of the page: on the loopback only, behind its guard, with a limit to everything."""

from __future__ import annotations

import asyncio
import gc
import html
import logging
import os
import signal
import socket
from collections.abc import Callable
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.core.types import ID
from bokeh.document import Document
from bokeh.models import Div
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.util.token import get_session_id
from tornado.http1connection import HTTP1Connection
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.iostream import IOStream

from sweeps.exits import Exit, ExpectedError
from sweeps.views.explore.guard import Guard, new_token

_LOOPBACK = "127.0.0.1"
# How soon a tab that was closed gives up its threads; a slow one may take long to open.
_LOOK_SECONDS, _UNUSED_SECONDS = 2, 30
TABS = 12
"""Tabs that may be open at a time: each has threads, and a document of some megabytes."""

# Any user of this machine can connect. What has not shown the token yet is limited in number, time
# and bytes, so that it takes neither the files nor the memory of this process.
_STRANGERS = 64
_REQUEST_SECONDS = 10.0
_REQUEST_BYTES = 1 << 20

log = logging.getLogger(__name__)


class PortError(ExpectedError):
    """The port cannot be listened on; the message says why."""

    code = Exit.STORAGE


class PageServer:
    """Serves a page, each tab a document of its own that `open_page` fills.

    Made and run in one thread; `stop` may be called from any.
    """

    def __init__(self, open_page: Callable[[Document], None], port: int = 0) -> None:
        try:
            listening = socket.create_server((_LOOPBACK, port))
        except OSError as error:
            why = os.strerror(error.errno or 0)
            raise PortError(
                f"port {port} of {_LOOPBACK} cannot be used: {why}; give another --port, or none "
                "for a free one"
            ) from None
        listening.setblocking(False)
        self.port: int = listening.getsockname()[1]
        token = new_token()
        self.address = f"http://{_LOOPBACK}:{self.port}/?token={token}"
        asyncio.set_event_loop(asyncio.new_event_loop())
        self._loop = IOLoop.current()
        tornado = BokehTornado(
            {"/": Application(FunctionHandler(lambda document: self._fill(document, open_page)))},
            extra_websocket_origins=[f"{_LOOPBACK}:{self.port}", f"localhost:{self.port}"],
            check_unused_sessions_milliseconds=1000 * _LOOK_SECONDS,
            unused_session_lifetime_milliseconds=1000 * _UNUSED_SECONDS,
            log_function=lambda _: None,  # addresses hold the token
        )
        http = _Server(
            Guard(
                tornado,
                token,
                self.port,
                admitted=lambda request: http.admit(request),
                full=lambda request: _one_tab_too_many(tornado, request),
            ),
            idle_connection_timeout=_REQUEST_SECONDS,
            body_timeout=_REQUEST_SECONDS,
            max_body_size=_REQUEST_BYTES,
        )
        http.add_socket(listening)
        self._server = BaseServer(self._loop, tornado, http)
        # Their messages about requests that are malformed or fail hold the address.
        for name in ("tornado.general", "tornado.application"):
            logging.getLogger(name).addFilter(lambda record: token not in record.getMessage())

    def run(self) -> None:
        """Serve until `stop` is called."""
        self._server.start()
        self._loop.start()
        self._server.stop()
        self._loop.close(all_fds=True)

    def stop(self) -> None:
        """Have `run` come to its end."""
        self._loop.add_callback(self._loop.stop)

    def run_until_signal(self, at_end: Callable[[], None]) -> None:
        """Serve until Ctrl-C or a signal, which ends the process after `at_end`.

        It ends at once, whatever the loop and the compiled code in threads are doing: there is
        nothing to keep. Signals that are ignored, as under nohup, stay ignored.
        """

        def end(*_: object) -> None:
            at_end()
            os._exit(Exit.DONE)

        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, end)
        # Bokeh collects garbage twice for every tab that it gives up. What has been imported is
        # no garbage, and most of what there is: without it a collection is short.
        gc.freeze()
        self.run()

    def _fill(self, document: Document, open_page: Callable[[Document], None]) -> None:
        """Open the page in a document; an error is a line on it, not a trace with the token."""
        try:
            open_page(document)
        except Exception as error:
            log.debug("unexpected", exc_info=True)
            document.clear()
            what = f"unexpected {type(error).__name__}: {error}"
            sentence = html.escape(f"This page cannot be shown: {what}")
            document.add_root(Div(text=sentence, disable_math=True))


class _Server(HTTPServer):
    """Closes the oldest connection that never was admitted where there are too many of them.

    The owner's own connection is admitted as soon as its request is there, and then stays.
    """

    def initialize(self, *args: Any, **kwargs: Any) -> None:
        super().initialize(*args, **kwargs)
        self._strangers: dict[IOStream, None] = {}

    def handle_stream(self, stream: IOStream, address: tuple[Any, ...]) -> None:
        """Serve a new connection."""
        self._strangers = {known: None for known in self._strangers if not known.closed()}
        if len(self._strangers) >= _STRANGERS:
            oldest = next(iter(self._strangers))
            del self._strangers[oldest]
            oldest.close()
        self._strangers[stream] = None
        super().handle_stream(stream, address)

    def admit(self, request: HTTPServerRequest) -> None:
        """Take note that a request has shown the token."""
        connection = request.connection
        if isinstance(connection, HTTP1Connection):
            self._strangers.pop(connection.stream, None)


def _one_tab_too_many(tornado: BokehTornado, request: HTTPServerRequest) -> bool:
    """Tell whether a request would open a tab where no further one may be."""
    sessions = {session.id for session in tornado.get_sessions("/")}
    return len(sessions) >= TABS and _opens_tab(request, sessions)


def _opens_tab(request: HTTPServerRequest, sessions: set[ID]) -> bool:
    """Tell whether a session will be made for a request, which is none of these."""
    if request.path != "/ws":
        return request.path in ("/", "/autoload.js")
    try:
        _, token = request.headers["Sec-WebSocket-Protocol"].split(",")
        return get_session_id(token.strip()) not in sessions
    except (KeyError, TypeError, ValueError):
        return False  # Bokeh closes it
