"""From a result to the text of its page."""

from __future__ import annotations

import itertools
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import Any

import xarray as xr
from bokeh.layouts import column
from bokeh.models import Model

from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS
from sweeps.charts.at import slice_at
from sweeps.charts.axes import axis_of
from sweeps.charts.borders import axes_of, require_borders_of
from sweeps.charts.colours import Colours
from sweeps.charts.data import data_of
from sweeps.files.datasets import content_hash
from sweeps.human import size_text
from sweeps.page import MOST_POINTS, ReportError, facts
from sweeps.page.answers import point_data
from sweeps.page.beginning import Beginning
from sweeps.page.chosen_points import (
    Numbers,
    chosen_points,
    places_of,
    start_along,
)
from sweeps.page.controls import controls_html, scales_data, units_of
from sweeps.page.document import page
from sweeps.page.drawing import CROSSES
from sweeps.page.numbers import (
    called,
    nearest_source,
    parameter,
    parameters_of,
    sources,
    variable,
    variables_of,
)
from sweeps.page.orbit_figures import MotionPictures
from sweeps.page.packed_orbits import PackedOrbit, packed_orbits
from sweeps.page.sheets import (
    Sheet,
    View,
    mappers_of,
    ordered,
    sheets_along,
    sheets_of,
    views_of,
)
from sweeps.points import point_of

_PORTRAIT, _SERVED_PORTRAIT = 440, 290  # pixels high
_CHOSEN = (
    " with an orbit in this page: first that at which it opens and those without a result, then "
    "both sides of the boundaries between regimes, then an even spread."
)

# Of a page without a result: its places in the template, and what its script works with.
_PARTS = (
    *("summary", "warnings", "failures", "counts", "error", "fixed", "provenance", "config"),
    *("look", "view_options", "variable_options", "sliders", "readout", "mode", "parameters"),
)
_EMPTY: dict[str, Any] = {
    "views": [],
    "along": [],
    "crosses": CROSSES,
    "axes": [],
    "start": [],
    "parameters": [],
    "variables": [],
    "replay": "",
    "orbits": [],
}


def report(
    ds: xr.Dataset,
    name: str,
    *,
    at: Sequence[str],
    orbits: int,
    workers: int | None,
    warning: str,
    borders: xr.Dataset | None,
    on_orbit: Callable[[int, int], None],
) -> str:
    """Return the HTML of the page of a result; the arguments are those of `page_of`."""
    part, where = part_of(ds, name, at)
    if borders is not None:
        _refuse_other_borders(part, borders)
    part = ordered(part)
    chosen = chosen_points(part, orbits)
    count = itertools.count()
    if chosen.size:
        on_orbit(next(count), chosen.size)
    found = packed_orbits(
        part, chosen, workers=workers, on_motion=lambda: on_orbit(next(count), chosen.size)
    )
    others = [orbit.courses for orbit in found if orbit.courses]
    others += [nearest_source(part, chosen)] if found else []
    views, variables = views_of(part), variables_of(part)
    data, hosts = _charts(part, views, variables, others, borders)
    data |= _numbers(part, variables, name, at) | _orbits(chosen, found)
    hosts |= _motion_hosts(_PORTRAIT) if found else {}
    warnings = [warning, *_versions(part, chosen)]
    parts = _facts(part, ds, name, as_html(where), warnings)
    parts |= _controls(part, views, variables, with_orbits=bool(found))
    parts |= _hints(f"{_counted(chosen.size)}{_CHOSEN}", with_orbits=bool(found))
    return page(str(ds.attrs.get("title", name)), parts, data, hosts)


def served(beginning: Beginning) -> str:
    """Return the HTML of the page that asks the process which serves it for orbits."""
    result, data, hosts = beginning.result, dict(_EMPTY), dict[str, Model]()
    parts = dict.fromkeys(_PARTS, "")
    if result is not None:
        part = ordered(part_of(result, beginning.name, ())[0])
        views, variables = views_of(part), variables_of(part)
        data, hosts = _charts(part, views, variables, (), beginning.borders)
        data |= _numbers(part, variables, beginning.name, ()) | {"orbits": []}
        parts |= _facts(part, result, beginning.name, "", ())
        parts |= _controls(part, views, variables, with_orbits=True)
    first = beginning.first
    data["live"] = {
        "first": point_data(first, result),
        "scales": scales_data(beginning.scales),
        "units": {name: as_html(units_of(PARAMETERS[name])) for name in PARAMETERS},
    }
    parts |= _hints("", with_orbits=True)
    notes = "".join(f'<p class="warning">{escape(note)}</p>' for note in beginning.notes)
    parts |= {
        "warnings": notes,
        "mode": "live" if result is not None else "live alone",
        "parameters": controls_html(first.config),
        "look": parts["look"] if result is not None else "absent",
    }
    title = " - ".join(filter(None, ["stickslip explore", beginning.name]))
    return page(title, parts, data, hosts | _motion_hosts(_SERVED_PORTRAIT), served=True)


