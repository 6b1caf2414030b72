"""How tables write numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

Results = dict[str, Any]
Lines = Iterator[str]
"""The head and the rows of a table, with ` | ` between the cells."""

WHAT = "what | value"


def digits(value: float | None) -> str:
    """Return a number with three digits."""
    return "not reached" if value is None else f"{value:.3g}"


def power(value: str | float) -> str:
    """Return a number with a digit before its power of ten."""
    return f"{float(value):.0e}"


def powers(values: Iterable[str | float], places: int = 1) -> str:
    """Return several such numbers, by default with two digits."""
    return ", ".join(f"{float(value):.{places}e}" for value in values)


def signed(gamma: str | float) -> str:
    """Return a rheological index with a minus sign as in print."""
    return f"{float(gamma):.2f}".replace("-", "−")


def count_by_name(counts: Mapping[str, int]) -> str:
    """Return how many there are of each."""
    return ", ".join(f"{count} {name}" for name, count in counts.items())
