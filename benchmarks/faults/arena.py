"""A small sweep in a process that faults befall, and a close look; by default it grows a result.

Every fault is followed by the same command without it, which must come to the right end.
"""

from __future__ import annotations

import ctypes
import json
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from multiprocessing import util
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple

from sweeps.engine.existing import found_in_journal
from sweeps.engine.run import run
from sweeps.files.journal import readable_manifest
from sweeps.files.netcdf import content_hash, open_result
from sweeps.files.run_folder import RunFolder

PATIENCE = 90.0
"""Seconds until a command counts as hanging."""

BLOCK, POINTS = 2, 24
CONFIG = f"""\
model: {{gamma: 0}}
sweep: {{T: {{linspace: [150, 320], num: {POINTS}}}}}
integrator: {{rtol: 1e-4}}
stationary: {{rtol: 1e-4}}
execution: {{workers: 1, block_points: {BLOCK}}}
"""
OLDER = "T=[150, 320]"
SWEEP = ("sweep", "a.yaml", "-o", "a.nc", "--no-progress")

# How a command may end that something befell: done, failed points, stopped, storage, killed.
ENDINGS = (0, 3, 4, 5, 130, -9)
# ... or with a word about the config, which could not be read.
_UNREAD = (2, "a.yaml: cannot be read")


@dataclass
class Tally:
    """What became of so many attacks of a kind; `complaints` describes a few that went wrong."""

    tried: int = 0
    survived: int = 0
    lost: int = 0
    wrong: int = 0
    hung: int = 0
    complaints: list[str] = field(default_factory=list)

    def count(self, verdict: str, what: str = "") -> None:
        """Count an attack that ended `survived`, `lost`, `wrong` or `hung`."""
        self.tried += 1
        setattr(self, verdict, getattr(self, verdict) + 1)
        if verdict != "survived" and len(self.complaints) < 10:
            self.complaints.append(f"{verdict}: {what}")


class Ended(NamedTuple):
    """The exit code of a command, None where it hung, and what it said."""

    code: int | None
    said: str


class Undisturbed(NamedTuple):
    """What a command takes that nothing befalls; without a compiler operations are not counted."""

    seconds: float
    operations: int
    allocations: int


# --- processes --------------------------------------------------------------------------------


@cache
def shim() -> str | None:
    """Return the compiled shim; None where there is no compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return None
    library = Path(tempfile.mkdtemp(prefix="faults-")) / "shim.so"
    source = Path(__file__).with_name("shim.c")
    flags = ["-shared", "-fPIC", "-O1", "-w", "-o", str(library), str(source), "-ldl"]
    done = subprocess.run([compiler, *flags], capture_output=True, text=True)
    return str(library) if done.returncode == 0 else None


@cache
def _children() -> Any:
    """Return processes that begin with everything imported and compiled, and with the shim."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["faults.warm"])
    # The server has the path of an interpreter that has just begun.
    here = {"PYTHONPATH": str(Path(__file__).parents[1])}
    here |= {"LD_PRELOAD": library} if (library := shim()) else {}
    before = {name: os.environ.get(name) for name in here}
    os.environ.update(here)
    context.Process(target=_nothing).start()
    for name, value in before.items():
        os.environ.pop(name)
        if value is not None:
            os.environ[name] = value
    return context


def _nothing() -> None:
    pass


def begin(folder: Path, *arguments: str, before: Callable[[], None] | None = None) -> BaseProcess:
    """Start `stickslip ARGUMENTS` in a folder, in a new process that calls `before` first."""
    process = _children().Process(target=_live, args=(folder, arguments, before), daemon=True)
    process.start()
    return process


def _live(folder: Path, arguments: tuple[str, ...], before: Callable[[], None] | None) -> None:
    from sweeps.cli.app import main

    os.environ.pop("LD_PRELOAD", None)
    os.chdir(folder)
    os.setpgid(0, 0)
    speak_into("../said")
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    sys.argv = ["stickslip", *arguments]
    if before is not None:
        before()
    main()


