"""A power cut at any moment of a sweep costs the unflushed points, and nothing else."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from support.marks import one_then
from support.sweeps.power import Disk
from support.sweeps.sweeping import LOOSE, ONE_BY_ONE, Shell, hash_at_once, hash_of, write

from sweeps.files import journal

COMMAND = ("sweep", "a.yaml", "-o", "a.nc")


def put(found: dict[str, tuple[bytes, int]]) -> None:
    """Give the folder the contents of a disk."""
    for path in Path().iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    for name, (content, time) in found.items():
        path = Path(name)
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
        os.utime(path, ns=(time, time))


@pytest.mark.slow
@pytest.mark.parametrize(
    "seconds",
    one_then("faults", [0.0, 1e9]),
    ids=["flushed at once", "flushed at the end"],
)
@pytest.mark.parametrize("points", one_then("faults", [5, 14]))
def test_a_power_cut_costs_only_unflushed_points(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, points: int, seconds: float
) -> None:
    monkeypatch.setattr(journal, "SECONDS_BETWEEN_FLUSHES", seconds)
    grown = f"sweep: {{T: {[200 + 10 * number for number in range(points)]}}}\n"
    expected = hash_at_once(write("a.yaml", grown, LOOSE, ONE_BY_ONE))
    write("old.yaml", "sweep: {T: [200, 230]}\n", LOOSE)
    shell.ok("sweep", "old.yaml", "-o", "a.nc")
    disk = Disk(Path())
    with disk.watching():
        shell.ok(*COMMAND)
    seen: set[int] = set()
    for count in range(len(disk.operations) + 1):
        for missing in disk.failures(count):
            found = disk.after(count, missing)
            state = hash(frozenset(found.items()))
            if state in seen:
                continue
            seen.add(state)
            put(found)
            said = shell(*COMMAND)
            assert said.code == 0, (count, missing, said.err)
            assert hash_of("a.nc") == expected, (count, missing)
            safe = max(2, flushed(disk, count))  # the old file has two
            assert len(shell.computed) <= max(points - safe, 0), (count, missing)
            assert not Path("a.nc.run").exists()
    assert len(seen) > 25


def flushed(disk: Disk, count: int) -> int:
    """The number of safe points after some operations; all points once the journal is removed."""
    unsettled = set(disk.unsettled(count))
    names = {done.file for done in disk.operations if done.name.endswith("/journal")}
    if any(done.what == "unlink" and done.file in names for done in disk.operations[:count]):
        return len(disk.operations)
    return sum(
        len(done.data) // journal.BYTES_PER_POINT
        for number, done in enumerate(disk.operations[:count])
        if done.what == "write" and done.file in names and number not in unsettled
    )
