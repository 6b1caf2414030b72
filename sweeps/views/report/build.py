"""From a result to the text of its page."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import xarray as xr

from sweeps.figures import data_of
from sweeps.figures.plot_options import slice_at
from sweeps.figures.style import styled
from sweeps.files.datasets import content_hash
from sweeps.human import size_text
from sweeps.views.points import point_of
from sweeps.views.report import MOST_POINTS, ReportError, facts
from sweeps.views.report.chosen_points import Numbers, chosen_points, places_of
from sweeps.views.report.document import page
from sweeps.views.report.drawings import drawings
from sweeps.views.report.packed_orbits import packed_orbits
from sweeps.views.report.payload import payload
from sweeps.views.report.views import View, ordered, views_of
from sweeps.views.symbols import plain


def built(
    ds: xr.Dataset,
    name: str,
    *,
    at: Sequence[str],
    orbits: int,
    workers: int | None,
    warning: str,
    on_orbit: Callable[[int, int], None],
) -> str:
    """The HTML of the page of a result; the arguments are those of `write_report`."""
    part, where = _part(ds, name, at)
    with styled():
        part, axes = ordered(part)
        views = views_of(part)
        chosen = chosen_points(part, orbits)
        count = itertools.count()
        if chosen.size:
            on_orbit(next(count), chosen.size)
        found = packed_orbits(
            part, chosen, workers=workers, on_motion=lambda: on_orbit(next(count), chosen.size)
        )
        data = payload(part, axes, views) | {
            "file": name,
            "at": list(at),
            "orbits": found,
            "figures": drawings(part, axes, views, orbits=bool(found)),
        }
        parts = _parts(part, ds, name, plain(where), [warning, *_versions(part, chosen)])
    return page(str(ds.attrs.get("title", name)), parts | _shown(views, chosen), data)


def _part(ds: xr.Dataset, name: str, at: Sequence[str]) -> tuple[xr.Dataset, str]:
    """The points of a result that the page is of, and where they are; raises ReportError."""
    if data_of(ds) != "sweep" or "status" not in ds or "config" not in ds.attrs:
        raise ReportError(f"{name} holds no result of a sweep; `stickslip plot` draws trajectories")
    try:
        part, where = slice_at(ds.squeeze(), at)
    except ValueError as error:
        raise ReportError(str(error)) from None
    points = part["status"].size
    if points > MOST_POINTS:
        longest = max(part.sizes, key=lambda dim: part.sizes[dim])
        raise ReportError(
            f"{name} has {points} points, and a page holds {MOST_POINTS}: show a slice of it, "
            f"for example with --at {longest}={part[longest].values[0]}"
        )
    return part, where


def _versions(ds: xr.Dataset, chosen: Numbers) -> list[str]:
    """What may make the orbits of the page differ from the numbers of the file."""
    if not chosen.size:
        return []
    (place,) = places_of(ds, chosen[:1])
    told = point_of(ds.isel(place)).versions
    return [f"The orbits were computed anew, and may differ: {'; '.join(told)}."] if told else []


def _parts(
    part: xr.Dataset, ds: xr.Dataset, name: str, where: str, warnings: Sequence[str]
) -> dict[str, str]:
    """The words of the page, as HTML; `part` is what it shows of `ds`."""
    sizes = " × ".join(f"{str(dim).replace('_', ' ')} {n}" for dim, n in part.sizes.items())
    summary = f"{name}: {_counted(part['status'].size)}" + (f" ({sizes})" if sizes else "")
    attributes = [(key, ds.attrs[key]) for key in ds.attrs if key not in ("config", "title")]
    dims = ", ".join(f"{dim} {n}" for dim, n in ds.sizes.items()) or "none"
    size = size_text(sum(variable.nbytes for variable in ds.variables.values()))
    content = [("dimensions", dims), ("size in memory", size), ("content_sha256", content_hash(ds))]
    return {
        "summary": escape(f"{summary}. {where}" if where else summary),
        "warnings": "".join(f'<p class="warning">{escape(told)}</p>' for told in warnings if told),
        "failures": facts.failures_table(part),
        "counts": facts.counts_table(part),
        "error": facts.largest_error(part),
        "fixed": facts.fixed_parameters(part),
        "provenance": facts.provenance_table([*content, *attributes]),
        "config": facts.config_text(str(ds.attrs["config"])),
    }


def _counted(points: int) -> str:
    """A number of points in words."""
    return f"{points} point" + "s" * (points != 1)


def _shown(views: Sequence[View], chosen: Numbers) -> dict[str, Any]:
    """Which sections there are, and what is said below the pictures."""
    orbits = (
        f"{_counted(chosen.size)} with an orbit in this page: first those without a result, then "
        "both sides of the boundaries between regimes, then an even spread."
    )
    hint = (
        "Point to see the numbers of a point, click to pin it and to draw the orbit of the nearest "
        "point that has one here."
    )
    return {
        "look": "" if views else "absent" if chosen.size else "single",
        "orbit": "" if chosen.size else "absent",
        "hint": hint if chosen.size else "Point to see the numbers of a point, click to pin it.",
        "orbits": orbits,
    }
