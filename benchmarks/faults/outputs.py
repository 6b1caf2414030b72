"""Commands that write a file out of results, killed before a file operation and given again."""

from __future__ import annotations

import random
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from faults.arena import CONFIG, Tally, armed, begin, ended, number_of_operations, shim
from sweeps.files.datasets import content_hash, open_result

_QUIET = ("--no-progress",)


class Writer(NamedTuple):
    """A command, the files that it writes, and how often it is killed."""

    words: tuple[str, ...]
    writes: tuple[str, ...]
    kills: int


WRITERS = {
    "merge": Writer(("merge", "1.nc", "2.nc", "-o", "whole.nc"), ("whole.nc",), 100),
    "export": Writer(("export", "1.nc", "-o", "a.csv"), ("a.csv", "a.columns.csv"), 30),
    "report": Writer(("report", "1.nc", "--orbits", "2", *_QUIET), ("1.html",), 30),
    "figure": Writer(("plot", "1.nc", "-o", "a.png"), ("a.png",), 30),
}


def run(quick: bool, folder: Path) -> dict[str, Any]:
    """Kill each command before random operations on its files, and give it again."""
    rng = random.Random(6)
    (folder / "results").mkdir()
    inputs = _results(folder / "results")
    return {
        f"kills of {name}": _kills(name, writer, inputs, folder, rng, quick).as_dict()
        for name, writer in WRITERS.items()
    }


def _results(folder: Path) -> list[Path]:
    """Compute the two halves of a sweep."""
    (folder / "a.yaml").write_text(CONFIG)
    for number in (1, 2):
        sweep = ("sweep", "a.yaml", "-o", f"{number}.nc", "--part", f"{number}/2", *_QUIET)
        if (end := ended(folder, begin(folder, *sweep))).code != 0:
            raise RuntimeError(end.said)
    return sorted(folder.glob("*.nc"))


def _kills(
    name: str, writer: Writer, inputs: Sequence[Path], root: Path, rng: random.Random, quick: bool
) -> Tally:
    tally = Tally()
    if shim() is None:
        return tally
    whole = _folder(root / f"{name}-whole", inputs)
    operations = number_of_operations(whole, *writer.words)
    expected = _contents(whole, writer)
    for attempt in range(3 if quick else writer.kills):
        folder = _folder(root / f"{name}-{attempt}", inputs)
        number = rng.randint(1, operations)
        ended(folder, begin(folder, *writer.words, before=armed(folder, number, 0)))
        tally.count(*_verdict(f"killed before operation {number}", folder, writer, expected))
        shutil.rmtree(folder.parent)
    return tally


def _verdict(what: str, folder: Path, writer: Writer, expected: list[object]) -> tuple[str, str]:
    """Return what became of a killed command that is given again."""
    known = {*(path.name for path in folder.glob("?.nc")), *writer.writes}
    again = ended(folder, begin(folder, *writer.words))
    if again.code is None:
        return "hung", f"{what}: {again.said[-300:]}"
    # Killed after the file had got its name, the command has nothing to do any more.
    is_there = again.code == 2 and "exists already" in again.said
    if not (again.code == 0 or is_there) or _contents(folder, writer) != expected:
        return "wrong", f"{what}: exit code {again.code}: {again.said[-300:]}"
    if left := {path.name for path in folder.iterdir()} - known:
        return "wrong", f"{what}: {', '.join(sorted(left))} left over"
    return "survived", ""


def _folder(where: Path, inputs: Sequence[Path]) -> Path:
    folder = where / "work"
    folder.mkdir(parents=True)
    for path in inputs:
        shutil.copy(path, folder)
    return folder


def _contents(folder: Path, writer: Writer) -> list[object]:
    """Return what the files hold that a command has written, without their times."""
    return [_content(folder / name) for name in writer.writes]


def _content(path: Path) -> object:
    if path.suffix == ".nc":
        return content_hash(open_result(path))
    return path.read_bytes() if path.exists() else None
