"""`stickslip explore`: a page served on this machine by a process that computes its orbits."""

from __future__ import annotations

from functools import cache
from html import escape

import xarray as xr

from stickslip.parameters import Parameters
from sweeps.config.load import from_mapping
from sweeps.page import name_of, require_bokeh
from sweeps.page.admission import Query
from sweeps.page.answers import answer_lines, as_json
from sweeps.page.serving import Answer, PageServer
from sweeps.page.subject import Subject, subject_of_config, subject_of_paper, subject_of_result
from sweeps.page.turns import Turns

_HEIGHT = 900  # pixels of the page in a notebook
# Only notebooks on this machine may show the page in a frame.
_FRAMES = "frame-ancestors 'self' http://127.0.0.1:* http://localhost:*"


def server_of(subject: Subject, port: int = 0) -> PageServer:
    """Return the server of a page.

    Raises PortError, and ReportError if Bokeh is missing or the result has too many points.
    """
    require_bokeh()
    from sweeps.page.document import part_of, served  # Bokeh takes long to import

    if subject.result is not None:
        part_of(subject.result, subject.name, ())  # now, not at the first request
    turns = Turns()
    text = cache(lambda: served(subject))  # the same for every request

    def page(_: Query) -> Answer:
        headers = {"Content-Security-Policy": _FRAMES}
        return Answer("text/html; charset=utf-8", text(), headers)

    def orbit(query: Query) -> Answer:
        lines = map(as_json, answer_lines(query, subject, turns))
        return Answer("application/x-ndjson", lines)

    return PageServer({"/": page, "/orbit": orbit}, port)


class Explorer:
    """A page that this process serves as long as it runs; a notebook shows the page in a cell.

    `sweeps.explore` returns it.

    >>> page = explore()
    >>> page.forwarding.startswith("ssh -L ")
    True
    >>> page.stop()
    """

    def __init__(self, server: PageServer) -> None:
        self._server = server
        server.run_in_background()

    @property
    def address(self) -> str:
        """The address of the page with its token, for a browser of this machine."""
        return self._server.address

    @property
    def forwarding(self) -> str:
        """The command that forwards the page to another machine, for a browser there."""
        port = self._server.port
        return f"ssh -L {port}:127.0.0.1:{port} MACHINE"

    def stop(self) -> None:
        """Stop serving the page."""
        self._server.stop()

    def __repr__(self) -> str:
        return f"stickslip explore at {self.address}"  # a terminal copies it up to a space

    def _repr_html_(self) -> str:
        address = escape(self.address)
        frame = f'src="{address}" width="100%" height="{_HEIGHT}" style="border: 0"'
        return (
            f'<iframe {frame} title="stickslip explore" referrerpolicy="no-referrer"></iframe>'
            f'<p>The page is served by the kernel of this notebook, at <a href="{address}" '
            f'target="_blank" rel="noreferrer">{address}</a>, and ends with it. If the kernel runs '
            "on another machine, first run this command here, with the name of that machine: "
            f"<code>{self.forwarding}</code></p>"
        )


def explore(
    target: xr.Dataset | Parameters | None = None,
    *,
    borders: xr.Dataset | None = None,
    port: int = 0,
) -> Explorer:
    """Serve the page that `stickslip explore` opens, and show it in a notebook.

    >>> page = explore(Parameters(temperature=250))
    >>> page.address.startswith("http://127.0.0.1:")
    True
    >>> page.stop()

    Parameters
    ----------
    target
        The result of a sweep, whose points open on a click, or the parameters of the first point.
        By default the page opens at the paper's values.
    borders
        What `StickslipAccessor.boundaries` returns, drawn on the map over their axes.
    port
        Port on this machine; 0 for a free one.

    Raises
    ------
    ReportError
        Bokeh is not installed, or the result has too many points for a page.
    PointError
        `target` is a Dataset but not the result of a sweep.
    PortError
        The server cannot listen on the port.
    """
    if isinstance(target, xr.Dataset):
        subject = subject_of_result(target, name_of(target), borders=borders)
    elif target is None:
        subject = subject_of_paper()
    else:
        subject = subject_of_config(from_mapping({"model": target._asdict()}), "")
    return Explorer(server_of(subject, port))
