"""A config as it was written, where each value stands, and what is wrong with it.

Problems are collected and reported together, so that none hides another.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from stickslip.variables import canonical_name
from sweeps.exits import ExpectedError
from sweeps.human import printable, shortened

_SHOWN = 50  # problems that are printed: a screen of them
# The deepest valid config has four levels; far below what would strain Python's recursion.
MAX_DEPTH = 12

PARAMETER_SECTIONS = ("model", "sweep", "cases")
"""The sections in which parameters stand."""

Path: TypeAlias = tuple[str | int, ...]
"""The keys and indices that lead to a value."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One line of the report: where it is, which key, what is wrong and what may help."""

    file: str
    line: int | None
    key: str
    message: str

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        line = ": ".join(part for part in (place, self.key, self.message) if part)
        return printable(line.replace("\n", "\\n"))


class ConfigError(ExpectedError, ValueError):
    """A config cannot be used; `problems` lists every reason, `str()` a line for each of many."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = list(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        lines = [str(problem) for problem in self.problems[:_SHOWN]]
        left = len(self.problems) - len(lines)
        return "\n".join([*lines, *([f"... and {left} more"] if left else [])])


class _Unreadable:
    """Stands for a value that was refused already, so that it is not refused again."""

    def __repr__(self) -> str:
        return "something unreadable"


UNREADABLE = _Unreadable()


@dataclass
class Document:
    """The plain values of a config, the place of each, and the problems and warnings so far.

    `source` is a file, a text or `<dict>`; `places` has the source and the line of each value that
    begins in another line than what it is a part of. The line of a value in a mapping is that of
    its key.
    """

    source: str
    data: Any = None
    places: dict[Path, tuple[str, int | None]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)

    def refuse(self, message: str, *path: str | int) -> None:
        """Note why the value at a path, or what should stand there, cannot be used."""
        self.problems.append(Problem(*self.place(path), path_text(path), message))

    def refuse_line(self, line: int | None, message: str, *path: str | int) -> None:
        """Note a problem in a line of the text itself."""
        self.problems.append(Problem(self.source, line, path_text(path), message))

    def warn(self, message: str, *path: str | int) -> None:
        """Note that the value at a path is allowed, but probably not what was meant."""
        self.warnings.append(Problem(*self.place(path), path_text(path), message))

    def place(self, path: Path) -> tuple[str, int | None]:
        """Return the source and the line of a value, or of the nearest one that leads to it."""
        while path and path not in self.places:
            path = path[:-1]
        return self.places.get(path, (self.source, None))

    def locate(self, line: int, *path: str | int) -> None:
        """Note the line of a value, where it is not the one of what it is a part of."""
        if self.place(path)[1] != line:
            self.places[path] = self.source, line

    def put(self, value: object, source: str, *path: str | int) -> None:
        """Put a value from another source into the place of the one at a path."""
        self.at(*path[:-1])[path[-1]] = value
        kept = {p: place for p, place in self.places.items() if p[: len(path)] != path}
        self.places = kept | {path: (source, None)}

    def at(self, *path: str | int) -> Any:
        """Return the value at a path that exists."""
        value = self.data
        for step in path:
            value = value[step]
        return value

    def section(self, name: str) -> dict[str, Any]:
        """Return what a section holds; nothing where it is missing, or no mapping."""
        value = self.data.get(name)
        return value if isinstance(value, dict) else {}

    def parameters(self) -> Iterator[tuple[str, Path]]:
        """Yield the full name and the path of each parameter that is given, by name or symbol."""
        for section in (*PARAMETER_SECTIONS, "sample"):
            for key in self.section(section):
                if name := canonical_name(key):
                    yield name, (section, key)

    def path_of(self, name: str, section: str = "") -> Path:
        """Return where a parameter is given first, or is in a section; () where it is not."""
        paths = (path for given, path in self.parameters() if given == name)
        return next((path for path in paths if section in ("", path[0])), ())

    def raise_problems(self) -> None:
        """Raise a ConfigError with all problems, in the order of the lines, if there is any."""
        if self.problems:
            unique = dict.fromkeys(self.problems)
            raise ConfigError(sorted(unique, key=lambda p: (p.line is None, p.line or 0)))


def document_of(value: object, source: str) -> Document:
    """Return a Python value as a document, which has no lines; arrays and tuples become lists."""
    document = Document(source)
    document.data = _plain(value, document)
    return document


def _plain(value: object, document: Document, *path: str | int) -> Any:
    if len(path) > MAX_DEPTH:
        document.refuse("is nested too deeply", shortened(path_text(path)))
        return UNREADABLE
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                document.refuse(f"keys must be text, not {quoted(key)}", *path)
        items = {key: item for key, item in value.items() if isinstance(key, str)}
        return {key: _plain(item, document, *path, key) for key, item in items.items()}
    if isinstance(value, (list, tuple)) or getattr(value, "ndim", 0) > 0:
        listed = value if isinstance(value, (list, tuple)) else np.asarray(value).tolist()
        return [_plain(item, document, *path, index) for index, item in enumerate(listed)]
    return value


def quoted(value: object) -> str:
    """Return the user's value as it is quoted in a message."""
    if value is None:
        return "an empty value"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "a mapping"
    if isinstance(value, (list, tuple)):
        return "a list"
    if isinstance(value, str):
        return repr(shortened(value))
    try:
        return shortened(repr(value))
    except ValueError:  # Python refuses to print integers of more than 4300 digits
        return "a number of thousands of digits"


def path_text(path: Path) -> str:
    """Return a path as people write it: `sweep.temperature[2]`."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text
