"""Helpers for tests of whole sweeps: commands in this process, watched and disturbed."""

from __future__ import annotations

import importlib
import itertools
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from stickslip.dispatch import task as worker
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters
from support.sweeps.commands import Result, result_of
from support.sweeps.commands import entries as entries  # handed on
from support.sweeps.processes import HANGS, default_signals
from sweeps.cli.app import main
from sweeps.engine.run import run
from sweeps.engine.signals import Stop
from sweeps.files.netcdf import content_hash, open_result

LOOSE = "integrator: {rtol: 1e-4}\nstationary: {rtol: 1e-4}\n"
_REQUEST = Stop.request

ONE_BY_ONE = "execution: {workers: 1, block_points: 1}\n"


class Shell:
    """The command line in this process, in an empty folder.

    `computed` has the parameters of the points that the last command computed, in order; `disturb`
    is called with the parameters of each block before it is computed.
    """

    def __init__(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        self._monkeypatch, self._capsys = monkeypatch, capsys
        self.computed: list[Parameters] = []
        self.disturb: Callable[[np.ndarray], None] | None = None
        self._heard = threading.Event()
        monkeypatch.chdir(folder)
        monkeypatch.setattr(Stop, "request", lambda *a, **k: self._requested(*a, **k))
        monkeypatch.setattr(worker, "compute_orbits", self._watched)
        monkeypatch.setattr(os, "_exit", sys.exit)  # the end of a sweep that is stopped early

    def __call__(self, *arguments: str) -> Result:
        self.computed.clear()
        return result_of(arguments, self._monkeypatch, self._capsys)

    def ok(self, *arguments: str) -> Result:
        """Run a command that must end with the exit code 0."""
        done = self(*arguments)
        assert done.code == 0, done.err
        return done

    def interrupted(self, *arguments: str, after: int, by: int = signal.SIGTERM) -> Result:
        """Run a command, with a signal during block number `after`, counted from 1."""
        begun = 0

        def send(_: np.ndarray) -> None:
            nonlocal begun
            begun += 1
            if begun == after:
                os.kill(os.getpid(), by)
                assert self._heard.wait(HANGS)  # the main thread, before this block is finished

        self._heard.clear()
        self.disturb = send
        try:
            with default_signals():
                return self(*arguments)
        finally:
            self.disturb = None

    def values(self, name: str) -> list[float]:
        """The values of a parameter at the computed points, in increasing order."""
        return sorted(getattr(point, name) for point in self.computed)

    def _requested(self, stop: Stop, *arguments: Any, **settings: Any) -> None:
        _REQUEST(stop, *arguments, **settings)
        self._heard.set()

    def _watched(self, points: np.ndarray, options: Any, **how: Any) -> Any:
        rows = np.atleast_2d(points)
        if self.disturb is not None:
            self.disturb(rows)
        self.computed += [Parameters(*row) for row in rows.tolist()]
        return compute_orbits(points, options, **how)


def write(name: str, *parts: str) -> str:
    """Write a config of these parts; return its name."""
    Path(name).write_text("".join(parts))
    return name


def everything(but: str = "") -> dict[str, tuple[bytes, int]]:
    """The contents and times of all files in this folder, except those of one name."""
    return {
        str(path): (path.read_bytes(), path.stat().st_mtime_ns)
        for path in Path().rglob("*")
        if path.is_file() and path.name != but
    }


def hash_of(path: str | Path) -> str:
    """The content hash of a result file."""
    return content_hash(open_result(Path(path)))


def hash_at_once(config: str) -> str:
    """The content hash of a config's result, computed at once in memory."""
    return content_hash(run(config, workers=2))


# --- sweeps in other processes, which may die ---

_CHILDREN = multiprocessing.get_context("forkserver")
_CHILDREN.set_forkserver_preload(["sweeps.cli.app", "sweeps.engine.sweep", "sweeps.cli.summaries"])


class Mishap(NamedTuple):
    """A mishap of a process before, after or halfway through a call of a function.

    `number` counts the calls from 1: with `of`, only those with this text in their arguments; with
    `within`, only those made during that call (owner, name, number). The process is killed, or the
    disk of its folder is filled. Only `os.pwrite` can stop halfway.
    """

    owner: str
    name: str
    number: int = 1
    when: str = "before"
    of: str = ""
    kills: bool = True
    within: tuple[str, str, int] | None = None


def child(
    arguments: list[str], *mishaps: Mishap, log: str = "messages", begun: str = ""
) -> multiprocessing.process.BaseProcess:
    """Start a command in a new process in this folder; `log` gets everything that it prints.

    When the process begins to compute its first block, it makes the file `begun`.
    """
    process = _CHILDREN.Process(target=_live, args=(arguments, mishaps, log, begun), daemon=True)
    process.start()
    return process


def _live(arguments: list[str], mishaps: tuple[Mishap, ...], log: str, begun: str) -> None:
    for number in (signal.SIGTERM, signal.SIGHUP):  # which the suite may ignore
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if begun:
        _announce(begun)
    handle = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(handle, 1)
    os.dup2(handle, 2)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    for mishap in mishaps:
        _arrange(mishap)
    sys.argv = ["stickslip", *arguments]
    try:
        main()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()


def _announce(begun: str) -> None:
    def announced(points: np.ndarray, options: Any, **how: Any) -> Any:
        Path(begun).touch()
        return compute_orbits(points, options, **how)

    worker.compute_orbits = announced


def _arrange(mishap: Mishap) -> None:
    owner = _owner(mishap.owner)
    function, calls = getattr(owner, mishap.name), itertools.count(1)
    strike = _die if mishap.kills else fill_the_disk
    is_within = _watch(mishap.within) if mishap.within else lambda: True

    def befallen(*args: Any, **kwargs: Any) -> Any:
        counts = mishap.of in repr((args, kwargs)) and is_within()
        due = counts and next(calls) == mishap.number
        if due and mishap.when == "half":
            handle, data, position = args
            function(handle, bytes(data)[: len(data) // 2], position)
        if due and mishap.when != "after":
            strike()
        result = function(*args, **kwargs)
        if due and mishap.when == "after":
            strike()
        return result

    setattr(owner, mishap.name, befallen)


def _watch(call: tuple[str, str, int]) -> Callable[[], bool]:
    """Watch a function; return whether it is in its call of this number."""
    path, name, number = call
    owner, begun, inside = _owner(path), itertools.count(1), False
    function = getattr(owner, name)

    def watched(*args: Any, **kwargs: Any) -> Any:
        nonlocal inside
        inside = next(begun) == number
        try:
            return function(*args, **kwargs)
        finally:
            inside = False

    setattr(owner, name, watched)
    return lambda: inside


def _owner(path: str) -> Any:
    module, *inside = path.split(":")
    owner = importlib.import_module(module)
    for name in inside:
        owner = getattr(owner, name)
    return owner


def _die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fill_the_disk() -> None:
    """Write `filler` until the disk of this folder is full."""
    with suppress(OSError), Path("filler").open("ab", buffering=0) as file:
        for size in (65536, 4096, 1):
            with suppress(OSError):
                while file.write(bytes(size)):
                    pass
