"""A file on which the library hangs or crashes is reported, and harms nobody else."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import netCDF4
import numpy as np
import pytest

from sweeps import watch
from sweeps.exits import StorageError
from sweeps.watch import require_readable

HANGS, DIES = "while True: pass", "import ctypes; ctypes.string_at(1)"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "a file.nc"
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("x", 3)
        file.createVariable("v", "f8", ("x",))[:] = np.arange(3.0)
        file.createVariable("n", "i4", ())[...] = 1
    return path


@contextlib.contextmanager
def interrupted_soon() -> Iterator[None]:
    """Raise KeyboardInterrupt, as Ctrl-C does, in a moment."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture(autouse=True)
def new_reader() -> Iterator[None]:
    watch.stop()
    yield
    watch.stop()


def befalls(monkeypatch: pytest.MonkeyPatch, mishap: str) -> None:
    """Make a mishap befall the reader when it opens a file."""
    opens = "        with netCDF4.Dataset("
    assert opens in watch.READER
    monkeypatch.setattr(watch, "READER", watch.READER.replace(opens, f"        {mishap}\n{opens}"))


def test_a_sound_file_passes_again_and_again(path: Path) -> None:
    for _ in range(3):
        require_readable(path)
    require_readable(path.with_name("absent"))


def test_a_reader_that_was_killed_is_replaced(path: Path) -> None:
    require_readable(path)
    assert watch._reader is not None
    os.killpg(watch._reader.pid, signal.SIGKILL)
    os.waitid(os.P_PID, watch._reader.pid, os.WEXITED | os.WNOWAIT)
    require_readable(path)


def test_a_forked_process_has_a_reader_of_its_own(path: Path) -> None:
    require_readable(path)
    reader = watch._reader
    if (child := os.fork()) == 0:
        require_readable(path)
        os._exit(0 if watch._reader is not reader else 1)
    assert os.waitpid(child, 0)[1] == 0
    require_readable(path)
    assert watch._reader is reader


def test_a_file_that_raises_an_error_passes(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:2000])
    require_readable(path)
    path.write_text("no file at all")
    require_readable(path)


def test_a_file_on_which_the_library_hangs_is_reported(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    befalls(monkeypatch, HANGS)
    monkeypatch.setattr(watch, "SECONDS", 1.0)
    with pytest.raises(StorageError, match="is damaged: it cannot be read completely within 1 s"):
        require_readable(path)


def test_a_file_that_crashes_the_library_is_reported(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    befalls(monkeypatch, DIES)
    with pytest.raises(StorageError, match=f"reading it was ended by signal {int(signal.SIGSEGV)}"):
        require_readable(path)


def test_the_next_file_has_a_reader_again(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as broken:
        befalls(broken, DIES)
        with pytest.raises(StorageError):
            require_readable(path)
    require_readable(path)


def test_an_interrupted_reading_answers_for_no_other_file(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = path.with_name("bad.nc")
    other.write_bytes(path.read_bytes())
    befalls(monkeypatch, f"if path == {os.fsencode(other).hex()!r}: {DIES}")
    require_readable(path)
    assert watch._reader is not None
    os.kill(watch._reader.pid, signal.SIGSTOP)
    with interrupted_soon(), pytest.raises(KeyboardInterrupt):
        require_readable(path)
    if watch._reader is not None:
        os.kill(watch._reader.pid, signal.SIGCONT)
    with pytest.raises(StorageError, match="is damaged"):
        require_readable(other)


def test_a_pipe_is_not_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(StorageError, match="not an ordinary file"):
        require_readable(tmp_path / "pipe")
