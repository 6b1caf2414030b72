"""The text of a page, made from a result: one file that contains its scripts and styles."""

from __future__ import annotations

import base64
import hashlib
import itertools
import json
import math
import re
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

import xarray as xr
from bokeh.document import Document
from bokeh.layouts import column
from bokeh.models import Model
from bokeh.resources import Resources

from stickslip.status import Status
from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS, canonical_name
from sweeps.charts.axes import axis_of
from sweeps.charts.chart import require_borders_of
from sweeps.charts.choice import data_of, slice_at
from sweeps.charts.colours import Colours
from sweeps.engine.settings import swept_in
from sweeps.files.netcdf import content_hash
from sweeps.grid import CASE, DIRECTION
from sweeps.human import counted, size_text
from sweeps.page import MOST_ORBITS, MOST_POINTS, ReportError, facts
from sweeps.page.answers import point_data
from sweeps.page.chosen_orbits import (
    Numbers,
    chosen_points,
    packed_orbits,
    places_of,
    start_along,
)
from sweeps.page.controls import controls_html, scales_data, units_of
from sweeps.page.drawing import CROSSES, motion_figures
from sweeps.page.script_data import (
    called,
    parameter,
    parameters_of,
    sources,
    variable,
    variables_of,
)
from sweeps.page.sheets import (
    Sheet,
    View,
    colour_mappers,
    ordered,
    sheets_along,
    sheets_of,
    views_of,
)
from sweeps.page.subject import Subject
from sweeps.points import point_of

MODULES = (
    *("data", "charts", "words", "motion", "blocks"),
    *("address", "look", "controls", "server", "start"),
)
"""The modules of the script: each uses the ones before it, and the last one starts them."""

_NUMBER = re.compile(r'(?<="id":)"p\d+"')

_PORTRAIT, _SERVED_PORTRAIT = 440, 290  # pixels high
_CHOSEN = (
    " with an orbit on this page: the point at which it opens, points without a result, both sides "
    "of the boundaries between regimes, and an even spread."
)

# For a page without a result: the fields of the template, and the data of the script.
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
    "fewestDigits": 4,
    "orbits": [],
}


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
    """Return a page for exploring a result.

    Parameters
    ----------
    ds
        The result of a sweep.
    name
        The name of the result on the page, which is the name of its file.
    at
        Texts such as `temperature=228`, which restrict the page to the nearest points of axes.
    orbits
        The largest number of orbits in the page, which are computed again.
    workers
        Threads that compute the orbits; by default one for each core that the process may use.
    warning
        A sentence about the result that readers of the page must know.
    borders
        What `StickslipAccessor.boundaries` returns, drawn on the map over their axes.
    on_orbit
        Called in any thread with the numbers of finished orbits and of all orbits; first with 0,
        before the kernels are compiled.

    Raises
    ------
    ReportError
        `ds` is not the result of a sweep, or has too many points for a page; `at` names no points;
        the borders belong to another map.
    """
    part, where = part_of(ds, name, at)
    if borders is not None:
        _refuse_other_borders(part, borders)
    part = ordered(part, named=borders is None)
    chosen = chosen_points(part, orbits)
    count = itertools.count()
    if chosen.size:
        on_orbit(next(count), chosen.size)
    courses, found = packed_orbits(
        part, chosen, workers=workers, on_motion=lambda: on_orbit(next(count), chosen.size)
    )
    parts, data, hosts = _of_result(part, name, at, borders, courses, with_orbits=bool(found))
    data["orbits"] = found
    hosts |= _motion_hosts(_PORTRAIT) if found else {}
    warnings = [warning, *_versions(part, chosen)]
    parts |= _facts(part, ds, name, as_html(where), warnings)
    parts |= _hints(f"{counted(chosen.size, 'point')}{_CHOSEN}", with_orbits=bool(found))
    return _page(str(ds.attrs.get("title", name)), parts, data, hosts)


