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

from sweeps.config.diagnostics import MAX_DEPTH, UNREADABLE, Diagnostics, Located, shortened
from sweeps.human import reason

_MAX_BYTES = 1 << 20

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

_REFUSED = {
    r"[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]": (
        "contains a control character, which no text has"
    ),
    r"^ *\t[ \t]*[^\s#]": "is indented with a tab; YAML wants spaces",
    r"^%": "a line must not start with '%': directives are refused",
}
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


def read_file(path: Path, diagnostics: Diagnostics) -> Located | None:
    """What a whole file holds; None, with the reason in `diagnostics`, where it is unreadable.

    A UTF-8 byte order mark, as some editors write it, is accepted.
    """
    here = Located(None, str(path), None, "", diagnostics)
    try:
        text = _content(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        here.line = error.object.count(b"\n", 0, error.start) + 1
        here.refuse("is not UTF-8 text; save the file in the encoding UTF-8")
        return None
    except (OSError, ValueError) as error:  # ValueError: NUL in the name
        here.refuse(f"cannot be read: {reason(error)}")
        return None
    root = read_text(text, here.source, diagnostics)
    if root is not None and root.value is None:
        here.refuse("is empty; `{}` alone is the paper's Fig. 3 as a single point")
        return None
    return root


def read_text(
    text: str, source: str, diagnostics: Diagnostics, *, numbered: bool = True
) -> Located | None:
    """What a YAML text holds; None, with the reason in `diagnostics`, where it is unreadable."""
    reader = _Reader(text, source, diagnostics, numbered)
    try:
        reader.check_characters()
        return reader.document()
    except _GivenUpError:
        return None
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        reader.at(mark.line + 1 if mark else None).refuse(_syntax_message(error))
    except (YAMLError, ValueError, OverflowError) as error:
        # Escapes beyond Unicode such as "\UFFFFFFFF" end in chr(), which raises the latter two.
        reader.at(None).refuse(f"is not valid YAML: {error}")
    return None


def read_mapping(text: str, source: str) -> dict[str, Any]:
    """The mapping that a YAML text holds, without the places; raises ConfigError."""
    diagnostics = Diagnostics()
    root = read_text(text, source, diagnostics)
    if root is not None and not isinstance(root.value, dict):
        root.refuse("is no mapping")
    diagnostics.raise_problems()
    return {} if root is None else {key: child.plain() for key, child in root.children().items()}


def _content(path: Path) -> bytes:
    if path.exists() and not path.is_file():
        # Opening a FIFO would wait for its writer for ever.
        raise OSError(None, "it is not a regular file")
    with path.open("rb") as file:
        content = file.read(_MAX_BYTES + 1)
    if len(content) > _MAX_BYTES:
        raise OSError(None, "it is larger than 1 MiB, which no config is")
    return content


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
    """One pass over the parser's events, placing values and noting what is refused."""

    def __init__(self, text: str, source: str, diagnostics: Diagnostics, numbered: bool) -> None:
        self._text, self._source, self._numbered = text, source, numbered
        self._diagnostics = diagnostics
        # Any: the base class of ruamel's events declares none of their attributes.
        self._events: Iterator[Any] = iter(())

    def at(self, line: int | None, key: str = "", value: object = None) -> Located:
        line = line if self._numbered else None
        return Located(value, self._source, line, key, self._diagnostics)

    def check_characters(self) -> None:
        for pattern, message in _REFUSED.items():
            if match := re.search(pattern, self._text, re.MULTILINE):
                line = self._text.count("\n", 0, match.end() - 1) + 1
                self.at(line).refuse(message)
                raise _GivenUpError

    def document(self) -> Located:
        self._events = YAML(typ="safe", pure=True).parse(self._text)
        root = None
        for event in self._events:
            if isinstance(event, DocumentStartEvent):
                if root is not None:
                    self._at(event, "").refuse("a second document starts here; a config is one")
                    raise _GivenUpError
                root = self._node(next(self._events), "", 0)
        return root or self.at(1)

    def _at(self, event: Any, key: str, value: object = None) -> Located:
        return self.at(event.start_mark.line + 1, key, value)

    def _node(self, event: Any, key: str, depth: int) -> Located:
        if depth > MAX_DEPTH:
            self._at(event, shortened(key)).refuse("is nested too deeply")
            raise _GivenUpError
        node = self._at(event, key, UNREADABLE)
        if isinstance(event, AliasEvent):
            node.refuse(f"the alias *{event.anchor} is refused; write the value out")
            return node
        _refuse_decoration(event, node)
        if isinstance(event, MappingStartEvent):
            node.value = self._mapping(key, depth)
        elif isinstance(event, SequenceStartEvent):
            node.value = self._sequence(key, depth)
        else:
            node.value = _scalar(event.value) if event.style is None else event.value
        return node

    def _sequence(self, key: str, depth: int) -> list[Located]:
        items: list[Located] = []
        while not isinstance(event := next(self._events), SequenceEndEvent):
            self._warn_of_thousands(event, key)
            items.append(self._node(event, f"{key}[{len(items)}]", depth + 1))
        return items

    def _warn_of_thousands(self, event: Any, key: str) -> None:
        before = self._text[event.start_mark.index - 1]
        if isinstance(event, ScalarEvent) and before == "," and _THOUSANDS.fullmatch(event.value):
            message = f"',{event.value}' starts a new number in a list; 3,000 is written 3000"
            self._at(event, key).warn(message)

    def _mapping(self, key: str, depth: int) -> dict[str, Located]:
        children: dict[str, Located] = {}
        while not isinstance(event := next(self._events), MappingEndEvent):
            name = self._key(event, key, depth)
            child = self._node(next(self._events), f"{key}.{name}" if key else name, depth + 1)
            child.line = self._at(event, key).line
            if name in children:
                first = children[name].line
                child.refuse("is given twice" + (f" (first in line {first})" if first else ""))
            elif name == "<<":
                child.refuse("merge keys are refused; write the keys out")
            elif name:
                children[name] = child
        return children

    def _key(self, event: Any, key: str, depth: int) -> str:
        if isinstance(event, ScalarEvent) and event.value:
            _refuse_decoration(event, self._at(event, key))
            return str(event.value)
        self._node(event, key, depth + 1)
        self._at(event, key).refuse("a key must be a name")
        return ""


def _refuse_decoration(event: Any, node: Located) -> None:
    if event.anchor is not None:
        node.refuse(f"the anchor &{event.anchor} is refused; leave it out")
    if event.tag is not None:
        node.refuse("a tag ('!') is refused; leave it out")
