"""Two sweeps at once, signals at random times, disks that are full."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

from faults.arena import SWEEP, Arena, Tally, begin, ended

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def run(quick: bool, folder: Path) -> dict[str, Any]:
    """Attack by a second sweep, by signals and by full disks."""
    arena, rng = Arena(folder), random.Random(4)
    return {
        "two sweeps at once": _pairs(arena, rng, 2 if quick else 100).as_dict(),
        "signals at random times": _signals(arena, rng, 3 if quick else 60).as_dict(),
        "full disks": _disks(arena, rng, 2 if quick else 60).as_dict(),
    }


def _pairs(arena: Arena, rng: random.Random, count: int) -> Tally:
    tally = Tally()
    for _ in range(count):
        folder, apart = arena.new(), rng.uniform(0.0, 0.05)
        first = begin(folder, *SWEEP)
        time.sleep(apart)
        second = begin(folder, *SWEEP)
        ends = [ended(folder, first), ended(folder, second)]
        what = f"{apart:.3f} s apart"
        codes = sorted(-1 if end.code is None else end.code for end in ends)
        if codes in ([0, 0], [0, 4]):
            arena.judge(tally, what, folder, ends[0] if ends[0].code == 0 else ends[1])
        else:
            tally.count("hung" if -1 in codes else "wrong", f"{what}: exit codes {codes}")
        arena.clear(folder)
    return tally


def _signals(arena: Arena, rng: random.Random, count: int) -> Tally:
    tally = Tally()
    for _ in range(count):
        folder, late = arena.new(), rng.uniform(0.0, 0.3)
        numbers = [rng.choice(SIGNALS) for _ in range(rng.randint(1, 2))]
        process = begin(folder, *SWEEP)
        while process.is_alive() and not (folder / "a.nc.run" / "heartbeat.json").exists():
            time.sleep(0.001)
        for number in numbers:
            time.sleep(late)
            if process.is_alive() and process.pid:
                os.kill(process.pid, number)
        end = ended(folder, process)
        arena.judge(tally, f"{numbers} after {late:.3f} s", folder, end)
        arena.clear(folder)
    return tally


def _disks(arena: Arena, rng: random.Random, count: int) -> Tally:
    tally = Tally()
    for _ in range(count):
        folder = arena.new()
        disk, room = folder.parent / "disk", rng.randrange(400)
        disk.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "none", str(disk)]
        if subprocess.run(mount, capture_output=True).returncode:
            arena.clear(folder)
            return tally  # this user may not mount one
        try:
            work = disk / "work"
            shutil.move(folder, work)
            filler = disk / "filler"
            free = shutil.disk_usage(disk).free
            filler.write_bytes(bytes(max(0, free - 1024 * room)))
            process = begin(work, *SWEEP, before=_Log(str(folder.parent / "said")))
            end = ended(folder, process)
            filler.unlink()
            arena.judge(tally, f"{room} KiB left", work, end)
        finally:
            subprocess.run(["umount", "--lazy", str(disk)], check=True)
        shutil.rmtree(folder.parent)
    return tally


class _Log:
    """In the child: messages go to a file on another disk."""

    def __init__(self, path: str) -> None:
        self._path = path

    def __call__(self) -> None:
        handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for number in (1, 2):
            os.dup2(handle, number)
