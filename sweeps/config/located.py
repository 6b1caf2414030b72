"""Values that remember where they were written, whether in a file, in an override or in a dict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sweeps.config.diagnostics import Findings, Origin, shortened, shown

# The deepest valid config has four levels; far below what would strain Python's recursion.
MAX_DEPTH = 12


class _Unreadable:
    """Stands for a value that was refused already, so that it is not refused again."""

    def __repr__(self) -> str:
        return "something unreadable"


UNREADABLE = _Unreadable()


@dataclass(slots=True)
class Entry:
    """A value and where it was written; children of mappings and lists are entries again.

    The origin of an entry in a mapping is that of its key.
    """

    value: Any
    origin: Origin

    def plain(self) -> Any:
        """The value without the origins."""
        if isinstance(self.value, dict):
            return {key: entry.plain() for key, entry in self.value.items()}
        if isinstance(self.value, list):
            return [entry.plain() for entry in self.value]
        return self.value

    def origin_at(self, path: tuple[int | str, ...]) -> Origin:
        """The origin of what lies at `path` below, or of its nearest ancestor that exists."""
        entry = self
        for step in path:
            try:
                entry = entry.value[step]
            except (KeyError, IndexError, TypeError):
                break
        return entry.origin


def entry_of(value: Any, source: str, findings: Findings, key: str = "", depth: int = 0) -> Entry:
    """The entry of a Python value; arrays and tuples count as lists."""
    origin = Origin(source)
    if depth > MAX_DEPTH:
        findings.refuse(origin, shortened(key), "is nested too deeply")
        return Entry(UNREADABLE, origin)

    def child(value: Any, key: str) -> Entry:
        return entry_of(value, source, findings, key, depth + 1)

    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                findings.refuse(origin, key, f"keys must be text, not {shown(name)}")
        named = {name: v for name, v in value.items() if isinstance(name, str)}
        prefix = f"{key}." if key else ""
        return Entry({name: child(v, prefix + name) for name, v in named.items()}, origin)
    if getattr(value, "ndim", 0):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return Entry([child(item, f"{key}[{i}]") for i, item in enumerate(value)], origin)
    return Entry(value, origin)
