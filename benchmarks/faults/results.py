"""Damaged results: the older file that a sweep is to grow."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

from faults.arena import Arena, Tally
from faults.damage import at_rest


def run(quick: bool, folder: Path) -> dict[str, Any]:
    """The tally of damage to results at rest."""
    arena, rng, tally = Arena(folder), random.Random(6), Tally()
    for _ in range(3 if quick else 1000):
        at_rest(arena, rng, tally, None, "a.nc")
    return {"damaged results at rest": tally.as_dict()}
