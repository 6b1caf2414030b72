"""Commands that write files, killed before a file operation or at any time, and given again."""

from __future__ import annotations

import random
import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from faults.arena import CONFIG, Tally, armed, begin, ended, undisturbed
from sweeps.files.netcdf import content_hash, open_result

_QUIET = "--no-progress"
# Of a block with k = 7e4 Pa s^(1+gamma), within a percent.
_MEASURED = """\
T,F_max,F_max_error
170,0.003964,3.9e-5
200,0.002875,2.9e-5
240,0.001673,1.7e-5
280,0.000843,8.4e-6
"""
_MAP = """\
model: {gamma: 0}
sweep: {T: {linspace: [230, 300], num: 5}, omega: {linspace: [20, 60], num: 4}}
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
"""


class Writer(NamedTuple):
    """The words of a command, the files that it writes, and how often it is killed."""

    words: str
    writes: str
    kills: int


WRITERS = {
    "fit": Writer(f"fit d.csv --free k=1e4:2e5 -o f.nc {_QUIET}", "f.nc f.yaml f.png f.pdf", 120),
    "boundary": Writer(
        f"boundary map.nc --accuracy 1e-2 -o b.csv {_QUIET}", "b.csv b.columns.csv", 60
    ),
    "simulate": Writer(f"simulate a.yaml --set T=250 -o s.nc {_QUIET}", "s.nc", 60),
    "new": Writer("new n.yaml", "n.yaml", 60),
    "merge": Writer("merge 1.nc 2.nc -o whole.nc", "whole.nc", 100),
    "export": Writer("export 1.nc -o a.csv", "a.csv a.columns.csv", 30),
    "report": Writer(f"report 1.nc --orbits 2 {_QUIET}", "1.html", 30),
    "figure": Writer("plot 1.nc -o a.png", "a.png", 30),
}


def run(quick: bool, folder: Path) -> dict[str, Tally]:
    """Kill each command, half of the times before an operation on its files, and give it again."""
    rng = random.Random(6)
    (folder / "results").mkdir()
    inputs = _results(folder / "results")
    return {
        f"kills of {name}": _kills(folder / name, writer, inputs, rng, 4 if quick else writer.kills)
        for name, writer in WRITERS.items()
    }


def _results(folder: Path) -> list[Path]:
    """Make what the commands read: a config, the two halves of its sweep, a map, measurements."""
    (folder / "a.yaml").write_text(CONFIG)
    (folder / "map.yaml").write_text(_MAP)
    (folder / "d.csv").write_text(_MEASURED)
    halves = [("a.yaml", f"{number}.nc", "--part", f"{number}/2") for number in (1, 2)]
    for config, output, *part in (*halves, ("map.yaml", "map.nc")):
        undisturbed(folder, "sweep", config, "-o", output, *part, _QUIET)
    return sorted([folder / "a.yaml", folder / "d.csv", *folder.glob("*.nc")])


def _kills(
    root: Path, writer: Writer, inputs: Sequence[Path], rng: random.Random, count: int
) -> Tally:
    tally, whole = Tally(), _folder(root / "whole", inputs)
    took, expected = undisturbed(whole, *writer.words.split()), _contents(whole, writer)
    for attempt in range(count if took.operations else 0):
        folder = _folder(root / str(attempt), inputs)
        if attempt % 2:
            number = rng.randint(1, took.operations)
            what = f"killed before operation {number}"
            process = begin(folder, *writer.words.split(), before=armed(number))
        else:
            late = rng.uniform(0.0, 1.1 * took.seconds)
            what, process = f"killed after {late:.3f} s", begin(folder, *writer.words.split())
            time.sleep(late)
            process.kill()
        ended(folder, process)
        verdict, why = _verdict(folder, writer, expected, inputs)
        tally.count(verdict, f"{what}: {why}")
        shutil.rmtree(folder.parent)
    return tally


def _verdict(
    folder: Path, writer: Writer, expected: list[object], inputs: Sequence[Path]
) -> tuple[str, str]:
    """Return what became of a killed command that is given again."""
    begun = _contents(folder, writer)
    if any(has not in (None, whole) for has, whole in zip(begun, expected, strict=True)):
        return "wrong", "half a file has its name"
    again = ended(folder, begin(folder, *writer.words.split()))
    if again.code is None:
        return "hung", again.said[-300:]
    if again.code != 0 or _contents(folder, writer) != expected:
        return "wrong", f"exit code {again.code}: {again.said[-300:]}"
    known = {*(path.name for path in inputs), *writer.writes.split()}
    if left := {path.name for path in folder.iterdir()} - known:
        return "wrong", f"{', '.join(sorted(left))} left over"
    return "survived", ""


def _folder(where: Path, inputs: Sequence[Path]) -> Path:
    folder = where / "work"
    folder.mkdir(parents=True)
    for path in inputs:
        shutil.copy2(path, folder)
    return folder


def _contents(folder: Path, writer: Writer) -> list[object]:
    """Return what the files hold that a command has written, without their times."""
    return [_content(folder / name) for name in writer.writes.split()]


def _content(path: Path) -> object:
    if not path.exists():
        return None
    return content_hash(open_result(path)) if path.suffix == ".nc" else path.read_bytes()
