"""Two sweeps at once, signals at random times, disks that are full."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import time
from functools import partial
from pathlib import Path

from faults.arena import SWEEP, Arena, Tally, begin, ended, speak_into

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def run(quick: bool, folder: Path) -> dict[str, Tally]:
    """Attack by a second sweep, by signals and by full disks."""
    arena, rng = Arena(folder), random.Random(4)
    pairs, signals, disks = Tally(), Tally(), Tally()
    for _ in range(2 if quick else 100):
        _pair(arena, rng, pairs)
    for _ in range(3 if quick else 60):
        _signal(arena, rng, signals)
    for _ in range(2 if quick else 60):
        _full_disk(arena, rng, disks)
    return {"two sweeps at once": pairs, "signals at random times": signals, "full disks": disks}


def _pair(arena: Arena, rng: random.Random, tally: Tally) -> None:
    apart = rng.uniform(0.0, 0.05)
    with arena.folder() as folder:
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


def _signal(arena: Arena, rng: random.Random, tally: Tally) -> None:
    late = rng.uniform(0.0, 0.3)
    numbers = [rng.choice(SIGNALS) for _ in range(rng.randint(1, 2))]
    with arena.folder() as folder:
        process = begin(folder, *SWEEP)
        while process.is_alive() and not (folder / "a.nc.run" / "heartbeat.json").exists():
            time.sleep(0.001)
        for number in numbers:
            time.sleep(late)
            if process.is_alive() and process.pid:
                os.kill(process.pid, number)
        end = ended(folder, process)
        arena.judge(tally, f"{numbers} after {late:.3f} s", folder, end)


def _full_disk(arena: Arena, rng: random.Random, tally: Tally) -> None:
    """Sweep on a disk of its own with little room, if this user may mount one."""
    room = rng.randrange(400)
    with arena.folder() as folder:
        disk = folder.parent / "disk"
        disk.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "none", str(disk)]
        if subprocess.run(mount, capture_output=True).returncode:
            return
        try:
            work, filler = disk / "work", disk / "filler"
            shutil.move(folder, work)
            filler.write_bytes(bytes(max(0, shutil.disk_usage(disk).free - 1024 * room)))
            elsewhere = partial(speak_into, str(folder.parent / "said"))
            end = ended(folder, begin(work, *SWEEP, before=elsewhere))
            filler.unlink()
            arena.judge(tally, f"{room} KiB left", work, end)
        finally:
            subprocess.run(["umount", "--lazy", str(disk)], check=True)