def served(subject: Subject) -> bytes:
    """Return the page that requests orbits from the process that serves it."""
    result, data, hosts = subject.result, dict(_EMPTY), dict[str, Model]()
    parts = dict.fromkeys(_PARTS, "")
    if result is not None:
        part = ordered(part_of(result, subject.name, ())[0], named=subject.borders is None)
        more, data, hosts = _of_result(
            part, subject.name, subject.at, subject.borders, with_orbits=True
        )
        source = result if subject.source is None else subject.source
        parts |= more | _facts(part, source, subject.name, "", ())
    data["live"] = {
        "first": point_data(subject.first, result),
        "scales": scales_data(subject.scales),
        "units": {name: as_html(units_of(PARAMETERS[name])) for name in PARAMETERS},
    }
    parts |= _hints("", with_orbits=True)
    parts |= {
        "warnings": "".join(f'<p class="warning">{escape(note)}</p>' for note in subject.notes),
        "mode": "live" if result is not None else "live alone",
        "parameters": controls_html(subject.first.config),
        "look": parts["look"] if result is not None else "absent",
    }
    title = " - ".join(filter(None, ["stickslip explore", subject.name]))
    return _page(title, parts, data, hosts | _motion_hosts(_SERVED_PORTRAIT), served=True)


def part_of(ds: xr.Dataset, name: str, at: Sequence[str]) -> tuple[xr.Dataset, str]:
    """Return the points of a result on the page and where they are; raises ReportError."""
    if data_of(ds) != "sweep" or "status" not in ds or "config" not in ds.attrs:
        raise ReportError(
            f"{name} does not hold the result of a sweep, and only sweeps have a page; "
            "`stickslip plot` draws trajectories and fits, and --boundaries adds borders to the "
            "page of their map"
        )
    try:
        part, where = slice_at(ds.squeeze(), at)
    except ValueError as error:
        raise ReportError(str(error)) from None
    if part["status"].dtype.kind == "f":  # of `StickslipAccessor.ok`, where NaN masks a point
        part = part.assign(status=part["status"].fillna(Status.PENDING).astype("i1"))
    points = part["status"].size
    if points > MOST_POINTS:
        longest = max(part.sizes, key=lambda dim: part.sizes[dim])
        raise ReportError(
            f"{name} has {points} points, but a page holds at most {MOST_POINTS}; show a slice, "
            f"for example with --at {longest}={part[longest].values[0]}"
        )
    return part, where


def _refuse_other_borders(part: xr.Dataset, borders: xr.Dataset) -> None:
    """Raise ReportError if borders do not belong to the map on the page."""
    try:
        require_borders_of(part, borders)
    except ValueError as error:
        raise ReportError(plain(str(error))) from None


def _versions(ds: xr.Dataset, chosen: Numbers) -> list[str]:
    """Return a warning if other versions of programs may give orbits that differ from the file."""
    if not chosen.size:
        return []
    (place,) = places_of(ds, chosen[:1])
    reasons = "; ".join(point_of(ds.isel(place)).versions)
    return [f"The orbits were recomputed and may differ: {reasons}."] if reasons else []


def _of_result(
    ds: xr.Dataset,
    name: str,
    at: Sequence[str],
    borders: xr.Dataset | None,
    others: Sequence[Model] = (),
    *,
    with_orbits: bool,
) -> tuple[dict[str, str], dict[str, Any], dict[str, Model]]:
    """Return controls and tables, the data of the script, and the hosts of the charts."""
    views, variables = views_of(ds), variables_of(ds)
    dims = list(map(str, ds["status"].dims))
    charts, hosts = _charts(ds, views, variables, others, borders)
    cut = _cut_axes(ds, at)
    one_point = [one for text in at if (one := _one_point(ds, text))]
    sliced = [word for one in [*one_point, *cut] for word in ("--at", one)]
    data = _EMPTY | charts
    data |= {
        "axes": [_axis(ds, dim) for dim in dims],
        "start": [start_along(ds, dim) for dim in dims],
        "parameters": [parameter(ds, name) for name in parameters_of(ds)],
        "variables": [variable(ds, name, colours) for name, colours in variables.items()],
        "replay": escape(shlex.join(["stickslip", "replay", name, *sliced])),
        # For values along axes; those of a slice have neighbours in the file that the page lacks.
        "fewestDigits": 17 if _has_fewer_points(ds, at) else _EMPTY["fewestDigits"],
    }
    parts = {
        "look": "" if views else "absent" if with_orbits else "single",
        "view_options": _options({view.key: view.label for view in views}),
        "variable_options": _options({name: name.replace("_", " ") for name in variables}),
        "sliders": "".join(_slider(ds, dim) for dim in dims),
        "readout": facts.readout_table(ds, parameters_of(ds), variables),
    }
    return parts, data, hosts


