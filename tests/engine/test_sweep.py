"""What the engine decides on its way: to ask, to warn, to refuse before anything is computed."""

from __future__ import annotations

import shutil
from collections import namedtuple
from pathlib import Path
from typing import Any

import pytest

from stickslip import Status
from sweeps.config.load import from_mapping
from sweeps.engine import recording
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
    """A console that remembers what was said, and answers."""

    def __init__(self, answer: bool | None = None) -> None:
        self.lines: list[str] = []
        self.asked = 0
        self._answer = answer

    def console(self) -> Console:
        return Console(self.lines.append, None if self._answer is None else self._confirm, False)

    def _confirm(self, _: str) -> bool:
        self.asked += 1
        return bool(self._answer)


def swept(path: Path, heard: Heard, **options: Any) -> Outcome:
    return sweep(from_mapping(CONFIG), path, console=heard.console(), **options)


@pytest.fixture
def hours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is left is worth telling and asking."""
    monkeypatch.setattr(recording, "_TELL_ABOVE", 0.0)
    monkeypatch.setattr(recording, "_ASK_ABOVE", 0.0)


def test_a_long_sweep_asks_and_goes_on(tmp_path: Path, hours: None) -> None:
    heard = Heard(answer=True)
    outcome = swept(tmp_path / "a.nc", heard)
    assert heard.asked == 1
    assert outcome.stopped is None
    assert int(outcome.statuses[Status.OK]) == 40


def test_a_long_sweep_that_is_not_wanted_stops_and_keeps_what_it_has(
    tmp_path: Path, hours: None
) -> None:
    heard = Heard(answer=False)
    outcome = swept(tmp_path / "a.nc", heard)
    assert (heard.asked, outcome.stopped) == (1, 4)
    kept = int(outcome.statuses[Status.OK])
    assert 15 <= kept < 40  # the three blocks that were judged, and those in flight
    assert not (tmp_path / "a.nc").exists()
    again = swept(tmp_path / "a.nc", Heard(answer=True))
    assert again.computed == 40 - kept


def test_nobody_is_asked_where_nobody_can_answer(tmp_path: Path, hours: None) -> None:
    assert swept(tmp_path / "a.nc", Heard(answer=None)).stopped is None


def test_a_short_sweep_does_not_ask(tmp_path: Path) -> None:
    heard = Heard(answer=False)
    assert swept(tmp_path / "a.nc", heard).stopped is None
    assert heard.asked == 0
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
