"""The page of a result: a file that needs no network, or a page served by a process that computes.

`stickslip report` writes it (`document.page_of`), with the orbits of some points. `stickslip
explore` serves it (`explorer`), with controls for every parameter, and computes orbits on request.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweeps.exits import ExpectedError

if TYPE_CHECKING:
    import xarray as xr

MOST_ORBITS = 200
"""The most orbits in a page, about a megabyte."""

MOST_POINTS = 300_000
"""The most points in a page, some 15 megabytes: about as much as a browser opens."""

_MARK = b'<meta name="generator" content="stickslip report">'  # of page.html
_HEAD = 1 << 12  # bytes of a page that hold it


class ReportError(ExpectedError, ValueError):
    """A result cannot be made into a page; the message gives the remedy."""


def name_of(ds: xr.Dataset) -> str:
    """Return the file name of a result for commands on a page; one in memory is called FILE."""
    return Path(ds.encoding.get("source", "FILE")).name


def write_report(ds: xr.Dataset, path: Path, **options: Any) -> None:
    """Write a page for exploring a result, with the options of `document.page_of`.

    It replaces an older file. Raises the errors of `page_of`, StorageError if the page cannot be
    written, and ReportError if Bokeh is not installed.
    """
    require_bokeh()
    from sweeps.files.atomic import replacing, storage_errors
    from sweeps.page.document import page_of

    page = page_of(ds, **options)
    with storage_errors(f"cannot write {path}", path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, fsync=False) as temporary:
            temporary.write_bytes(page)


def is_page_of_ours(path: Path) -> bool:
    """Return True if this program wrote the page in a file, so that it may replace it."""
    with path.open("rb") as file:
        return _MARK in file.read(_HEAD)


def require_bokeh() -> None:
    """Raise ReportError if Bokeh, which draws the charts, is not installed."""
    if importlib.util.find_spec("bokeh") is None:
        raise ReportError("bokeh is not installed; try: pip install 'bokeh>=3.9'")
