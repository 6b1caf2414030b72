"""A config as written: its values, their places, and its problems.

All problems are reported together, so that none hides another.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from stickslip.variables import canonical_name
from sweeps.exits import ExpectedError
from sweeps.human import printable, shortened

_SHOWN = 50  # problems to print: a screen of them
# A valid config has up to four levels; Python's recursion reaches much deeper than this.
MAX_DEPTH = 12

PARAMETER_SECTIONS = ("model", "sweep", "cases")
"""The sections that hold values of parameters."""

Path: TypeAlias = tuple[str | int, ...]
"""The keys and indices on the way to a value."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A line of the report: the place, the key, what is wrong and what may help."""

    file: str
    line: int | None
    key: str
    message: str

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        line = ": ".join(part for part in (place, self.key, self.message) if part)
        return printable(line.replace("\n", "\\n"))


class ConfigError(ExpectedError, ValueError):
    """A config with `problems`; the text has a line for each, up to a screen of them."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = list(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        lines = [str(problem) for problem in self.problems[:_SHOWN]]
        left = len(self.problems) - len(lines)
        return "\n".join([*lines, *([f"... and {left} more"] if left else [])])


class _Unreadable:
    """A placeholder for a refused value, which prevents a second refusal."""

    def __repr__(self) -> str:
        return "something unreadable"


UNREADABLE = _Unreadable()


@dataclass
class Document:
    """The plain values of a config, their places, and the problems and warnings so far.

    `source` is a file, a text or `<dict>`. `places` has the source and the line of each value that
    does not begin on the line of the value around it. The line of a value in a mapping is the line
    of its key.
    """

    source: str
    data: Any = None
    places: dict[Path, tuple[str, int | None]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)

    def refuse(self, message: str, *path: str | int) -> None:
        """Note why the value at a path cannot be used, or which value is missing there."""
        self.problems.append(Problem(*self.place(path), path_text(path), message))

    def refuse_line(self, line: int | None, message: str, *path: str | int) -> None:
        """Note a problem in a line of the text itself."""
        self.problems.append(Problem(self.source, line, path_text(path), message))

    def warn(self, message: str, *path: str | int) -> None:
        """Note that the value at a path is allowed but probably a mistake."""
        self.warnings.append(Problem(*self.place(path), path_text(path), message))

    def place(self, path: Path) -> tuple[str, int | None]:
        """Return the source and the line of a value, or of the nearest value around it."""
        while path and path not in self.places:
            path = path[:-1]
        return self.places.get(path, (self.source, None))

    def locate(self, line: int, *path: str | int) -> None:
        """Note the line of a value unless the value around it has the same line."""
        if self.place(path)[1] != line:
            self.places[path] = self.source, line

    def put(self, value: object, source: str, *path: str | int) -> None:
        """Replace the value at a path by a value from another source."""
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
        """Return the keys and values of a section, none if it is missing or not a mapping."""
        value = self.data.get(name)
        return value if isinstance(value, dict) else {}

    def parameters(self) -> Iterator[tuple[str, Path]]:
        """Yield the full name and the path of each given parameter, by name or symbol."""
        for section in (*PARAMETER_SECTIONS, "sample"):
            for key in self.section(section):
                if name := canonical_name(key):
                    yield name, (section, key)

    def path_of(self, name: str, section: str = "") -> Path:
        """Return the path where a parameter is given first, or in a section; () if nowhere."""
        paths = (path for given, path in self.parameters() if given == name)
        return next((path for path in paths if section in ("", path[0])), ())

    def raise_problems(self) -> None:
        """Raise a ConfigError with all problems, in the order of the lines, if there are any."""
        if self.problems:
            unique = dict.fromkeys(self.problems)
            raise ConfigError(sorted(unique, key=lambda p: (p.line is None, p.line or 0)))


def document_of(value: object, source: str) -> Document:
    """Return a Python value as a document without lines; arrays and tuples become lists.

    Scalars of NumPy and xarray become Python's own.
    """
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
    if refused := _unlike_numbers(value):
        document.refuse(refused, *path)
        return UNREADABLE
    if isinstance(value, (list, tuple)) or getattr(value, "ndim", 0) > 0:
        listed = value if isinstance(value, (list, tuple)) else np.asarray(value).tolist()
        return [_plain(item, document, *path, index) for index, item in enumerate(listed)]
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value


def _unlike_numbers(value: object) -> str:
    """Return why an array would lose its meaning as a list of numbers; empty if it would not."""
    if np.ma.is_masked(value):
        return "must have no masked values"
    if getattr(getattr(value, "dtype", None), "kind", "") in ("m", "M"):
        return "must be a number in SI units, not a time of NumPy"
    return ""


def quoted(value: object) -> str:
    """Return a value as a message quotes it."""
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
        return "a number with thousands of digits"


def path_text(path: Path) -> str:
    """Return a path as people write it: `sweep.temperature[2]`."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text
