"""`--set KEY=VALUE`: changes of a config before it is checked, so that all rules of a file apply.

A parameter gets its new value wherever it was given. A single number fixes it, and removes its
axis if it had one. A list or a form such as `{linspace: ...}` makes it an axis, in the old place or
after the other axes. For a parameter linked in `cases`, a list replaces its values and a single
number is refused; `case=INDEX` picks one case and fixes all linked parameters. A parameter that
`sample` draws is refused: `sample.NAME=[LOW, HIGH]` changes its range. Any other key is a path with
dots, such as `integrator.rtol`. An override that would undo an earlier one is refused.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

from stickslip.variables import canonical_name
from sweeps.config.written_config import MAX_DEPTH, Document, quoted
from sweeps.config.yaml_reader import read_text
from sweeps.human import shortened

CASE = "case"
_COMMENT = re.compile(r"\s#")


class Option(str):
    """A change `KEY=VALUE` made by an `option` other than `--set`, which messages then name."""

    option: str

    def __new__(cls, change: str, option: str) -> Self:
        """Return the change made by an option."""
        self = super().__new__(cls, change)
        self.option = option
        return self


def apply_overrides(document: Document, overrides: Sequence[str]) -> dict[str, Any]:
    """Apply overrides to a document; return `case` if given, which is no key of a document.

    Notes problems with the override as their source.
    """
    done: dict[str, str] = {}
    picked: dict[str, Any] = {}
    for override in overrides:
        source = override.option if isinstance(override, Option) else f"--set {shortened(override)}"
        key, equals, text = override.partition("=")
        key = key.strip()
        name = canonical_name(key) or key
        written = Document(source)
        if not key or not equals:
            written.refuse("must be KEY=VALUE, for example temperature=250")
        elif name in done:
            written.refuse(f"is set twice, first by {done[name]}", key)
        else:
            done[name] = source
            written = read_text(text, source, key)
            comment = _COMMENT.search(text)
            if comment and read_text(text[: comment.start()], source).data == written.data:
                written.refuse("' #' begins a comment; put the value in quotes", key)
            elif written.data is not None or not written.problems:
                _apply(document, key, written, picked)
        document.problems += [replace(problem, line=None) for problem in written.problems]
        document.warnings += [replace(warning, line=None) for warning in written.warnings]
    return picked


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
            written.refuse(
                "is linked in `cases` and cannot be set alone; pick one case with --set case=0, "
                "or give a list",
                key,
            )
        return
    if drawn := document.path_of(name, "sample"):
        change = f"its range with --set 'sample.{drawn[1]}=[LOW, HIGH]'"
        written.refuse(
            f"is drawn by `sample`; pick one case with --set case=0, or change {change}", key
        )
        return
    gone, section = ("model", "sweep") if is_axis else ("sweep", "model")
    while old := document.path_of(name, gone):
        if _is_set_before(document, written, key, *old):
            return
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
    name = canonical_name(last)
    given = [key for key in target if name and canonical_name(key) == name]
    place = (*sections, *(given[:1] or [last]))
    if not _is_set_before(document, written, ".".join(path), *place):
        document.put(written.data, written.source, *place)


def _is_set_before(document: Document, written: Document, key: str, *path: str | int) -> bool:
    """Return whether an earlier override set a value at a path or below it; refuse to undo it."""
    for other, (source, _) in document.places.items():
        if other[: len(path)] == path and source != document.source:
            written.refuse(f"would undo {source}; put this one first, or leave one out", key)
            return True
    return False
