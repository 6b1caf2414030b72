"""How tables write numbers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

Results = dict[str, Any]
Rows = list[Iterable[str]]
"""The head and the rows of a table."""


def digits(value: float | None, absent: str = "not reached") -> str:
    """Return a number with three digits."""
    return absent if value is None else f"{value:.3g}"


def seconds(value: float) -> str:
    """Return a time with three digits."""
    return f"{value:.3g} s"


def signed(gamma: str) -> str:
    """Return a number with a minus sign as in print."""
    return gamma.replace("-", "−")


def count_by_name(counts: dict[str, int]) -> str:
    """Return how many there are of each."""
    return ", ".join(f"{count} {name}" for name, count in counts.items())
