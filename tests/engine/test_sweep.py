"""What the engine decides on its way: to ask, to warn, to refuse before anything is computed."""

from __future__ import annotations

import shutil
from collections import namedtuple
from pathlib import Path
from typing import Any

import pytest

from sweeps.config.load import from_mapping
from sweeps.engine.executors import worker
from sweeps.engine.outcome import Console, Outcome
from sweeps.engine.sweep import sweep
from sweeps.files.datasets import StorageError, open_result
from sweeps.files.run_folder import RunFolder

CONFIG = {
    "sweep": {"T": {"linspace": [180, 300], "num": 40}},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "execution": {"block_points": 5},
}


class Heard:
    """A console that remembers what was said."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def console(self) -> Console:
        return Console(self.lines.append, progress=False)


def swept(path: Path, heard: Heard, **options: Any) -> Outcome:
    return sweep(from_mapping(CONFIG), path, console=heard.console(), **options)


def test_a_sweep_says_what_it_has_to_do(tmp_path: Path) -> None:
    heard = Heard()
    assert swept(tmp_path / "a.nc", heard).stopped is None
    assert heard.lines == ["40 points; 40 to compute"]


def test_another_kind_of_processor_is_told_and_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, kinds = tmp_path / "a.nc", iter(["zen9"] * 3 + ["raptor"] * 99)
    monkeypatch.setattr(worker, "processor", lambda: next(kinds))
    heard = Heard()
    swept(path, heard)
    told = [line for line in heard.lines if line.startswith("warning")]
    assert told == [
        "warning: a raptor processor joins points computed on zen9: the last digits may differ "
        "between them"
    ]
    assert open_result(path).attrs["processor"] == "raptor, zen9"


def test_a_disk_without_room_is_told_before_anything_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(10, 10, 1000))
    monkeypatch.setattr(worker, "compute_orbits", lambda *_, **__: pytest.fail("computed"))
    with pytest.raises(
        StorageError, match=r"has 1000 bytes left, but the sweep may need 138\.1 KiB"
    ):
        swept(tmp_path / "a.nc", Heard())


def test_a_finished_sweep_leaves_nothing_beside_its_result(tmp_path: Path) -> None:
    swept(tmp_path / "a.nc", Heard())
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


def test_leftovers_of_a_killed_run_are_taken_away(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    folder = RunFolder(path)
    folder.path.mkdir()
    for name in ("result.nc", "journal.new", "heartbeat.json.new", "heartbeat.json"):
        (folder.path / name).write_bytes(b"half")
    swept(path, Heard())
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.nc"]


def test_a_file_that_is_not_ours_stays_in_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    folder = RunFolder(path)
    folder.path.mkdir()
    (folder.path / "notes.txt").write_text("mine")
    swept(path, Heard())
    assert [entry.name for entry in folder.path.iterdir()] == ["notes.txt"]