def _has_fewer_points(ds: xr.Dataset, at: Sequence[str]) -> bool:
    """Return whether an axis has fewer points than in the file, by `at` or as `isel` leaves it."""
    kept = (name for name in ds.coords if ds[name].ndim and _size_in_file(ds[name]) > ds[name].size)
    return any("," in text for text in at) or any(kept)


def _cut_axes(ds: xr.Dataset, at: Sequence[str]) -> list[str]:
    """Return `NAME=VALUE` for each axis of the file that was cut in Python, as by `sel`."""
    keys = (text.partition("=")[0].strip() for text in at)
    known = {canonical_name(key) or key for key in keys}
    names = {CASE, DIRECTION, *swept_in(str(ds.attrs["config"]))} - known
    cut = (ds[name] for name in sorted(names & set(ds.coords)) if not ds[name].ndim)
    return [f"{one.name}={one.item()}" for one in cut if _size_in_file(one) > 1]


def _size_in_file(coordinate: xr.DataArray) -> int:
    """Return the number of values that a coordinate has in its file; 0 if it comes from none."""
    return math.prod(coordinate.encoding.get("original_shape", (0,)))


def _one_point(ds: xr.Dataset, text: str) -> str:
    """Return the part of a slice that selects one point; nothing if several points remain.

    An axis with several points stays, and a pinned point has its value.
    """
    first, *others = text.split(",")
    key = first.partition("=")[0].strip()
    name = canonical_name(key) or key
    stays = bool(others) and name in ds.coords and ds[name].ndim > 0
    return "" if stays else first.replace("[", "")


def _charts(
    ds: xr.Dataset,
    views: Sequence[View],
    variables: Mapping[str, Colours],
    others: Sequence[Model],
    borders: xr.Dataset | None,
) -> tuple[dict[str, Any], dict[str, Model]]:
    """Return the data of the charts for the script, and hosts, each for one figure at a time.

    All figures and the sources that fill them are tags of a host, so that Bokeh includes them.
    """
    mappers = colour_mappers()
    of_views = [dict(sheets_of(ds, view, variables, mappers, borders)) for view in views]
    dims = dict.fromkeys(d for v in views if v.kind == "map" for d in (v.across, v.up) if d)
    along = {dim: dict(sheets_along(ds, dim, variables, mappers)) for dim in dims}
    sheets = [sheet for scales in (*of_views, *along.values()) for sheet in scales.values()]
    figures = {about["figure"]: drawn for drawn, about in sheets}
    places = {
        name: column(sizing_mode="stretch_width") for name in ("picture", "along-x", "along-y")
    }
    places["picture"].tags = [*figures.values(), mappers["linear"], mappers["log"]]
    places["picture"].tags += [*sources(ds, variables), *others]
    lines = [_about(along[dim]) if dim in along else None for dim in ds["status"].dims]
    return {"views": list(map(_about, of_views)), "along": lines}, places


def _about(scales: Mapping[str, Sheet]) -> dict[str, Any]:
    return {scale: about for scale, (_, about) in scales.items()}


def _motion_hosts(height: int) -> dict[str, Model]:
    portrait, courses = motion_figures(height)
    return {"portrait": portrait, "courses": column(*courses, sizing_mode="stretch_width")}


def _axis(ds: xr.Dataset, dim: str) -> dict[str, Any]:
    """Return the data of an axis for the script; points with names do not lie on a scale."""
    is_number = dim in PARAMETERS and not axis_of(ds, dim, named=True).names
    return {"name": dim, "called": called(dim), "size": ds.sizes[dim], "isNumber": is_number}


