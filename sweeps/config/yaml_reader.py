"""Read strict YAML 1.2, with a line number for every value.

A config is data. The reader refuses anchors, aliases, merge keys, tags, directives, duplicate keys
and several documents, and nothing in a file can make it hang, recurse deeply or run code.
"""

from __future__ import annotations

import math
import pathlib
import re
from collections.abc import Iterator
from typing import Any

from ruamel.yaml import YAML, events
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.reader import ReaderError

from sweeps.config.written_config import MAX_DEPTH, UNREADABLE, Document, Path
from sweeps.human import reason
from sweeps.input_files import NotTextError, text_of

_MOST_MIB = 1
_MAX_KEYS = 2000  # each key is read, compared with the known keys, and reported

# YAML 1.2.2, section 10.3.2 (core schema); ruamel's own numbers may hold underscores.
_INTEGER = re.compile(r"[-+]?[0-9]+")
_PREFIXED = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: dict[str, object] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), math.inf),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -math.inf),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
}
# More digits than this are beyond a float; int() refuses more than 4300.
_LONGEST_INTEGER = 400

# `[3,000]` is a list of 3 and 0, which is valid but hardly ever meant.
_THOUSANDS = re.compile(r"0\d\d")

_REMEDIES = {
    "mapping values are not allowed": "text that contains ': ' needs quotes",
    "could not find expected ':'": "is a ':', or the space after it, missing?",
    "expected ',' or": "is a bracket or a comma missing?",
    "expected <block end>": "is the line indented like its neighbours? are all quotes closed?",
    "unexpected end of stream": "is a closing quote missing?",
    "cannot start any token": "text that starts with this character needs quotes",
}
_MESSAGES = {
    "another document": "a second document starts here; a config is a single document",
    r"'\t' that cannot start": "has a tab where YAML allows none; write spaces instead of tabs",
    "too many keys": f"has more than {_MAX_KEYS} keys, too many for a config",
    "maximum depth": "is nested too deeply; a config has at most four levels of keys",
}


def read_file(path: pathlib.Path) -> Document:
    """Return the document in a file, with a problem if the file cannot be read.

    A UTF-8 byte order mark, which some editors write, is accepted.
    """
    document = Document(str(path))
    try:
        document = read_text(text_of(path, _MOST_MIB, "config"), str(path))
    except NotTextError as error:
        document.refuse_line(error.line, str(error))
    except OSError as error:
        document.refuse(f"cannot be read: {reason(error)}")
    if document.data is None and not document.problems:
        document.refuse_line(None, "is empty; write `{}` for the paper's Fig. 3 as a single point")
    return document


def read_text(text: str, source: str, *path: str) -> Document:
    """Return the document in a YAML text, with a problem if the text cannot be read.

    If the text is the value of a key, `path` is the path of that key.
    """
    document = Document(source)
    if directive := re.search(r"^%", text, re.MULTILINE):
        line = text.count("\n", 0, directive.start()) + 1
        document.refuse_line(line, "no line may start with '%': directives are not allowed", *path)
        return document
    try:
        return _Reader(text, source, path).read()
    except ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        document.refuse_line(line, "contains a control character; remove it", *path)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        document.refuse_line(mark.line + 1 if mark else None, _syntax_message(error), *path)
    except (YAMLError, ValueError, OverflowError) as error:
        # chr() raises the last two errors for escapes beyond Unicode such as "\UFFFFFFFF".
        document.refuse_line(None, f"is not valid YAML: {error}", *path)
    return document


def read_mapping(text: str, source: str) -> dict[str, Any]:
    """Return the mapping in a YAML text, without the places; raises ConfigError."""
    document = read_text(text, source)
    if document.data is not None and not isinstance(document.data, dict):
        document.refuse("is not a mapping")
    document.raise_problems()
    return document.data or {}


def _syntax_message(error: MarkedYAMLError) -> str:
    problem = error.problem or error.context or "syntax error"
    for part, message in _MESSAGES.items():
        if part in problem:
            return message
    remedy = next((f"; {remedy}" for part, remedy in _REMEDIES.items() if part in problem), "")
    return f"is not valid YAML: {problem}{remedy}"


