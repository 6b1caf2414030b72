"""Damaged bytes: in the journal of a running sweep, in journals and results at rest."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path
from typing import Any

from faults.arena import BLOCK, SWEEP, Arena, Tally, begin, ended


def journals(quick: bool, folder: Path) -> dict[str, Any]:
    """Damage journals while a sweep runs, and at rest."""
    arena, rng, running, resting = Arena(folder), random.Random(3), Tally(), Tally()
    for _ in range(3 if quick else 200):
        flip_ = _Flip(rng.randint(2, 11), rng.random(), rng.randint(1, 255))
        what = f"flipped during the sweep: {flip_}"
        arena.attack(running, what, lambda _, fault=flip_: fault, spared=BLOCK)
    killed = arena.new()
    ended(killed, begin(killed, *SWEEP, before=_Kill(6)))
    for number in range(3 if quick else 1000):
        what = "journal.json" if number % 5 == 2 else "journal"
        at_rest(arena, rng, resting, killed, f"a.nc.run/{what}")
    return {
        "flips of a running journal": running.as_dict(),
        "damaged journals at rest": resting.as_dict(),
    }


def results(quick: bool, folder: Path) -> dict[str, Any]:
    """Damage results at rest: the older file that a sweep is to grow."""
    arena, rng, tally = Arena(folder), random.Random(6), Tally()
    for _ in range(3 if quick else 1000):
        at_rest(arena, rng, tally, None, "a.nc")
    return {"damaged results at rest": tally.as_dict()}


class _BeforeBlock:
    """In the child: something happens before a block of that number."""

    def __init__(self, block: int) -> None:
        self._block = block

    def __call__(self) -> None:
        from stickslip.dispatch import task as worker

        real, begun = worker.compute_orbits, 0

        def struck(*points: Any, **options: Any) -> Any:
            nonlocal begun
            begun += 1
            if begun == self._block:
                self.strike()
            return real(*points, **options)

        worker.compute_orbits = struck

    def strike(self) -> None:
        """Let it happen."""
        raise NotImplementedError


class _Flip(_BeforeBlock):
    """Flips a byte of the journal."""

    def __init__(self, block: int, place: float, mask: int) -> None:
        super().__init__(block)
        self._place, self._mask = place, mask

    def __repr__(self) -> str:
        return f"block {self._block}, place {self._place:.4f}, mask {self._mask}"

    def strike(self) -> None:
        """See _BeforeBlock."""
        path = Path("a.nc.run/journal")
        with path.open("r+b") as file:
            at = int(self._place * path.stat().st_size)
            file.seek(at)
            byte = file.read(1)[0]
            file.seek(at)
            file.write(bytes([byte ^ self._mask]))


class _Kill(_BeforeBlock):
    """Kills the process."""

    def strike(self) -> None:
        """See _BeforeBlock."""
        os.kill(os.getpid(), 9)


def harm(path: Path, rng: random.Random) -> str:
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


def at_rest(
    arena: Arena, rng: random.Random, tally: Tally, template: Path | None, name: str
) -> None:
    """Let a sweep find a damaged file: it ends right, or refuses and touches nothing."""
    folder = arena.new()
    if template is not None:
        shutil.rmtree(folder)
        shutil.copytree(template, folder)
    what = harm(folder / name, rng)
    before = (folder / "a.nc").read_bytes()
    looks = _LOOKS if tally.tried % _LOOKED_AT == 0 else ()
    looked = [ended(folder, begin(folder, verb, "a.nc")) for verb in looks]
    end = ended(folder, begin(folder, *SWEEP))
    verdict, why = "survived", ""
    if any(one.code is None for one in (*looked, end)):
        verdict, why = "hung", "".join(one.said[-200:] for one in looked)
    elif any(one.code not in (0, 2, 5) for one in looked) or end.code not in (0, 2, 5):
        verdict, why = (
            "wrong",
            f"exit codes {[one.code for one in (*looked, end)]}: {end.said[-300:]}",
        )
    elif end.code == 0 and not arena.is_right(folder):
        verdict, why = "wrong", "another result"
    elif end.code != 0 and (folder / "a.nc").read_bytes() != before:
        verdict, why = "wrong", "a refused file was changed"
    elif end.code != 0:
        end = ended(folder, begin(folder, *SWEEP, "--overwrite"))
        if end.code != 0 or not arena.is_right(folder):
            verdict, why = "wrong", f"--overwrite: exit code {end.code}: {end.said[-300:]}"
    tally.count(verdict, f"{what}: {why}")
    arena.clear(folder)


_LOOKS, _LOOKED_AT = ("info", "status"), 10