def _facts(
    part: xr.Dataset, ds: xr.Dataset, name: str, where: str, warnings: Sequence[str]
) -> dict[str, str]:
    """Return the texts of the page, as HTML; it shows `part` of `ds`, and `where` says which."""
    sizes = " × ".join(f"{str(dim).replace('_', ' ')} {n}" for dim, n in part.sizes.items())
    summary = f"{name}: {counted(part['status'].size, 'point')}" + (f" ({sizes})" if sizes else "")
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


def _hints(orbits: str, *, with_orbits: bool) -> dict[str, str]:
    """Return the hints on keys and orbits, and the classes that hide parts without an orbit."""
    hint = "Hover over a point to see its numbers; click or tap to pin it"
    releases = ", Esc releases it" if orbits else ""  # a served page always has an open point
    keys = f"Arrow keys move the pin{releases}. The address of the page links to the current view."
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
    """Return the options of a menu; the keys are their names in the address of the page."""
    return "".join(f'<option value="{key}">{escape(text)}</option>' for key, text in texts.items())


def _slider(ds: xr.Dataset, dim: str) -> str:
    ends = f'min="0" max="{ds.sizes[dim] - 1}" value="{start_along(ds, dim)}"'
    name = escape(dim)
    label = f'<label>{name.replace("_", " ")}<input type="range" name="{name}" {ends}></label>'
    return f'<div hidden>{label}<output aria-live="off"></output></div>'


# --- the file -------------------------------------------------------------------------------------


def _page(
    title: str,
    parts: Mapping[str, str],
    data: Mapping[str, Any],
    hosts: Mapping[str, Model],
    *,
    served: bool = False,
) -> bytes:
    """Return the HTML of a page.

    `title` is plain text; `parts` are HTML by their names in `page.html`; the script works with
    `data`. `hosts` are the Bokeh models in elements of the page, by the id of the element.

    A Content-Security-Policy allows no scripts but these, and no connection except, if the page is
    `served`, to the server.
    """
    document = Document()
    with document.models.freeze():  # else each root would make Bokeh search all models
        for root in hosts.values():
            document.add_root(root)
    drawn = dict(document.to_json(deferred=False))
    library, own = _library(), script()
    filled = {
        "title": escape(title),
        "policy": _policy([library, own], served=served),
        "style": _read("page.css"),
        "data": _script_json({**data, "document": drawn, "hosts": list(hosts)}),
        "library": library,
        "script": own,
    }
    text = Template(_read("page.html")).substitute(filled | dict(parts))
    return text.encode("utf-8", errors="backslashreplace")  # the name of a file need not be text


def script() -> str:
    """Return the script of a page: all modules in order, in one scope hidden from other scripts."""
    modules = "\n".join(_read(f"{name}.js") for name in MODULES)
    return f'(() => {{\n"use strict";\n{modules}}})();\n'


def _library() -> str:
    """Return BokehJS as one script that writes only warnings to the console.

    By itself Bokeh also writes each of its steps, and its log level.
    """
    text = "\n".join(Resources(mode="inline", components=["bokeh"]).js_raw)
    text = text.replace('Bokeh.set_log_level("info");', 'Bokeh.logger.set_level("warn");')
    return text.replace('console.log("Bokeh items were rendered successfully")', "0")


def _script_json(data: Any) -> str:
    """Return JSON for a script element, without a `<`, which could end it or begin a comment.

    Bokeh numbers all models that a process ever made. Models are numbered again here, so that the
    same result always makes the same page.
    """
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    numbers: dict[str, str] = {}
    return _NUMBER.sub(lambda found: numbers.setdefault(found[0], f'"p{len(numbers)}"'), text)


def _policy(scripts: Iterable[str], *, served: bool) -> str:
    """Return the Content-Security-Policy of the page."""
    digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()) for text in scripts]
    rules = (
        "default-src 'none'",
        "script-src " + " ".join(f"'sha256-{digest.decode()}'" for digest in digests),
        "style-src 'unsafe-inline'",  # bokeh styles each of its elements as it makes them
        "img-src data: blob:",
        "connect-src 'self'" if served else "connect-src 'none'",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return "; ".join(rules)


def _read(name: str) -> str:
    return (files(__package__) / "web" / name).read_text(encoding="utf-8")