class _Reader:
    """A reader that turns ruamel's events into plain values, and notes places and problems."""

    def __init__(self, text: str, source: str, path: Path) -> None:
        self.text, self.document, self.path, self.keys = text, Document(source), path, 0
        self.events: Iterator[Any] = YAML(typ="safe", pure=True).parse(text)

    def read(self) -> Document:
        """Return the document in the text; raises YAMLError, or an error of Python."""
        next(self.events)  # the stream begins
        if isinstance(next(self.events), events.DocumentStartEvent):
            root = next(self.events)
            self.document.locate(root.start_mark.line + 1, *self.path)
            self.document.data = self._value(root, *self.path)
            next(self.events)  # the document ends
            if isinstance(event := next(self.events), events.DocumentStartEvent):
                raise _refusal("another document", event)
        return self.document

    def _value(self, event: Any, *path: str | int) -> Any:
        """Return the value that begins with an event."""
        if isinstance(event, events.AliasEvent):  # following aliases could fill the memory
            message = f"the alias *{event.anchor} is not allowed; write the value out"
            self.document.refuse(message, *path)
            return UNREADABLE
        self._refuse_decoration(event, *path)
        if isinstance(event, events.ScalarEvent):
            # A quoted or folded scalar is a text.
            return scalar(event.value) if event.style is None else event.value
        if isinstance(event, events.MappingStartEvent):
            return self._mapping(*path)
        return [self._item(item, *path, i) for i, item in enumerate(self._inner(*path))]

    def _inner(self, *path: str | int) -> Iterator[Any]:
        """Yield the first event of each item or key of the value at a path."""
        while not isinstance(event := next(self.events), events.CollectionEndEvent):
            depth = len(path) + 2 - len(self.path)  # of the event; the root has depth 1
            if depth > MAX_DEPTH and not isinstance(event, events.AliasEvent):
                raise _refusal("maximum depth", event)
            yield event

    def _mapping(self, *path: str | int) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for event in self._inner(*path):
            self.keys += 1
            if self.keys > _MAX_KEYS:
                raise _refusal("too many keys", event)
            key, line = getattr(event, "value", ""), event.start_mark.line + 1
            inner = (*path, key) if key else path
            if not key:
                message = "a key must be a name"
            elif key == "<<":
                message = "merge keys are not allowed; write the keys out"
            elif key in values:
                message = f"is given twice (first in line {self.document.place(inner)[1]})"
            else:
                self._refuse_decoration(event, *path)
                self.document.locate(line, *inner)
                values[key] = self._value(next(self.events), *inner)
                continue
            self.document.refuse_line(line, message, *inner)
            document, self.document = self.document, Document("")  # to note nothing about the value
            self._value(event, *path, key)
            self._value(next(self.events), *path, key)
            self.document = document
        return values

    def _item(self, event: Any, *path: str | int) -> Any:
        self.document.locate(event.start_mark.line + 1, *path)
        before, written = self.text[event.start_mark.index - 1], getattr(event, "value", "")
        if before == "," and _THOUSANDS.fullmatch(written):
            message = f"',{written}' starts a new number in a list; 3,000 is written 3000"
            self.document.warn(message, *path)
        return self._value(event, *path)

    def _refuse_decoration(self, event: Any, *path: str | int) -> None:
        if event.anchor is not None:
            self.document.refuse(f"the anchor &{event.anchor} is not allowed; leave it out", *path)
        if event.ctag is not None:
            self.document.refuse("a tag ('!') is not allowed; leave it out", *path)


def _refusal(problem: str, event: events.Event) -> MarkedYAMLError:
    return MarkedYAMLError(problem=problem, problem_mark=event.start_mark)


def scalar(text: str) -> object:
    """Return the value of an unquoted scalar in the core schema of YAML 1.2."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text) if len(text) < _LONGEST_INTEGER else float(text)
    if _PREFIXED.fullmatch(text):
        return int(text, 0)
    return float(text) if _FLOAT.fullmatch(text) else text
