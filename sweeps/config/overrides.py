"""`--set KEY=VALUE`: a config is changed before it is judged, so that all rules hold as in a file.

A parameter takes its new value wherever it stood. A single number fixes it, and takes away its
axis if it had one; a list or a form such as `{linspace: ...}` makes it an axis, in the old place
or behind the others. A parameter linked in `cases` is no longer free: a list replaces its values,
a single number is refused, and `case=INDEX` picks one case and fixes all that it links. Any other
key is a path with dots, such as `integrator.rtol`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

from stickslip.variables import canonical_name
from sweeps.config.diagnostics import MAX_DEPTH, Document, quoted
from sweeps.config.yaml_reader import read_text
from sweeps.human import shortened

CASE = "case"


class Option(str):
    """A change `KEY=VALUE` that another option than `--set` stands for; messages name `option`."""

    option: str

    def __new__(cls, change: str, option: str) -> Self:
        """Return the change that an option makes."""
        self = super().__new__(cls, change)
        self.option = option
        return self


def apply_overrides(document: Document, overrides: Sequence[str]) -> dict[str, Any]:
    """Change a document as the overrides say; returns `case`, which is no key of it, if given.

    Problems are noted with the override as their source.
    """
    done: dict[str, str] = {}
    picked: dict[str, Any] = {}
    for override in overrides:
        key, equals, text = override.partition("=")
        key, source = key.strip(), _source(override)
        name = canonical_name(key) or key
        written = Document(source)
        if not key or not equals:
            written.refuse("must be KEY=VALUE, for example temperature=250")
        elif name in done:
            written.refuse(f"is set twice, first by {done[name]}", key)
        else:
            done[name] = source
            written = read_text(text, source, key)
            if written.data is not None or not written.problems:
                _apply(document, key, written, picked)
        document.problems += [replace(problem, line=None) for problem in written.problems]
        document.warnings += [replace(warning, line=None) for warning in written.warnings]
    return picked


def _source(override: str) -> str:
    return override.option if isinstance(override, Option) else f"--set {shortened(override)}"


def _apply(document: Document, key: str, written: Document, picked: dict[str, Any]) -> None:
    if name := canonical_name(key):
        _set_parameter(document, key, name, written)
    elif key == CASE:
        picked[CASE] = written.data
        document.places[CASE,] = written.source, None
    else:
        _set_path(document, key.split("."), written)


def _set_parameter(document: Document, key: str, name: str, written: Document) -> None:
    is_axis = isinstance(written.data, (list, dict))
    if document.path_of(name, "cases"):
        if is_axis:
            _set_path(document, ["cases", name], written)
        else:
            message = "is linked in `cases`; pick one case with --set case=0, or give a list"
            written.refuse(message, key)
        return
    gone, section = ("model", "sweep") if is_axis else ("sweep", "model")
    while old := document.path_of(name, gone):
        del document.data[gone][old[1]]
    _set_path(document, [section, name], written)


def _set_path(document: Document, path: list[str], written: Document) -> None:
    *sections, last = path[:MAX_DEPTH]
    target = document.data
    for depth, section in enumerate(sections):
        if target.get(section) is None:
            document.put({}, written.source, *sections[: depth + 1])
        target = target[section]
        if not isinstance(target, dict):
            message = f"there are no keys below {section}: it is {quoted(target)}"
            written.refuse(message, *path)
            return
    name = canonical_name(last) if len(path) == 2 else None
    given = document.path_of(name, path[0]) if name else ()
    document.put(written.data, written.source, *(given or (*sections, last)))