def part_of(ds: xr.Dataset, name: str, at: Sequence[str]) -> tuple[xr.Dataset, str]:
    """Return the points of a result that the page is of, and where they are; raises ReportError."""
    if data_of(ds) != "sweep" or "status" not in ds or "config" not in ds.attrs:
        raise ReportError(
            f"{name} holds no result of a sweep, of which a page is made; `stickslip plot` draws "
            "trajectories and fits, and --boundaries adds borders to the page of their map"
        )
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


def _refuse_other_borders(part: xr.Dataset, borders: xr.Dataset) -> None:
    """Raise ReportError if borders are not those of the map that the page is of."""
    try:
        require_borders_of(part, borders)
    except ValueError as error:
        raise ReportError(plain(str(error))) from None
    if further := sorted(set(map(str, part.sizes)) - set(axes_of(borders))):
        raise ReportError(
            f"borders are those of one map, and {further[0]} has {part.sizes[further[0]]} values "
            f"here: choose one, for example with --at {further[0]}={part[further[0]].values[0]}"
        )


def _versions(ds: xr.Dataset, chosen: Numbers) -> list[str]:
    """Return what may make the orbits of the page differ from the numbers of the file."""
    if not chosen.size:
        return []
    (place,) = places_of(ds, chosen[:1])
    reasons = "; ".join(point_of(ds.isel(place)).versions)
    return [f"The orbits were computed anew, and may differ: {reasons}."] if reasons else []


def _charts(
    ds: xr.Dataset,
    views: Sequence[View],
    variables: Mapping[str, Colours],
    others: Sequence[Model],
    borders: xr.Dataset | None,
) -> tuple[dict[str, Any], dict[str, Model]]:
    """Return what the script knows of the charts, and the places for one figure at a time.

    All figures, and the sources that fill them, are the tags of a place: they come along with it.
    """
    mappers = mappers_of(variables)
    of_views = [dict(sheets_of(ds, view, variables, mappers, borders)) for view in views]
    dims = dict.fromkeys(d for v in views if v.kind == "map" for d in (v.across, v.up) if d)
    along = {dim: dict(sheets_along(ds, dim, variables, mappers)) for dim in dims}
    sheets = [sheet for scales in (*of_views, *along.values()) for sheet in scales.values()]
    figures = {sheet.about["figure"]: sheet.figure for sheet in sheets}
    places = {
        name: column(sizing_mode="stretch_width") for name in ("picture", "along-x", "along-y")
    }
    places["picture"].tags = [*figures.values(), mappers["linear"], mappers["log"]]
    places["picture"].tags += [*sources(ds, variables), *others]
    lines = [_about(along[dim]) if dim in along else None for dim in ds["status"].dims]
    return {"views": list(map(_about, of_views)), "along": lines, "crosses": CROSSES}, places


def _about(scales: Mapping[str, Sheet]) -> dict[str, Any]:
    return {scale: sheet.about for scale, sheet in scales.items()}


def _motion_hosts(portrait: int) -> dict[str, Model]:
    pictures = MotionPictures(portrait)
    courses = column(*pictures.courses, sizing_mode="stretch_width")
    return {"portrait": pictures.portrait, "courses": courses}


def _numbers(
    ds: xr.Dataset, variables: Mapping[str, Colours], name: str, at: Sequence[str]
) -> dict[str, Any]:
    # Where several values keep an axis, the point that is pinned has its own.
    sliced = [word for text in at if "," not in text for word in ("--at", text)]
    dims = list(map(str, ds["status"].dims))
    return {
        "axes": [_axis(ds, dim) for dim in dims],
        "start": [start_along(ds, dim) for dim in dims],
        "parameters": [parameter(ds, name) for name in parameters_of(ds)],
        "variables": [variable(ds, name, colours) for name, colours in variables.items()],
        "replay": escape(shlex.join(["stickslip", "replay", name, *sliced])),
    }


