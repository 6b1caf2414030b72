"""Damaged bytes: in the journal of a running sweep, in journals and results at rest."""

from __future__ import annotations

import os
import random
import shutil
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from faults.arena import BLOCK, SWEEP, Arena, Tally, begin, ended

_LOOKS, _LOOKED_AT = ("info", "status"), 10
"""The commands that look at a damaged file before the sweep does, at every so many."""


def journals(quick: bool, folder: Path) -> dict[str, Tally]:
    """Damage journals while a sweep runs, and at rest."""
    arena, rng = Arena(folder, spared=BLOCK), random.Random(3)
    running, resting = Tally(), Tally()
    for _ in range(3 if quick else 200):
        block, place, mask = rng.randint(2, 11), rng.random(), rng.randint(1, 255)
        what = f"flipped during the sweep: block {block}, place {place:.4f}, mask {mask}"
        strike = partial(_before_block, block, partial(_flip, place, mask))
        arena.attack(running, what, strike)
    with arena.folder() as killed:
        strike = partial(_before_block, 6, _die)
        ended(killed, begin(killed, *SWEEP, before=strike))
        for number in range(3 if quick else 1000):
            name = "journal.json" if number % 5 == 2 else "journal"
            _at_rest(arena, rng, resting, killed, f"a.nc.run/{name}")
    return {"flips of a running journal": running, "damaged journals at rest": resting}


def results(quick: bool, folder: Path) -> dict[str, Tally]:
    """Damage results at rest: the older file that a sweep is to grow."""
    arena, rng, tally = Arena(folder), random.Random(6), Tally()
    for _ in range(3 if quick else 1000):
        _at_rest(arena, rng, tally, None, "a.nc")
    return {"damaged results at rest": tally}


def _before_block(number: int, strike: Callable[[], None]) -> None:
    """In the child: let something happen before a block of that number."""
    from stickslip.dispatch import task as worker

    real, begun = worker.compute_orbits, 0

    def struck(*points: Any, **options: Any) -> Any:
        nonlocal begun
        begun += 1
        if begun == number:
            strike()
        return real(*points, **options)

    worker.compute_orbits = struck


def _die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def _flip(place: float, mask: int) -> None:
    """Flip bits of a byte of the journal."""
    path = Path("a.nc.run/journal")
    with path.open("r+b") as file:
        at = int(place * path.stat().st_size)
        file.seek(at)
        byte = file.read(1)[0]
        file.seek(at)
        file.write(bytes([byte ^ mask]))


def _harm(path: Path, rng: random.Random) -> str:
    """Damage a file by bits, a cut, zeros or rubbish, and return what was done."""
    content = bytearray(path.read_bytes())
    at, kind = rng.randrange(len(content)), rng.choice(("bits", "bits", "cut", "zeros", "rubbish"))
    if kind == "bits":
        for _ in range(rng.randint(1, 3)):
            content[rng.randrange(len(content))] ^= rng.randint(1, 255)
    elif kind == "cut":
        del content[at:]
    else:
        length = min(rng.randint(1, 512), len(content) - at)
        content[at : at + length] = bytes(length) if kind == "zeros" else rng.randbytes(length)
    path.write_bytes(content)
    return f"{kind} at {at} of {path.name}"


def _at_rest(
    arena: Arena, rng: random.Random, tally: Tally, template: Path | None, name: str
) -> None:
    """Let a sweep find a damaged file: it ends right, or refuses and touches nothing."""
    with arena.folder() as folder:
        if template is not None:
            shutil.copytree(template, folder, dirs_exist_ok=True)
        what = _harm(folder / name, rng)
        looks = _LOOKS if tally.tried % _LOOKED_AT == 0 else ()
        verdict, why = _verdict(arena, folder, looks)
        tally.count(verdict, f"{what}: {why}")


def _verdict(arena: Arena, folder: Path, looks: tuple[str, ...]) -> tuple[str, str]:
    before = (folder / "a.nc").read_bytes()
    looked = [ended(folder, begin(folder, verb, "a.nc")) for verb in looks]
    end = ended(folder, begin(folder, *SWEEP))
    codes = [one.code for one in (*looked, end)]
    if None in codes:
        return "hung", "".join(one.said[-200:] for one in looked)
    if not set(codes) <= {0, 2, 5}:
        return "wrong", f"exit codes {codes}: {end.said[-300:]}"
    if end.code == 0:
        return ("survived", "") if arena.is_right(folder) else ("wrong", "another result")
    if (folder / "a.nc").read_bytes() != before:
        return "wrong", "a refused file was changed"
    end = ended(folder, begin(folder, *SWEEP, "--overwrite"))
    if end.code != 0 or not arena.is_right(folder):
        return "wrong", f"--overwrite: exit code {end.code}: {end.said[-300:]}"
    return "survived", ""
