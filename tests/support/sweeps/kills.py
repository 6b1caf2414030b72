"""Kills of a sweep at random, the same command again, and a close look at what is left.

The command is the real one, but that it notes the parameters of a block before computing it. After
each kill the journal is read: points that it held before the kill must be there, to the bit (`lost`
counts those that are not), and what is computed next must not be among them (`repeated`). Points
that were begun and are not in the journal after a kill are computed once more (`recomputed`).
"""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stickslip.parameters import Parameters
from sweeps.engine.existing import found_in_journal
from sweeps.engine.settings import read_config
from sweeps.files.datasets import content_hash, open_result
from sweeps.files.journal import readable_manifest
from sweeps.files.run_folder import RunFolder
from sweeps.grid import Grid

# Seconds of work in blocks of a few tenths, so that a kill finds some finished and some in flight.
CONFIG = """\
sweep:
  temperature: {linspace: [150, 320], num: 100}
  rheological_index: [-2/3, -1/3, 0, 2/3]
integrator: {rtol: 1e-9}
stationary: {rtol: 1e-9}
execution: {workers: 2, block_points: 10}
"""
BLOCK_POINTS, WORKERS = 10, 2

_NOTING = """\
import os, sys
import numpy as np
from sweeps.engine.executors import worker
from sweeps.cli.app import main
log = os.open("begun", os.O_WRONLY | os.O_APPEND | os.O_CREAT)
compute_orbits = worker.compute_orbits
def noted(points, options, **how):
    os.write(log, np.ascontiguousarray(points).tobytes())
    return compute_orbits(points, options, **how)
worker.compute_orbits = noted
main()
"""

_MOST_BLOCKS = 5  # that are begun before a kill: few enough for several kills of one sweep
_LATEST = 0.1  # seconds from the beginning of such a block to the kill
_PATIENCE = 300.0  # seconds until a sweep counts as hanging

_BLOCK_BYTES = 8 * len(Parameters._fields) * BLOCK_POINTS

Points = dict[int, bytes]


@dataclass
class Survival:
    """What kills cost: points lost and repeated (both should be 0), recomputed after each kill."""

    lost: int = 0
    repeated: int = 0
    recomputed: list[int] = field(default_factory=list)
    hashes: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    @property
    def kills(self) -> int:
        """The number of kills that met a sweep at work."""
        return len(self.recomputed)


class Victim:
    """One sweep in a folder, begun again and again until it is done."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True)
        (folder / "k.yaml").write_text(CONFIG)
        self.output, self._folder = folder / "k.nc", folder
        self._run, self._begun = RunFolder(self.output), folder / "begun"
        self._grid = Grid.from_config(read_config(folder / "k.yaml"))

    def run(self, kill_after: tuple[int, float] | None) -> tuple[int, str]:
        """The exit code and the messages of a run, killed so many blocks and seconds on."""
        self._begun.unlink(missing_ok=True)
        command = [sys.executable, "-c", _NOTING, "sweep", "k.yaml", "-o", "k.nc"]
        with subprocess.Popen(
            command,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        ) as child:
            try:
                if kill_after is not None:
                    blocks, seconds = kill_after
                    self._wait_for_blocks(child, blocks)
                    time.sleep(seconds)
                    child.kill()
                messages = child.communicate(timeout=_PATIENCE)[1]
            except BaseException:
                child.kill()
                raise
        return child.returncode, messages

    def journaled(self) -> Points:
        """The points in the journal: their numbers and the bytes of their rows."""
        manifest = readable_manifest(self._run.journal)
        if manifest is None:
            return {}
        found = found_in_journal(self._run.journal, manifest)
        return {
            int(index): row.tobytes()
            for indices, rows in found.points()
            for index, row in zip(indices, rows, strict=True)
        }

    def begun(self) -> list[int]:
        """The numbers of the points that the last run began to compute."""
        if not self._begun.exists():
            return []
        rows = np.fromfile(self._begun).reshape(-1, len(Parameters._fields))
        return [int(number) for number in self._grid.locate(rows)]

    def _wait_for_blocks(self, child: subprocess.Popen[str], count: int) -> None:
        latest = time.monotonic() + _PATIENCE
        while self._blocks_begun() < count and child.poll() is None:
            if time.monotonic() > latest:
                raise TimeoutError("the sweep does not begin")
            time.sleep(0.01)

    def _blocks_begun(self) -> int:
        return self._begun.stat().st_size // _BLOCK_BYTES if self._begun.exists() else 0


def kill_until_done(folder: Path, rng: random.Random, most: int) -> Survival:
    """Kill a sweep at random times, at most so often, and let it come to its end."""
    survival, victim = Survival(), Victim(folder)
    before: Points = {}
    while not victim.output.exists():
        late = rng.randint(1, _MOST_BLOCKS), rng.uniform(0.0, _LATEST)
        code, messages = victim.run(late if survival.kills < most else None)
        begun = victim.begun()
        survival.repeated += len(begun) - len(set(begun)) + len(before.keys() & set(begun))
        if code == -signal.SIGKILL:
            after = victim.journaled() if not victim.output.exists() else before
            survival.lost += sum(after.get(number) != row for number, row in before.items())
            survival.recomputed.append(len(set(begun) - after.keys()))
            before = after
        elif code != 0:
            survival.complaints.append(f"exit code {code}: {messages}")
            break
    code, messages = victim.run(None)
    left = {path.name for path in folder.iterdir()}
    if code != 0 or "k.nc.run" in left:
        survival.complaints.append(f"exit code {code} in the end, {sorted(left)}: {messages}")
    survival.hashes.append(content_hash(open_result(victim.output)))
    return survival
