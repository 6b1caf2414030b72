"""The page of a result: a file that needs no network, or served by a process that computes.

`stickslip report` writes it (`page_of`), with the orbits of some points. `stickslip explore` serves
it (`explore`), with controls for every parameter, and computes the orbits that are asked for.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweeps.exits import ExpectedError

if TYPE_CHECKING:
    import xarray as xr

MOST_ORBITS = 200
"""Orbits in a page, about a megabyte."""

MOST_POINTS = 300_000
"""Points in a page, some 15 megabytes: what a browser still opens."""


_MARK = b'<meta name="generator" content="stickslip report">'  # of page.html
_HEAD = 1 << 12  # bytes of a page that hold it


class ReportError(ExpectedError, ValueError):
    """No page can be made of a result; the message says what to do."""


def name_of(ds: xr.Dataset) -> str:
    """Return what commands on a page call a result; one in memory has no file yet."""
    return Path(ds.encoding.get("source", "FILE")).name


def write_report(ds: xr.Dataset, path: Path, **options: Any) -> None:
    """Write a page to look around in a result, with the options of `page_of`.

    An older file is replaced. Raises StorageError if it cannot be written.
    """
    from sweeps.files.atomic import replacing, storage_errors

    page = page_of(ds, **options)
    with storage_errors(f"cannot write {path}", path.parent):
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, fsync=False) as temporary:
            temporary.write_bytes(page)


def page_of(
    ds: xr.Dataset,
    *,
    name: str,
    at: Sequence[str] = (),
    orbits: int = MOST_ORBITS,
    workers: int | None = None,
    warning: str = "",
    borders: xr.Dataset | None = None,
    on_orbit: Callable[[int, int], None] = lambda *_: None,
) -> bytes:
    """Return a page to look around in a result.

    Parameters
    ----------
    ds
        The result of a sweep.
    name
        What the result is called on the page: the name of its file.
    at
        Texts such as `temperature=228`: only the nearest points of those axes.
    orbits
        How many points at most have their orbit in the page; it is computed again.
    workers
        Threads that compute the orbits; 2 where it is left out.
    warning
        A sentence about the result that a reader of the page must know.
    borders
        What `StickslipAccessor.boundaries` returns, drawn on the map over their axes.
    on_orbit
        Called with the number of finished orbits, and of all, in any thread: with 0 before the
        first, which needs its kernels compiled.

    Raises
    ------
    ReportError
        bokeh is not installed; `ds` is no result of a sweep, or has too many points for a page;
        `at` names no points; the borders are of another map.
    """
    require_bokeh()
    from sweeps.page.build import report

    text = report(
        ds,
        name,
        at=at,
        orbits=orbits,
        workers=workers,
        warning=warning,
        borders=borders,
        on_orbit=on_orbit,
    )
    # The name of a file need not be text.
    return text.encode("utf-8", errors="backslashreplace")


def is_page_of_ours(path: Path) -> bool:
    """Tell whether a file is a page of this program, which it may write anew."""
    with path.open("rb") as file:
        return _MARK in file.read(_HEAD)


def require_bokeh() -> None:
    """Raise ReportError if the library that draws is not installed."""
    if importlib.util.find_spec("bokeh") is None:
        raise ReportError("bokeh is not installed; try: pip install 'bokeh>=3.9'")