def speak_into(path: str) -> None:
    """Let all that this process says go to a file."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number in (1, 2):
        os.dup2(handle, number)


def sweep_afresh(folder: Path, *more: str, **environment: str) -> subprocess.Popen[bytes]:
    """Start the sweep in an interpreter of its own."""
    said = (folder.parent / "said").open("w")
    return subprocess.Popen(
        [sys.executable, "-m", "sweeps.cli", *SWEEP, *more],
        cwd=folder,
        stdout=said,
        stderr=said,
        start_new_session=True,
        env=os.environ | environment,
    )


def ended(folder: Path, process: BaseProcess | subprocess.Popen[bytes]) -> Ended:
    """Return how a process ended; kill it, and what it has started afresh, where it hangs."""
    if isinstance(process, BaseProcess):
        process.join(PATIENCE)
        code = process.exitcode
        process.kill()
        process.join()
    else:
        try:
            code = process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            code = None
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    log = folder.parent / "said"
    # Killed before its first word there is none.
    return Ended(code, log.read_text(errors="replace") if log.exists() else "")


# --- faults, as what a child calls first ----------------------------------------------------------


def armed(number: int, error: int = 0, *, lasting: bool = False) -> Callable[[], None]:
    """Return what lets that operation fail on a file in the folder, or kills where `error` is 0."""
    return partial(_arm, shim(), number, error, lasting)


def _arm(library: str, number: int, error: int, lasting: bool) -> None:
    place = str(Path.cwd()).encode()
    ctypes.CDLL(library).arm(place, ctypes.c_long(number), error, int(lasting))


def without_memory(number: int, *, lasting: bool = False) -> Callable[[], None]:
    """Return what refuses that piece of memory."""
    return partial(_refuse, shim(), number, lasting)


def _refuse(library: str, number: int, lasting: bool) -> None:
    ctypes.CDLL(library).arm_memory(ctypes.c_long(number), int(lasting))


def _count(library: str) -> None:
    """Count operations on files and pieces of memory, and write both at the end."""
    _arm(library, 10**9, 0, lasting=False)
    _refuse(library, 10**12, lasting=False)
    counted, path = ctypes.CDLL(library), Path.cwd() / "counts"

    def write() -> None:
        path.write_text(f"{counted.operations()} {counted.allocations()}")

    util.Finalize(None, write, exitpriority=1)


def undisturbed(folder: Path, *arguments: str) -> Undisturbed:
    """Return what a command takes that nothing befalls."""
    begun, library = time.monotonic(), shim()
    process = begin(folder, *arguments, before=partial(_count, library) if library else None)
    if (end := ended(folder, process)).code != 0:
        raise RuntimeError(f"fails without a fault: {end.said}")
    seconds, counts = time.monotonic() - begun, folder / "counts"
    if library is None:
        return Undisturbed(seconds, 0, 0)
    operations, allocations = map(int, counts.read_text().split())
    counts.unlink()
    return Undisturbed(seconds, operations, allocations)


# --- the sweep --------------------------------------------------------------------------------


class Arena:
    """Folders in which the same sweep begins again and again.

    It grows an older result where `older` holds the words for that one. `spared` points may be
    computed again though journaled, and it may end in these `endings`. `whole` is what the sweep
    takes that nothing befalls.
    """

    def __init__(
        self,
        folder: Path,
        config: str = CONFIG,
        words: tuple[str, ...] = SWEEP,
        older: tuple[str, ...] = ("--set", OLDER),
        spared: int = 0,
        endings: tuple[int, ...] = ENDINGS,
    ) -> None:
        self.root, self._words, self._number = folder, words, 0
        self._spared, self._endings = spared, endings
        folder.mkdir(exist_ok=True)
        (folder / "a.yaml").write_text(config)
        in_memory = content_hash(run(folder / "a.yaml"))  # which compiles, too
        self.old, self.old_hash, self._older_points = folder / "old" / "a.nc", "", 0
        if older:
            self.old.parent.mkdir()
            shutil.copy(folder / "a.yaml", self.old.parent)
            undisturbed(self.old.parent, *words, *older)
            self.old_hash, self._older_points = _hash(self.old), _computed(self.old)
        with self.folder() as whole:
            self.whole = undisturbed(whole, *words)
            self.expected = _hash(whole / "a.nc")
            self._points = _computed(whole / "a.nc") + self._older_points
        if "--part" not in words and in_memory != self.expected:
            raise RuntimeError("a sweep into a file and one in memory have unlike results")

    @contextmanager
    def folder(self) -> Iterator[Path]:
        """Give a folder with the config and the older result, and take it away at the end."""
        self._number += 1
        folder = self.root / f"{self._number}" / "work"
        folder.mkdir(parents=True)
        shutil.copy(self.root / "a.yaml", folder)
        if self.old_hash:
            shutil.copy(self.old, folder / "a.nc")
        yield folder
        shutil.rmtree(folder.parent)

    def attack(self, tally: Tally, what: str, before: Callable[[], None]) -> None:
        """Run a sweep with a fault, and judge what it left."""
        with self.folder() as folder:
            end = ended(folder, begin(folder, *self._words, before=before))
            self.judge(tally, what, folder, end)

    def kill(self, tally: Tally, rng: random.Random) -> None:
        """Kill a sweep at any time, and judge what it left."""
        late = rng.uniform(0.0, 1.2 * self.whole.seconds)
        with self.folder() as folder:
            process = begin(folder, *self._words)
            time.sleep(late)
            process.kill()
            self.judge(tally, f"killed after {late:.3f} s", folder, ended(folder, process))

    def kill_before_operation(self, tally: Tally, rng: random.Random) -> None:
        """Kill a sweep before any operation on its files, and judge what it left."""
        number = rng.randint(1, self.whole.operations)
        self.attack(tally, f"killed before operation {number}", armed(number))

    def is_right(self, folder: Path) -> bool:
        """Return whether the result there is that of an undisturbed sweep."""
        return _hash(folder / "a.nc") == self.expected

    def judge(self, tally: Tally, what: str, folder: Path, end: Ended) -> None:
        """Count how a sweep ended that something befell, and whether it still comes to its end."""
        verdict, why = self._verdict(folder, end)
        tally.count(verdict, f"{what}: {why}")

    def _verdict(self, folder: Path, end: Ended) -> tuple[str, str]:
        output, hung = folder / "a.nc", end.code is None  # and was killed
        unread = end.code == _UNREAD[0] and _UNREAD[1] in end.said
        if not (hung or end.code in self._endings or unread) or "Traceback" in end.said:
            return "wrong", f"exit code {end.code}: {end.said[-300:]}"
        found = _hash(output) if output.exists() else ""
        if found != self.expected and (end.code == 0 or found != self.old_hash):
            return "wrong", f"another result with exit code {end.code}: {end.said[-300:]}"
        kept = _journaled(output)
        (folder / "a.nc.timing.json").unlink(missing_ok=True)
        again = ended(folder, begin(folder, *self._words))
        if again.code is None:
            return "hung", f"the same command again: {again.said[-300:]}"
        if again.code != 0 or not self.is_right(folder):
            return "wrong", f"the same command again: exit code {again.code}: {again.said[-300:]}"
        most = self._points - max(kept, self._older_points) + self._spared
        if (computed := _computed(output)) > most and found != self.expected:
            return "lost", f"{computed} points computed again, {kept} were in the journal"
        return ("hung", end.said[-300:]) if hung else ("survived", "")


def _hash(output: Path) -> str:
    return content_hash(open_result(output))


def _journaled(output: Path) -> int:
    """Return how many points the journal holds."""
    journal = RunFolder(output).journal
    manifest = readable_manifest(journal)
    if manifest is None:
        return 0
    return sum(len(indices) for indices, _ in found_in_journal(journal, manifest).points())


def _computed(output: Path) -> int:
    """Return how many points the last sweep computed, by the file that tells its time."""
    path = output.with_name(output.name + ".timing.json")
    return int(json.loads(path.read_text())["points"]) if path.exists() else 0
