"""Texts for people: durations, sizes, reasons and spellings, and the streams they go to."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Iterable
from typing import Any, TextIO

_QUOTED = 60  # longer quotations of the user's text make a message unreadable
_LONGEST_NAME = 60  # letters that are compared: a pasted page would take difflib forever


class Messages:
    """A stream for messages: where it is closed, full or without a reader, they are lost."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write, or not."""
        with contextlib.suppress(OSError, ValueError):  # ValueError: it is closed
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Have it written, or not."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def counted(count: int, noun: str) -> str:
    """Return a number of things: `1 point`, `2 points`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def duration(seconds: float) -> str:
    """Return a duration as text: `8.4 s`, `3 min 20 s`, `2 h 5 min`."""
    if seconds < 59.95:  # below what would be rounded to 60.0 s
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


def clock(seconds: float) -> str:
    """Return a duration as on a clock: `0:08`, `3:20`, `2:05:07`."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def points_per_time(points_per_second: float) -> str:
    """Return a rate in a suitable unit: `8.5 points/s`, `1.3 points/min`, `0.2 points/h`."""
    rate = points_per_second
    for unit in ("s", "min", "h"):
        if rate >= 0.1 or unit == "h":
            break
        rate *= 60.0
    return f"{rate:.1f} points/{unit}"


def size_text(count: float) -> str:
    """Return a number of bytes as text: `512 bytes`, `1.5 MiB`."""
    for unit in ("bytes", "KiB", "MiB", "GiB"):
        if count < 1024 or unit == "GiB":
            break
        count /= 1024
    return f"{count:.0f} {unit}" if unit == "bytes" else f"{count:.1f} {unit}"


def reason(error: BaseException) -> str:
    """Return the text of an error, without the number and path that an OSError repeats."""
    return str(getattr(error, "strerror", None) or error)


def shortened(text: str) -> str:
    """Return the beginning of `text`, as much as fits into a line of the report."""
    return text if len(text) <= _QUOTED else text[: _QUOTED - 1] + "…"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ` (did you mean 'temperature'?)` if a known name is close to `name`, else nothing."""
    names = {candidate.lower(): candidate for candidate in known}
    written = name[:_LONGEST_NAME].lower()
    begun = [candidate for candidate in names if len(written) > 2 and candidate.startswith(written)]
    close = begun[:1] if len(begun) == 1 else difflib.get_close_matches(written, names, n=1)
    return f" (did you mean {names[close[0]]!r}?)" if close else ""


def printable(text: str) -> str:
    """Return a text with control characters escaped for a terminal, except line ends."""

    def escaped(character: str) -> str:
        return character.encode("unicode_escape", "surrogatepass").decode()

    return "".join(c if c.isprintable() or c == "\n" else escaped(c) for c in text)
