"""What is wrong with a config, and where: values that know their place in the text, and the report.

Everything is collected first and reported together, so that no problem hides another.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from sweeps.exits import ExpectedError
from sweeps.human import printable

# Longer quotations of the user's text make a line of the report unreadable.
_QUOTED = 60
_TOLD = 50  # problems that are printed: a screen of them
# The deepest valid config has four levels; far below what would strain Python's recursion.
MAX_DEPTH = 12

T = TypeVar("T")


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
        told = [str(problem) for problem in self.problems[:_TOLD]]
        left = len(self.problems) - len(told)
        return "\n".join([*told, *([f"... and {left} more"] if left else [])])


@dataclass
class Diagnostics:
    """The problems and warnings of one config, collected while it is read."""

    problems: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)

    def raise_problems(self) -> None:
        """Raise a ConfigError with all problems, in the order of the lines, if there is any."""
        if self.problems:
            unique = dict.fromkeys(self.problems)
            raise ConfigError(sorted(unique, key=lambda p: (p.line is None, p.line or 0)))


class _Unreadable:
    """Stands for a value that was refused already, so that it is not refused again."""

    def __repr__(self) -> str:
        return "something unreadable"


UNREADABLE = _Unreadable()


@dataclass(slots=True)
class Located:
    """A value, where it was written, and its path of keys; children are located values again.

    `source` is a file, `--set KEY=VALUE` or a dict. The line of a value in a mapping is that of
    its key.
    """

    value: Any
    source: str
    line: int | None
    key: str
    diagnostics: Diagnostics

    def refuse(self, message: str, *below: str | int) -> None:
        """Note why this value, or what should stand at the path `below` it, cannot be used."""
        nearest = self
        with contextlib.suppress(KeyError, IndexError, TypeError):
            for step in below:
                nearest = nearest.value[step]
        problem = Problem(nearest.source, nearest.line, _path(self.key, *below), message)
        self.diagnostics.problems.append(problem)

    def warn(self, message: str) -> None:
        """Note that this value is allowed, but probably not what was meant."""
        self.diagnostics.warnings.append(Problem(self.source, self.line, self.key, message))

    def read(self, convert: Callable[[Any], T]) -> T | None:
        """The value as `convert` understands it; None where it raises a ValueError, noted."""
        if self.value is UNREADABLE:
            return None
        try:
            return convert(self.value)
        except ValueError as error:
            self.refuse(str(error))
            return None

    def children(self) -> dict[str, Located]:
        """What a mapping holds; nothing where it is none."""
        return self.value if isinstance(self.value, dict) else {}

    def plain(self) -> Any:
        """The value without the places."""
        if isinstance(self.value, dict):
            return {key: child.plain() for key, child in self.value.items()}
        if isinstance(self.value, list):
            return [child.plain() for child in self.value]
        return self.value


def located(
    value: Any, source: str, diagnostics: Diagnostics, key: str = "", depth: int = 0
) -> Located:
    """A Python value, which has no lines; arrays and tuples count as lists."""
    node = Located(value, source, None, key, diagnostics)

    def child(value: Any, step: str | int) -> Located:
        return located(value, source, diagnostics, _path(key, step), depth + 1)

    if depth > MAX_DEPTH:
        node.key, node.value = shortened(key), UNREADABLE
        node.refuse("is nested too deeply")
    elif isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                node.refuse(f"keys must be text, not {quoted(name)}")
        node.value = {n: child(v, n) for n, v in value.items() if isinstance(n, str)}
    elif isinstance(value, (list, tuple)) or getattr(value, "ndim", 0) > 0:
        items = value if isinstance(value, (list, tuple)) else np.asarray(value).tolist()
        node.value = [child(item, i) for i, item in enumerate(items)]
    return node


def quoted(value: object) -> str:
    """The user's value as it is quoted in a message."""
    if value is None:
        return "nothing"
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


def shortened(text: str) -> str:
    """The beginning of `text`, as much as fits into a line of the report."""
    return text if len(text) <= _QUOTED else text[: _QUOTED - 1] + "…"


def _path(key: str, *below: str | int) -> str:
    """A path as people write it: `sweep.temperature[2]`."""
    for step in below:
        key += f"[{step}]" if isinstance(step, int) else f".{step}" if key else step
    return key
