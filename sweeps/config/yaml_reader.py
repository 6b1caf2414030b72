"""Strict YAML 1.2 with a line number for every value.

A config is data: anchors, aliases, merge keys, tags, directives, duplicate keys and several
documents are refused, and nothing in a file can make the reader hang, recurse deeply or run code.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from sweeps.config.diagnostics import MAX_DEPTH, UNREADABLE, Document
from sweeps.human import reason
from sweeps.input_files import NotTextError, text_of

_MOST_MIB = 1
_MAX_KEYS = 2000  # each would be read, compared with those that there are, and told

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
# More digits than this are beyond a float; int() itself gives up at 4300.
_LONGEST_INTEGER = 400

# `[3,000]` is a list of 3 and 0: valid, and hardly ever meant.
_THOUSANDS = re.compile(r"0\d\d")

_REMEDIES = {
    "mapping values are not allowed": "a text that contains ': ' needs quotes",
    "could not find expected ':'": "is a ':', or the space after it, missing?",
    "expected ',' or": "is a bracket or a comma missing?",
    "expected <block end>": "is the line indented like its neighbours, are all quotes closed?",
    "unexpected end of stream": "is a closing quote missing?",
    "cannot start any token": "a text that starts with this character needs quotes",
}
_MESSAGES = {
    "found another document": "a second document starts here; a config is one",
    r"'\t' that cannot start": "has a tab where none may stand; write spaces instead of tabs",
    "too many keys": f"has more than {_MAX_KEYS} keys, which no config has",
    "maximum depth": "is nested too deeply; a config has four levels of keys at most",
}


class _Alias(ScalarNode):
    """An alias that is not followed; its value is the name of the anchor."""


class _Composer(Composer):
    """Ruamel's composer, but for aliases, which could fill the memory: each stays in its place.

    Raises MarkedYAMLError at a key too many.
    """

    keys = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.parser.peek_event()
        self.keys += index is None and isinstance(parent, MappingNode)
        if self.keys > _MAX_KEYS:
            raise MarkedYAMLError(problem="too many keys", problem_mark=event.start_mark)
        if isinstance(event, AliasEvent):
            self.parser.get_event()
            return _Alias(None, event.anchor, event.start_mark, event.end_mark)
        node = super().compose_node(parent, index)
        node.ctag = event.ctag  # the tag that was written, not the one that ruamel adds
        return node


def read_file(path: Path) -> Document:
    """Return what a whole file holds; where it is unreadable, the document says why.

    A UTF-8 byte order mark, as some editors write it, is accepted.
    """
    document = Document(str(path))
    try:
        text = text_of(path, _MOST_MIB, "config")
    except NotTextError as error:
        document.refuse_line(error.line, str(error))
        return document
    except OSError as error:
        document.refuse(f"cannot be read: {reason(error)}")
        return document
    document = read_text(text, str(path))
    if document.data is None and not document.problems:
        document.refuse_line(None, "is empty; `{}` alone is the paper's Fig. 3 as a single point")
    return document


def read_text(text: str, source: str, *path: str) -> Document:
    """Return what a YAML text holds; where it is unreadable, the document says why.

    `path` leads to the whole text, where it is the value of a key.
    """
    document = Document(source)
    if directive := re.search(r"^%", text, re.MULTILINE):
        line = text.count("\n", 0, directive.start()) + 1
        document.refuse_line(line, "a line must not start with '%': directives are refused", *path)
        return document
    try:
        if root := _composed(text):
            document.data = _Values(document, text).of(root, *path)
    except ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        document.refuse_line(line, "contains a control character, which no text has", *path)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        document.refuse_line(mark.line + 1 if mark else None, _syntax_message(error), *path)
    except (YAMLError, ValueError, OverflowError) as error:
        # Escapes beyond Unicode such as "\UFFFFFFFF" end in chr(), which raises the latter two.
        document.refuse_line(None, f"is not valid YAML: {error}", *path)
    return document


def read_mapping(text: str, source: str) -> dict[str, Any]:
    """Return the mapping that a YAML text holds, without the places; raises ConfigError."""
    document = read_text(text, source)
    if document.data is not None and not isinstance(document.data, dict):
        document.refuse("is no mapping")
    document.raise_problems()
    return document.data or {}


def _composed(text: str) -> Node | None:
    """Return the root of the nodes of a text; raises YAMLError."""
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer, yaml.max_depth = _Composer, MAX_DEPTH
    yaml.composer.warn_double_anchors = False  # each is refused
    root: Node | None = yaml.compose(text)
    return root


def _syntax_message(error: MarkedYAMLError) -> str:
    problem = error.problem or error.context or "syntax error"
    for part, message in _MESSAGES.items():
        if part in problem:
            return message
    remedy = next((r for part, r in _REMEDIES.items() if part in problem), None)
    return f"is not valid YAML: {problem}" + (f"; {remedy}" if remedy else "")


@dataclass(frozen=True)
class _Values:
    """Makes plain values of ruamel's nodes, and notes their places and what no config has."""

    document: Document
    text: str

    def of(self, node: Node, *path: str | int, line: int | None = None) -> Any:
        """Return the value of a node; `line` is that of its key, where it has one."""
        self.document.locate(line or node.start_mark.line + 1, *path)
        if isinstance(node, _Alias):
            self.document.refuse(f"the alias *{node.value} is refused; write the value out", *path)
            return UNREADABLE
        self._refuse_decoration(node, *path)
        if isinstance(node, MappingNode):
            return self._mapping(node, *path)
        if isinstance(node, SequenceNode):
            return [self._item(item, *path, index) for index, item in enumerate(node.value)]
        # A quoted or folded scalar is a text.
        is_plain = isinstance(node, ScalarNode) and node.style is None
        return _scalar(node.value) if is_plain else node.value

    def _mapping(self, mapping: MappingNode, *path: str | int) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for key_node, node in mapping.value:
            key, line = key_node.value, key_node.start_mark.line + 1
            if type(key_node) is not ScalarNode or not key:
                self.document.refuse_line(line, "a key must be a name", *path)
            elif key == "<<":
                message = "merge keys are refused; write the keys out"
                self.document.refuse_line(line, message, *path, key)
            elif key in values:
                _, first = self.document.place((*path, key))
                message = f"is given twice (first in line {first})"
                self.document.refuse_line(line, message, *path, key)
            else:
                self._refuse_decoration(key_node, *path)
                values[key] = self.of(node, *path, key, line=line)
        return values

    def _item(self, node: Node, *path: str | int) -> Any:
        value = self.of(node, *path)
        before = self.text[node.start_mark.index - 1]
        if isinstance(node, ScalarNode) and before == "," and _THOUSANDS.fullmatch(node.value):
            message = f"',{node.value}' starts a new number in a list; 3,000 is written 3000"
            self.document.warn(message, *path)
        return value

    def _refuse_decoration(self, node: Node, *path: str | int) -> None:
        if node.anchor is not None:
            self.document.refuse(f"the anchor &{node.anchor} is refused; leave it out", *path)
        if node.ctag is not None:
            self.document.refuse("a tag ('!') is refused; leave it out", *path)


def _scalar(text: str) -> object:
    """Return the value of an unquoted scalar in the core schema of YAML 1.2."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text) if len(text) < _LONGEST_INTEGER else float(text)
    if _PREFIXED.fullmatch(text):
        return int(text, 0)
    return float(text) if _FLOAT.fullmatch(text) else text
