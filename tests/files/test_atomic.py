"""A file is completely the old one or the new one, and no other file is left beside it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from sweeps.exits import StorageError
from sweeps.files.atomic import flush, replacing, storage_errors


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "a").write_text("old")
    return tmp_path / "a"


def test_the_body_writes_beside_the_file_which_is_then_replaced(path: Path) -> None:
    with replacing(path) as temporary:
        assert temporary.parent == path.parent
        temporary.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(path.parent.iterdir()) == [path]


def test_a_body_that_raises_leaves_the_old_file_and_no_other(path: Path) -> None:
    def body() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        body()
    assert path.read_text() == "old"
    assert list(path.parent.iterdir()) == [path]


def test_files_of_a_killed_process_are_removed_by_the_next(path: Path) -> None:
    killed = subprocess.Popen([sys.executable, "-c", ""])
    killed.wait()
    host = socket.gethostname()
    left, used, others = (
        path.with_name(f".a.{name}.tmp")
        for name in (f"{host}.{killed.pid}", f"{host}.{os.getppid()}", f"elsewhere.{killed.pid}")
    )
    for file in (left, used, others):
        file.write_text("half")
    with replacing(path) as temporary:
        temporary.write_text("new")
    assert sorted(path.parent.iterdir()) == sorted([path, used, others])


@pytest.mark.parametrize("fsync", [False, True])
def test_the_file_is_flushed_before_it_gets_its_name_and_the_folder_after(
    path: Path, monkeypatch: pytest.MonkeyPatch, fsync: bool
) -> None:
    seen: list[tuple[bool, str]] = []

    def noted(handle: int) -> None:
        seen.append((Path(f"/proc/self/fd/{handle}").resolve().is_dir(), path.read_text()))

    monkeypatch.setattr(os, "fsync", noted)
    with replacing(path, path.with_name("new"), fsync=fsync) as temporary:
        temporary.write_text("new")
    assert seen == ([(False, "old"), (True, "new")] if fsync else [])
    assert path.read_text() == "new"


def test_a_missing_file_cannot_be_flushed(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        flush(tmp_path / "absent")


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (OSError(28, "No space left on device", "/a/b"), "cannot write a: No space left on device"),
        (RuntimeError("NetCDF: HDF error"), "cannot write a: NetCDF: HDF error"),
        (StorageError("its own message"), "its own message"),
    ],
)
def test_messages_of_disk_failures_name_the_operation(error: Exception, text: str) -> None:
    with pytest.raises(StorageError) as caught, storage_errors("cannot write a"):
        raise error
    assert str(caught.value) == text


def test_other_errors_pass_through() -> None:
    with pytest.raises(ValueError, match="a bug"), storage_errors("cannot write a"):
        raise ValueError("a bug")
