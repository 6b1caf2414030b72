"""A page in one file: its parts put together, its scripts and styles inside of it."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from bokeh.document import Document
from bokeh.models import Model

from sweeps.page.library import library

MODULES = (
    *("data", "charts", "words", "motion", "blocks"),
    *("address", "look", "controls", "server", "start"),
)
"""The modules of the script, each of which uses those before it and is begun by the last."""

_NUMBER = re.compile(r'(?<="id":)"p\d+"')


def page(
    title: str,
    parts: Mapping[str, str],
    data: Mapping[str, Any],
    hosts: Mapping[str, Model],
    *,
    served: bool = False,
) -> str:
    """Return the HTML of a page.

    `title` is a text and `parts` are HTML, by their names in `page.html`; `data` is what the
    script works with. `hosts` are what stands in an element of the page, by its id.

    The page may not fetch anything but, where it is `served`, from who serves it: a
    Content-Security-Policy forbids it, as it forbids all scripts but these.
    """
    scripts = [library("bokeh"), script()]
    document = _document_of(hosts.values())
    filled = {
        "title": escape(title),
        "policy": policy(scripts, served=served),
        "style": _read("page.css"),
        "data": _script_json({**data, "document": document, "hosts": list(hosts)}),
        "library": scripts[0],
        "script": scripts[1],
    }
    return Template(_read("page.html")).substitute(filled | dict(parts))


def script() -> str:
    """Return the script of a page: its modules in order, as one, which nothing else sees."""
    modules = "\n".join(_read(f"{name}.js") for name in MODULES)
    return f'(() => {{\n"use strict";\n{modules}}})();\n'


def _document_of(roots: Iterable[Model]) -> dict[str, Any]:
    document = Document()
    with document.models.freeze():  # or all models would be looked for with each root
        for root in roots:
            document.add_root(root)
    return dict(document.to_json(deferred=False))


def _script_json(data: Any) -> str:
    """Return JSON that can stand in a script element: no `<` can end it, or begin a comment.

    Models are numbered anew, since Bokeh counts all that a process ever made: the same result makes
    the same page.
    """
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    numbers: dict[str, str] = {}
    return _NUMBER.sub(lambda found: numbers.setdefault(found[0], f'"p{len(numbers)}"'), text)


def policy(scripts: list[str], *, served: bool) -> str:
    """Return what the page may do, as a Content-Security-Policy."""
    fetched = "'self'" if served else "'none'"
    allowed = " ".join(f"'sha256-{_digest(script)}'" for script in scripts)
    rules = (
        "default-src 'none'",
        f"script-src {allowed}",
        "style-src 'unsafe-inline'",  # bokeh styles each of its elements as it makes them
        "img-src data: blob:",
        f"connect-src {fetched}",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return "; ".join(rules)


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()


def _read(name: str) -> str:
    return (files(__package__) / "web" / name).read_text(encoding="utf-8")
