"""Accessors that other packages register on the Datasets of this one, such as `ds.stickslip`."""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points

GROUP = "stickslip.accessors"
"""The group of entry points. Each is a module that registers accessors when it is imported."""


@cache
def register_accessors() -> None:
    """Load the accessors of all installed packages, once per process."""
    for entry in entry_points(group=GROUP):
        entry.load()
