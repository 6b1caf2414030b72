"""Accessors that other packages register on the Datasets of this one, such as `ds.stickslip`."""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points

GROUP = "stickslip.accessors"
"""Entry points of installed packages: modules that register accessors when they are imported."""


@cache
def register_accessors() -> None:
    """Let every installed package register its accessors on Datasets; once per process."""
    for entry in entry_points(group=GROUP):
        entry.load()
