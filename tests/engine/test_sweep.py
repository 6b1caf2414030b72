"""Warnings and refusals of a sweep, and files left in its run folder."""

from __future__ import annotations

import shutil
from collections import namedtuple
from pathlib import Path

import pytest

from stickslip.dispatch import task as worker
from sweeps.config.load import from_mapping
from sweeps.engine.existing import Target
from sweeps.engine.sweep import sweep
from sweeps.files.netcdf import StorageError, open_result
from sweeps.files.run_folder import RunFolder

CONFIG = {
    "sweep": {"T": {"linspace": [180, 300], "num": 40}},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "execution": {"block_points": 5},
}


def swept(path: Path) -> list[str]:
    """Compute a sweep; return its messages."""
    lines: list[str] = []
    sweep(from_mapping(CONFIG), path, say=lines.append, progress=False)
    return lines


def test_another_kind_of_processor_is_reported_and_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, kinds = tmp_path / "a.nc", iter(["zen9"] * 3 + ["raptor"] * 99)
    monkeypatch.setattr(worker, "processor", lambda: next(kinds))
    first, *warnings = swept(path)
    assert first == "40 points; 40 to compute"
    assert warnings == [
        "warning: some points were computed on zen9, others are computed on raptor: the last "
        "digits may differ between them"
    ]
    assert open_result(path).attrs["processor"] == "raptor, zen9"


def test_a_disk_without_room_is_reported_before_the_sweep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(10, 10, 1000))
    monkeypatch.setattr(worker, "compute_orbits", lambda *_, **__: pytest.fail("computed"))
    monkeypatch.setattr(Target, "needed", property(lambda _: pytest.fail("took memory")))
    with pytest.raises(
        StorageError, match=r"has 1000 bytes left, but the sweep of 40 points may need 271\.9 KiB"
    ):
        swept(tmp_path / "a.nc")


def test_a_file_system_that_states_no_size_is_not_full(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, 0))
    swept(tmp_path / "a.nc")


def test_leftovers_of_a_killed_run_are_removed(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    folder = RunFolder(path)
    folder.path.mkdir()
    for name in ("result.nc", "merged", "merged.json", "journal.json.new", "heartbeat.json"):
        (folder.path / name).write_bytes(b"half")
    swept(path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.nc"]


def test_a_foreign_file_stays_in_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    folder = RunFolder(path)
    folder.path.mkdir()
    (folder.path / "notes.txt").write_text("mine")
    swept(path)
    assert [entry.name for entry in folder.path.iterdir()] == ["notes.txt"]
