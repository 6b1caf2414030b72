"""Strict YAML 1.2 with a line number for every value.

A config is data: anchors, aliases, merge keys, tags, directives, duplicate keys and several
documents are refused, and nothing in a file can make the reader hang, recurse deeply or run code.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from sweeps.config.diagnostics import Findings, Origin, shortened
from sweeps.config.located import MAX_DEPTH, UNREADABLE, Entry

MAX_BYTES = 1 << 20

# YAML 1.2.2, section 10.3.2 (core schema).
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
# More digits than this are beyond a float; int() itself gives up at 4300.
_LONGEST_INTEGER = 400

_UNPRINTABLE = re.compile(r"[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_TAB_INDENT = re.compile(r"^ *\t[ \t]*[^\s#]", re.MULTILINE)
_DIRECTIVE = re.compile(r"^%", re.MULTILINE)
# `[3,000]` is a list of 3 and 0: valid, and hardly ever meant.
_THOUSANDS = re.compile(r"0\d\d")

_REMEDIES = {
    "mapping values are not allowed": "a text that contains ': ' needs quotes",
    "could not find expected ':'": "is a ':', or the space after it, missing?",
    "expected ',' or": "is a bracket or a comma missing?",
    "expected <block end>": "is the line indented like its neighbours, are all quotes closed?",
    "unexpected end of stream": "is a closing quote missing?",
    r"'\t' that cannot start": "write spaces instead of tabs",
    "cannot start any token": "a text that starts with this character needs quotes",
}


class _GivenUpError(Exception):
    """Reading on makes no sense; the reason has been noted."""


def read_file(path: Path, findings: Findings) -> Entry | None:
    """The entry of a whole file; None, with the reason in `findings`, where it is unreadable.

    A UTF-8 byte order mark, as some editors write it, is accepted.
    """
    origin = Origin(str(path))
    try:
        content = _content(path)
    except (OSError, ValueError) as error:  # ValueError: NUL in the name
        reason = getattr(error, "strerror", None) or error
        findings.refuse(origin, "", f"cannot be read: {reason}")
        return None
    if len(content) > MAX_BYTES:
        findings.refuse(origin, "", "is larger than 1 MiB: this is no config")
        return None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        place = Origin(origin.source, content.count(b"\n", 0, error.start) + 1)
        findings.refuse(place, "", "is not UTF-8 text; save the file in the encoding UTF-8")
        return None
    root = read_text(text, origin.source, findings)
    if root is not None and root.value is None:
        findings.refuse(origin, "", "is empty; `{}` alone is the paper's Fig. 3 as a single point")
        return None
    return root


def read_text(text: str, source: str, findings: Findings, *, numbered: bool = True) -> Entry | None:
    """The entry of a YAML text; None, with the reason in `findings`, where it is unreadable."""
    reader = _Reader(text, source, findings, numbered)
    try:
        reader.check_characters()
        return reader.document()
    except _GivenUpError:
        return None
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        message = _syntax_message(error)
        findings.refuse(reader.origin(mark.line + 1 if mark else None), "", message)
    except (YAMLError, ValueError, OverflowError) as error:
        # Escapes beyond Unicode such as "\UFFFFFFFF" end in chr(), which raises the latter two.
        findings.refuse(reader.origin(None), "", f"is not valid YAML: {error}")
    return None


def _content(path: Path) -> bytes:
    if path.exists() and not path.is_file():
        # Opening a FIFO would wait for its writer for ever.
        raise OSError(None, "it is not a regular file")
    with path.open("rb") as file:
        return file.read(MAX_BYTES + 1)


def _syntax_message(error: MarkedYAMLError) -> str:
    problem = error.problem or error.context or "syntax error"
    remedy = next((r for part, r in _REMEDIES.items() if part in problem), None)
    return f"is not valid YAML: {problem}" + (f"; {remedy}" if remedy else "")


def _scalar(text: str) -> object:
    """The value of an unquoted scalar in the core schema of YAML 1.2."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text) if len(text) < _LONGEST_INTEGER else float(text)
    if _PREFIXED.fullmatch(text):
        return int(text, 0)
    return float(text) if _FLOAT.fullmatch(text) else text


