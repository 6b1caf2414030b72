"""What the lines and tables of records are made of."""

from __future__ import annotations

from typing import Any

Lines = dict[str, str]
Results = dict[str, Any]


def shown(value: float) -> str:
    """A number with three digits."""
    return f"{value:.3g}"


def listed(values: list[float]) -> str:
    """Numbers with three digits."""
    return ", ".join(shown(value) for value in values)
