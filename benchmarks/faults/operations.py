"""File operations that fail, once or from then on: no space, a broken disk, no permission."""

from __future__ import annotations

import errno
import random
from pathlib import Path
from typing import Any

from faults.arena import Arena, Tally, armed, shim
from faults.kills import number_of_operations

ERRORS = (errno.ENOSPC, errno.EIO, errno.EACCES)


def run(quick: bool, folder: Path) -> dict[str, Any]:
    """The tally of failing operations."""
    arena, rng, tally = Arena(folder), random.Random(2), Tally()
    operations = number_of_operations(arena) if shim() else 0
    for _ in range((4 if quick else 500) if operations else 0):
        number, error, lasting = rng.randint(1, operations), rng.choice(ERRORS), rng.random() < 0.5
        what = f"operation {number} {'and all later ones fail' if lasting else 'fails'}: {error}"
        arena.attack(
            tally,
            what,
            lambda f, n=number, e=error, for_good=lasting: armed(f, n, e, lasting=for_good),
        )
    return {"failing file operations": tally.as_dict()}