def _axis(ds: xr.Dataset, dim: str) -> dict[str, Any]:
    """Return what the script knows of an axis; points that have names lie on no scale."""
    is_number = dim in PARAMETERS and not axis_of(ds, dim, named=True).names
    return {"name": dim, "called": called(dim), "size": ds.sizes[dim], "isNumber": is_number}


def _orbits(chosen: Numbers, found: Sequence[PackedOrbit]) -> dict[str, Any]:
    orbits = [
        {
            "point": number,
            "words": orbit.words,
            "drawn": orbit.courses is not None,
            "periods": orbit.periods,
        }
        for number, orbit in zip(chosen.tolist(), found, strict=True)
    ]
    return {"orbits": orbits}


def _facts(
    part: xr.Dataset, ds: xr.Dataset, name: str, where: str, warnings: Sequence[str]
) -> dict[str, str]:
    """Return the words of the page, as HTML; `part` is what it shows of `ds`, and `where`."""
    sizes = " × ".join(f"{str(dim).replace('_', ' ')} {n}" for dim, n in part.sizes.items())
    summary = f"{name}: {_counted(part['status'].size)}" + (f" ({sizes})" if sizes else "")
    attributes = [(key, ds.attrs[key]) for key in ds.attrs if key not in ("config", "title")]
    dims = ", ".join(f"{dim} {n}" for dim, n in ds.sizes.items()) or "none"
    size = size_text(sum(variable.nbytes for variable in ds.variables.values()))
    content = [("dimensions", dims), ("size in memory", size), ("content_sha256", content_hash(ds))]
    return {
        "summary": escape(summary) + (f". {where}" if where else ""),
        "warnings": "".join(f'<p class="warning">{escape(line)}</p>' for line in warnings if line),
        "failures": facts.failures_table(part),
        "counts": facts.counts_table(part),
        "error": facts.largest_error(part),
        "fixed": facts.fixed_parameters(part),
        "provenance": facts.provenance_table([*content, *attributes]),
        "config": facts.config_text(str(ds.attrs["config"])),
        "mode": "",
        "parameters": "",
    }


def _counted(points: int) -> str:
    """Return a number of points in words."""
    return f"{points} point" + "s" * (points != 1)


def _controls(
    ds: xr.Dataset, views: Sequence[View], variables: Iterable[str], *, with_orbits: bool
) -> dict[str, str]:
    """Return the controls and tables that the script works with."""
    return {
        "look": "" if views else "absent" if with_orbits else "single",
        "view_options": _options({view.key: view.label for view in views}),
        "variable_options": _options({name: name.replace("_", " ") for name in variables}),
        "sliders": "".join(_slider(ds, str(dim)) for dim in ds["status"].dims),
        "readout": facts.readout_table(ds, parameters_of(ds), variables),
    }


def _hints(orbits: str, *, with_orbits: bool) -> dict[str, str]:
    """Return what the reader is told of keys and orbits, and whether there are any of these."""
    hint = "Point to see the numbers of a point; click or tap to pin it"
    keys = (
        "Arrow keys move the pin, Esc releases it. The address of the page links to what it shows."
    )
    nearest = " and to draw the orbit of the nearest point of its kind that has one"
    computed = " and to compute its orbit"
    of_orbits = (nearest if orbits else computed) if with_orbits else ""
    return {
        "orbit": "" if with_orbits else "absent",
        "marks": "" if orbits and with_orbits else "absent",
        "hint": f"{hint}{of_orbits}. {keys}",
        "orbits": orbits,
    }


def _options(texts: Mapping[str, str]) -> str:
    """Return the options of a menu, by what they are called in the address of the page."""
    lines = (f'<option value="{key}">{escape(text)}</option>' for key, text in texts.items())
    return "".join(lines)


def _slider(ds: xr.Dataset, dim: str) -> str:
    ends = f'min="0" max="{ds.sizes[dim] - 1}" value="{start_along(ds, dim)}"'
    name = escape(dim)
    label = f'<label>{name.replace("_", " ")}<input type="range" name="{name}" {ends}></label>'
    return f'<div hidden>{label}<output aria-live="off"></output></div>'
