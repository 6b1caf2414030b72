"""A page in one file: its parts put together, its scripts and styles inside of it."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from bokeh.resources import Resources

from sweeps.views.report.packing import script_json

_FOLDER = files(__package__) / "page"

# In the order in which they build on one another.
_SCRIPTS = (
    "numbers.js",
    "result.js",
    "colours.js",
    "jumps.js",
    "drawing.js",
    "maps.js",
    "curves.js",
    "points.js",
    "words.js",
    "orbits.js",
    "page.js",
)


def page(title: str, parts: Mapping[str, str], payload: Mapping[str, Any]) -> str:
    """The HTML of a page.

    `title` is a text and `parts` are HTML, by their names in `page/page.html`; `payload` is what
    the scripts work with.

    The page may not fetch anything: a Content-Security-Policy forbids it, as it forbids all scripts
    but these.
    """
    scripts = [_library(), _own_script()]
    filled = {
        "title": escape(title),
        "policy": _policy(scripts),
        "style": _read("page.css"),
        "payload": script_json(payload),
        "library": scripts[0],
        "script": scripts[1],
    }
    return Template(_read("page.html")).substitute(filled | dict(parts))


def _policy(scripts: list[str]) -> str:
    allowed = " ".join(f"'sha256-{_digest(script)}'" for script in scripts)
    rules = (
        "default-src 'none'",
        f"script-src {allowed}",
        "style-src 'unsafe-inline'",  # bokeh styles each of its elements as it makes them
        "img-src data: blob:",
        "connect-src 'none'",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return "; ".join(rules)


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _library() -> str:
    """BokehJS, without what draws widgets, tables and mathematics."""
    return "\n".join(Resources(mode="inline", components=["bokeh"]).js_raw)


def _own_script() -> str:
    parts = "\n".join(_read(name) for name in _SCRIPTS)
    return f'(() => {{\n"use strict";\n{parts}\n}})();\n'


def _read(name: str) -> str:
    return (_FOLDER / name).read_text(encoding="utf-8")
