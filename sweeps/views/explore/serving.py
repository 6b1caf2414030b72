"""The server of the page: on the loopback only, behind its guard."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable

from bokeh.application import Application
from bokeh.application.handlers import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets

from sweeps.exits import Exit, ExpectedError
from sweeps.human import reason
from sweeps.views.explore.guard import Guard, new_token

_LOOPBACK = "127.0.0.1"
_LOOK_SECONDS, _UNUSED_SECONDS = 2, 10  # how soon a tab that was closed gives up its threads


class PortError(ExpectedError):
    """The port cannot be listened on; the message says why."""

    code = Exit.STORAGE


class PageServer:
    """Serves a page, each tab a document of its own that `open_page` fills.

    Made and run in one thread; `stop` may be called from any.
    """

    def __init__(self, open_page: Callable[[Document], None], port: int = 0) -> None:
        try:
            sockets = bind_sockets(port, _LOOPBACK)
        except OSError as error:
            raise PortError(
                f"port {port} of {_LOOPBACK} cannot be used: {reason(error)}; give another --port, "
                "or none for a free one"
            ) from None
        self.port: int = sockets[0].getsockname()[1]
        token = new_token()
        self.address = f"http://{_LOOPBACK}:{self.port}/?token={token}"
        self._events = asyncio.new_event_loop()
        asyncio.set_event_loop(self._events)
        self._loop = IOLoop.current()
        tornado = BokehTornado(
            {"/": Application(FunctionHandler(open_page))},
            extra_websocket_origins=[f"{_LOOPBACK}:{self.port}", f"localhost:{self.port}"],
            check_unused_sessions_milliseconds=1000 * _LOOK_SECONDS,
            unused_session_lifetime_milliseconds=1000 * _UNUSED_SECONDS,
            log_function=lambda _: None,  # addresses hold the token
        )
        http = HTTPServer(Guard(tornado, token, self.port))
        http.add_sockets(sockets)
        self._server = BaseServer(self._loop, tornado, http)

    def run(self) -> None:
        """Serve until `stop` is called."""
        self._server.start()
        self._loop.start()
        self._server.stop()

    def stop(self) -> None:
        """Have `run` come to its end."""
        self._loop.add_callback(self._loop.stop)

    def run_until_signal(self) -> None:
        """Serve until Ctrl-C or a signal; those that are ignored, as under nohup, stay ignored."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._events.add_signal_handler(number, self.stop)
        self.run()
