"""What is wrong with a config, and where: collected first, reported together."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

# Longer quotations of the user's text make a line of the report unreadable.
_QUOTED = 60


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a value was written: a file and a line, `--set KEY=VALUE`, or a dict."""

    source: str
    line: int | None = None


@dataclass(frozen=True, slots=True)
class Problem:
    """One line of the report: where it is, which key, what is wrong and what may help."""

    file: str
    line: int | None
    key: str
    message: str

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        return ": ".join(_one_line(part) for part in (place, self.key, self.message) if part)


class ConfigError(ValueError):
    """A config cannot be used; `problems` lists every reason, `str()` gives a line for each."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = list(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


@dataclass
class Findings:
    """Collects problems and warnings while a config is read, so that none hides another."""

    problems: list[Problem] = field(default_factory=list)
    warnings: list[Problem] = field(default_factory=list)

    def refuse(self, origin: Origin, key: str, message: str) -> None:
        """Note a reason why the config cannot be used."""
        self.problems.append(Problem(origin.source, origin.line, key, message))

    def warn(self, origin: Origin, key: str, message: str) -> None:
        """Note something that is allowed, but probably not what was meant."""
        self.warnings.append(Problem(origin.source, origin.line, key, message))

    def raise_problems(self) -> None:
        """Raise a ConfigError with all problems, in the order of the lines, if there is any."""
        if self.problems:
            unique = dict.fromkeys(self.problems)
            raise ConfigError(sorted(unique, key=lambda p: (p.line is None, p.line or 0)))


def shown(value: object) -> str:
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


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """` (did you mean 'temperature'?)` where a known name is close to `name`, else nothing."""
    names = {candidate.lower(): candidate for candidate in known}
    close = difflib.get_close_matches(name[:_QUOTED].lower(), names, n=1)
    return f" (did you mean {names[close[0]]!r}?)" if close else ""


def _one_line(text: str) -> str:
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
