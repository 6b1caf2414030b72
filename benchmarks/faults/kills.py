"""Kills at random times and before file operations; operations that fail."""

from __future__ import annotations

import errno
import random
import signal
import time
from pathlib import Path
from typing import Any

from faults.arena import (
    ENDINGS,
    SWEEP,
    Arena,
    Tally,
    armed,
    begin,
    ended,
    number_of_operations,
    shim,
    without_memory,
)

# A sentence, or the end that libraries written in C choose: the program cannot tell them.
_WITHOUT_MEMORY = (1, -signal.SIGABRT, -signal.SIGSEGV)

ERRORS = (errno.ENOSPC, errno.EIO, errno.EACCES)  # no space, a broken disk, no permission


def kills(quick: bool, folder: Path) -> dict[str, Any]:
    """Kill sweeps at random times and before file operations."""
    arena, rng, count = Arena(folder), random.Random(1), 4 if quick else 150
    return {
        "kills at random times": _at_random(arena, rng, count).as_dict(),
        "kills before a file operation": _before_operations(arena, rng, count).as_dict(),
    }


def failures(quick: bool, folder: Path) -> dict[str, Any]:
    """Let file operations fail, once or from then on."""
    arena, rng, tally = Arena(folder), random.Random(2), Tally()
    operations = _operations(arena) if shim() else 0
    for _ in range((4 if quick else 500) if operations else 0):
        number, error, lasting = rng.randint(1, operations), rng.choice(ERRORS), rng.random() < 0.5
        what = f"operation {number} {'and all later ones fail' if lasting else 'fails'}: {error}"
        arena.attack(
            tally,
            what,
            lambda f, n=number, e=error, for_good=lasting: armed(f, n, e, lasting=for_good),
        )
    return {"failing file operations": tally.as_dict()}


def memory(quick: bool, folder: Path) -> dict[str, Any]:
    """Refuse memory, once or from then on."""
    arena, rng, tally = Arena(folder), random.Random(3), Tally()
    pieces = _operations(arena, of="allocations") if shim() else 0
    for _ in range((4 if quick else 200) if pieces else 0):
        number, lasting = rng.randint(1, pieces), rng.random() < 0.5
        arena.attack(
            tally,
            f"piece {number} of memory{' and all later ones' * lasting} refused",
            lambda _, n=number, for_good=lasting: without_memory(n, lasting=for_good),
            endings=(*ENDINGS, *_WITHOUT_MEMORY),
        )
    return {"memory that is refused": tally.as_dict()}


def _at_random(arena: Arena, rng: random.Random, count: int) -> Tally:
    tally, longest = Tally(), _duration(arena)
    for _ in range(count):
        arena.kill(tally, rng.uniform(0.0, longest))
    return tally


def _before_operations(arena: Arena, rng: random.Random, count: int) -> Tally:
    tally = Tally()
    if shim() is None:
        return tally
    operations = _operations(arena)
    for _ in range(count):
        number = rng.randint(1, operations)
        arena.attack(tally, f"killed before operation {number}", lambda f, n=number: armed(f, n, 0))
    return tally


def _operations(arena: Arena, of: str = "operations") -> int:
    folder = arena.new()
    count = number_of_operations(folder, *SWEEP, of=of)
    arena.clear(folder)
    return count


def _duration(arena: Arena) -> float:
    folder = arena.new()
    begun = time.monotonic()
    ended(folder, begin(folder, *SWEEP))
    arena.clear(folder)
    return 1.2 * (time.monotonic() - begun)
