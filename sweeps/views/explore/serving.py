"""The server of the page: on the loopback only, behind its guard."""

from __future__ import annotations

import asyncio
import html
import logging
import os
import signal
import socket
from collections.abc import Callable

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.document import Document
from bokeh.models import Div
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop

from sweeps.exits import Exit, ExpectedError
from sweeps.views.explore.guard import Guard, new_token

_LOOPBACK = "127.0.0.1"
# How soon a tab that was closed gives up its threads; a slow one may take long to open.
_LOOK_SECONDS, _UNUSED_SECONDS = 2, 30


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
        self._events = asyncio.new_event_loop()
        asyncio.set_event_loop(self._events)
        self._loop = IOLoop.current()
        tornado = BokehTornado(
            {"/": Application(FunctionHandler(lambda document: _fill(document, open_page)))},
            extra_websocket_origins=[f"{_LOOPBACK}:{self.port}", f"localhost:{self.port}"],
            check_unused_sessions_milliseconds=1000 * _LOOK_SECONDS,
            unused_session_lifetime_milliseconds=1000 * _UNUSED_SECONDS,
            log_function=lambda _: None,  # addresses hold the token
        )
        http = HTTPServer(Guard(tornado, token, self.port))
        http.add_socket(listening)
        self._server = BaseServer(self._loop, tornado, http)

    def run(self) -> None:
        """Serve until `stop` is called."""
        self._server.start()
        self._loop.start()
        self._server.stop()
        self._loop.close(all_fds=True)

    def stop(self) -> None:
        """Have `run` come to its end."""
        self._loop.add_callback(self._loop.stop)

    def run_until_signal(self) -> None:
        """Serve until Ctrl-C or a signal; those that are ignored, as under nohup, stay ignored."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._events.add_signal_handler(number, self.stop)
        self.run()


def _fill(document: Document, open_page: Callable[[Document], None]) -> None:
    """Open the page in a document; an error becomes a line on it, not a trace with the token."""
    try:
        open_page(document)
    except Exception as error:
        log.debug("unexpected", exc_info=True)
        sentence = f"This page cannot be shown: unexpected {type(error).__name__}: {error}"
        document.clear()
        document.add_root(Div(text=html.escape(sentence), disable_math=True))
