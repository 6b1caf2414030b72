"""Kills at random times and before file operations, operations that fail, refused memory."""

from __future__ import annotations

import errno
import random
import signal
from pathlib import Path

from faults.arena import ENDINGS, Arena, Tally, armed, without_memory

# A sentence, or the end that libraries written in C choose: the program cannot tell them.
_WITHOUT_MEMORY = (1, -signal.SIGABRT, -signal.SIGSEGV)

ERRORS = (errno.ENOSPC, errno.EIO, errno.EACCES)  # no space, a broken disk, no permission


def kills(quick: bool, folder: Path) -> dict[str, Tally]:
    """Kill sweeps at random times and before file operations."""
    arena, rng, count = Arena(folder), random.Random(1), 4 if quick else 150
    anywhere, at_operations = Tally(), Tally()
    for _ in range(count):
        arena.kill(anywhere, rng)
    for _ in range(count if arena.whole.operations else 0):
        arena.kill_before_operation(at_operations, rng)
    return {"kills at random times": anywhere, "kills before a file operation": at_operations}


def failures(quick: bool, folder: Path) -> dict[str, Tally]:
    """Let file operations fail, once or from then on."""
    arena, rng, tally = Arena(folder), random.Random(2), Tally()
    for _ in range((4 if quick else 500) if arena.whole.operations else 0):
        number, error = rng.randint(1, arena.whole.operations), rng.choice(ERRORS)
        lasting = rng.random() < 0.5
        what = f"operation {number} {'and all later ones fail' if lasting else 'fails'}: {error}"
        arena.attack(tally, what, armed(number, error, lasting=lasting))
    return {"failing file operations": tally}


def memory(quick: bool, folder: Path) -> dict[str, Tally]:
    """Refuse memory, once or from then on."""
    arena = Arena(folder, endings=(*ENDINGS, *_WITHOUT_MEMORY))
    rng, tally = random.Random(3), Tally()
    for _ in range((4 if quick else 200) if arena.whole.allocations else 0):
        number, lasting = rng.randint(1, arena.whole.allocations), rng.random() < 0.5
        what = f"piece {number} of memory{' and all later ones' * lasting} refused"
        arena.attack(tally, what, without_memory(number, lasting=lasting))
    return {"memory that is refused": tally}
