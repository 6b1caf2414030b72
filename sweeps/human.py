"""Texts for people: durations, sizes, reasons and spellings, and a stream for messages."""

from __future__ import annotations

import contextlib
import difflib
from collections.abc import Iterable
from typing import Any, TextIO

_LONGEST_QUOTATION = 60  # longer quotations make a message unreadable
_LONGEST_NAME = 60  # letters to compare: a pasted page would take difflib forever


class Messages:
    """A stream for messages, which are lost if the stream is closed or full or has no reader."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write the text if the stream takes it."""
        with contextlib.suppress(OSError, ValueError):  # ValueError: the stream is closed
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush the stream if possible."""
        with contextlib.suppress(OSError, ValueError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def counted(count: int, noun: str) -> str:
    """Return a number of things: `1 point`, `2 points`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def duration(seconds: float) -> str:
    """Return a duration as text: `8.4 s`, `3 min 20 s`, `2 h 5 min`."""
    if seconds < 59.95:  # more would be rounded to 60.0 s
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
    for unit in ("s", "min"):
        if rate >= 0.1:
            return f"{rate:.1f} points/{unit}"
        rate *= 60.0
    return f"{rate:.1f} points/h"


def size_text(count: float) -> str:
    """Return a number of bytes as text: `512 bytes`, `1.5 MiB`."""
    if count < 1024:
        return f"{count:.0f} bytes"
    for unit in ("KiB", "MiB"):
        count /= 1024
        if count < 1024:
            return f"{count:.1f} {unit}"
    return f"{count / 1024:.1f} GiB"


def reason(error: BaseException) -> str:
    """Return the text of an error, without the number and path that an OSError repeats."""
    return str(getattr(error, "strerror", None) or error)


def shortened(text: str) -> str:
    """Return `text`, or its beginning if it is too long for a line of a report."""
    return text if len(text) <= _LONGEST_QUOTATION else text[: _LONGEST_QUOTATION - 1] + "…"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ` (did you mean 'temperature'?)` with a known name close to `name`, if any."""
    names = {candidate.lower(): candidate for candidate in known}
    written = name[:_LONGEST_NAME].lower()
    begun = [candidate for candidate in names if len(written) > 2 and candidate.startswith(written)]
    close = begun[:1] if len(begun) == 1 else difflib.get_close_matches(written, names, n=1)
    return f" (did you mean {names[close[0]]!r}?)" if close else ""


def printable(text: str) -> str:
    """Return a text whose control characters, except line ends, are escaped for a terminal."""
    return "".join(
        character
        if character.isprintable() or character == "\n"
        else character.encode("unicode_escape", "surrogatepass").decode()
        for character in text
    )