class _Reader:
    """One pass over the parser's events, building entries and noting what is refused."""

    def __init__(self, text: str, source: str, findings: Findings, numbered: bool) -> None:
        self._text = text
        self._source = source
        self._findings = findings
        self._numbered = numbered
        # Any: the base class of ruamel's events declares none of their attributes.
        self._events: Iterator[Any] = iter(())

    def origin(self, line: int | None) -> Origin:
        return Origin(self._source, line if self._numbered else None)

    def check_characters(self) -> None:
        self._refuse_first(_UNPRINTABLE, "contains a control character, which no text has")
        self._refuse_first(_TAB_INDENT, "is indented with a tab; YAML wants spaces")
        self._refuse_first(_DIRECTIVE, "a line must not start with '%': directives are refused")

    def document(self) -> Entry:
        self._events = YAML(typ="safe", pure=True).parse(self._text)
        root = Entry(None, self.origin(1))
        documents = 0
        for event in self._events:
            if isinstance(event, DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self._refuse(event, "", "a second document starts here; a config is one")
                    raise _GivenUpError
                root = self._entry(next(self._events), "", 0)
        return root

    def _refuse_first(self, pattern: re.Pattern[str], message: str) -> None:
        match = pattern.search(self._text)
        if match:
            line = self._text.count("\n", 0, match.end() - 1) + 1
            self._findings.refuse(self.origin(line), "", message)
            raise _GivenUpError

    def _refuse(self, event: Any, key: str, message: str) -> None:
        self._findings.refuse(self._at(event), key, message)

    def _at(self, event: Any) -> Origin:
        return self.origin(event.start_mark.line + 1)

    def _entry(self, event: Any, key: str, depth: int) -> Entry:
        if depth > MAX_DEPTH:
            self._refuse(event, shortened(key), "is nested too deeply")
            raise _GivenUpError
        if isinstance(event, AliasEvent):
            self._refuse(event, key, f"the alias *{event.anchor} is refused; write the value out")
            return Entry(UNREADABLE, self._at(event))
        self._refuse_decoration(event, key)
        if isinstance(event, MappingStartEvent):
            return self._mapping(event, key, depth)
        if isinstance(event, SequenceStartEvent):
            return self._sequence(event, key, depth)
        value = _scalar(event.value) if event.style is None else event.value
        return Entry(value, self._at(event))

    def _refuse_decoration(self, event: Any, key: str) -> None:
        if event.anchor is not None:
            self._refuse(event, key, f"the anchor &{event.anchor} is refused; leave it out")
        if event.tag is not None:
            self._refuse(event, key, "a tag ('!') is refused; leave it out")

    def _sequence(self, start: Any, key: str, depth: int) -> Entry:
        items: list[Entry] = []
        while not isinstance(event := next(self._events), SequenceEndEvent):
            self._warn_of_thousands(event, key)
            items.append(self._entry(event, f"{key}[{len(items)}]", depth + 1))
        return Entry(items, self._at(start))

    def _warn_of_thousands(self, event: Any, key: str) -> None:
        before = self._text[event.start_mark.index - 1]
        if isinstance(event, ScalarEvent) and before == "," and _THOUSANDS.fullmatch(event.value):
            message = f"',{event.value}' starts a new number in a list; 3,000 is written 3000"
            self._findings.warn(self._at(event), key, message)

    def _mapping(self, start: Any, key: str, depth: int) -> Entry:
        children: dict[str, Entry] = {}
        while not isinstance(event := next(self._events), MappingEndEvent):
            name = self._key(event, key, depth)
            path = f"{key}.{name}" if key else name
            child = self._entry(next(self._events), path, depth + 1)
            child.origin = self._at(event)
            if name in children:
                first = children[name].origin.line
                where = f" (first in line {first})" if first and self._numbered else ""
                self._refuse(event, path, f"is given twice{where}")
            elif name == "<<":
                self._refuse(event, path, "merge keys are refused; write the keys out")
            elif name:
                children[name] = child
        return Entry(children, self._at(start))

    def _key(self, event: Any, key: str, depth: int) -> str:
        if isinstance(event, ScalarEvent) and event.value:
            self._refuse_decoration(event, key)
            return str(event.value)
        self._entry(event, key, depth + 1)
        self._refuse(event, key, "a key must be a name")
        return ""
