"""The result file, written in chunks, equals the file of a Dataset or is not written at all."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import netCDF4
import numpy as np
import pytest
from support.marks import one_then
from support.sweeps.writing import write_dataset

from stickslip import Status
from stickslip.orbit import failed_row
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import Config, from_mapping
from sweeps.engine.existing import found_in_file
from sweeps.engine.run import compute, run
from sweeps.exits import StorageError
from sweeps.files import sweep_file
from sweeps.files.attributes import global_attributes
from sweeps.files.netcdf import content_hash, open_result
from sweeps.files.result_rows import STATUS, Chunks, status_counts
from sweeps.files.sweep_file import (
    Written,
    contents,
    most_bytes,
    read_rows,
    try_writing,
    write_result,
)
from sweeps.grid import Grid
from sweeps.identity import settings_of

LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
CASES = {"drive_amplitude": [0.4e-6, 0.8e-6], "angular_frequency": [20, 10]}
SWEEPS: dict[str, dict[str, Any]] = {
    "no axis": LOOSE,
    "one axis": LOOSE | {"sweep": {"T": [200, 220, 250, 300]}},
    "three axes": LOOSE | {"sweep": {"T": [200, 250], "gamma": [-2 / 3, 0], "K": [2e3, 3e3, 4e3]}},
    "cases": LOOSE | {"cases": CASES},
    "an axis and cases": LOOSE | {"title": "with °", "sweep": {"T": [200, 250]}, "cases": CASES},
}
sweeps = pytest.mark.parametrize("config", SWEEPS.values(), ids=SWEEPS)
chunk_sizes = pytest.mark.parametrize("most", one_then("stress", [3, 1, 1000]))


def numbered_rows(size: int) -> np.ndarray:
    """Rows that differ for each point and column."""
    rows = np.arange(size * len(RESULT_COLUMNS), dtype=float).reshape(size, -1) + 1.0
    rows[:, STATUS] = 0
    rows[:, RESULT_COLUMNS.index("regime")] = np.arange(size) % 6  # a byte
    return rows


def write(
    config: Config, results: np.ndarray, path: Path, most: int = 3, **changes: Any
) -> Written:
    grid = Grid.from_config(config)
    chunks = Chunks(grid.shape, most)
    arguments: dict[str, Any] = {
        "rows": lambda number: results[slice(*chunks.range(number))],
        "statuses": status_counts(np.nan_to_num(results[:, STATUS], nan=Status.PENDING)),
        "attributes": global_attributes(config),
        "temporary": path.with_name("result.new"),
    }
    return write_result(grid, chunks, path=path, **arguments | changes)


def described(path: Path) -> dict[str, Any]:
    """Everything in a file except its numbers and how it is stored."""
    with netCDF4.Dataset(path) as file:
        found: dict[str, Any] = {"": {name: file.getncattr(name) for name in file.ncattrs()}}
        found[""].pop("history")
        found["dims"] = {name: len(dimension) for name, dimension in file.dimensions.items()}
        for name, variable in file.variables.items():
            attrs = {key: str(variable.getncattr(key)) for key in variable.ncattrs()}
            attrs["coordinates"] = sorted(attrs.get("coordinates", "").split())
            found[name] = (variable.dimensions, variable.dtype.str, attrs)
    return found


@chunk_sizes
@sweeps
def test_the_file_is_that_of_the_dataset(tmp_path: Path, config: dict[str, Any], most: int) -> None:
    settings = from_mapping(config)
    one, other = tmp_path / "chunks.nc", tmp_path / "dataset.nc"
    rows = compute(settings)
    written = write(settings, rows, one, most)
    ds = run(settings)
    write_dataset(ds, other)
    assert content_hash(open_result(one)) == content_hash(open_result(other)) == content_hash(ds)
    assert described(one) == described(other)
    assert sorted(tmp_path.iterdir()) == [one, other]
    assert written.statuses[Status.OK] == written.statuses.sum() == len(rows)
    assert written.worst_error == ds.amplitude_error.max()


@pytest.mark.parametrize("points", [8, 50])
def test_a_file_of_motions_that_never_close_is_not_larger_than_expected(
    tmp_path: Path, points: int
) -> None:
    axis = {"linspace": [1, 2], "num": points}
    settings = from_mapping({"sweep": {"T": axis, "K": axis}})
    grid, rng = Grid.from_config(settings), np.random.default_rng(1)
    rows = np.exp(1.5 * rng.normal(size=(grid.size, len(RESULT_COLUMNS))))
    of = {name: rows[:, column] for column, name in enumerate(RESULT_COLUMNS)}
    for name in ("melting_count", "periods_integrated"):
        of[name][:] = rng.integers(100, 900, grid.size)
    for name in ("orbit_periods", "solid_transition_count"):
        of[name][:] = 0
    of["status"][:], of["regime"][:] = Status.APERIODIC, Regime.APERIODIC
    of["floquet_multiplier"][:] = np.nan  # they have a Lyapunov exponent instead
    write(settings, rows, tmp_path / "a.nc", grid.size)
    most = most_bytes(grid, Chunks(grid.shape), global_attributes(settings))
    assert 0.9 * most < (tmp_path / "a.nc").stat().st_size <= most


def test_a_large_file_is_the_same_as_a_small_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = from_mapping(SWEEPS["three axes"])
    rows = numbered_rows(Grid.from_config(settings).size)
    small, large = tmp_path / "small.nc", tmp_path / "large.nc"
    write(settings, rows, small)
    # Where nothing can be written into memory every file is left to the library.
    monkeypatch.setattr(os, "access", lambda *_: False)
    write(settings, rows, large)
    assert content_hash(open_result(large)) == content_hash(open_result(small))
    assert described(large) == described(small)


@chunk_sizes
@sweeps
def test_rows_come_back_from_the_file(tmp_path: Path, config: dict[str, Any], most: int) -> None:
    settings = from_mapping(config)
    grid = Grid.from_config(settings)
    rows, chunks = numbered_rows(grid.size), Chunks(grid.shape, most)
    rows[1::5] = failed_row()
    rows[2::5] = np.nan  # not computed
    written = write(settings, rows, tmp_path / "a.nc", most)
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        sweep_file.whole_chunks(file)
        found = np.concatenate([read_rows(file, chunks, number) for number in range(len(chunks))])
        if grid.dims:
            assert file["status"].chunking() == list(chunks.extent)
            assert file["asymmetry"].filters()["zlib"]
    np.testing.assert_array_equal(found, rows)
    codes = np.where(np.isnan(rows[:, STATUS]), Status.PENDING, np.nan_to_num(rows[:, STATUS]))
    np.testing.assert_array_equal(written.statuses, np.bincount(codes.astype(int), minlength=128))
    error = rows[:, RESULT_COLUMNS.index("amplitude_error")]
    assert written.worst_error == np.nanmax(error)
    again = contents(tmp_path / "a.nc", chunks)
    np.testing.assert_array_equal(again.statuses, written.statuses)
    assert again.worst_error == written.worst_error


def test_without_results_there_is_no_worst_error(tmp_path: Path) -> None:
    settings = from_mapping(SWEEPS["one axis"])
    written = write(settings, np.full((4, len(RESULT_COLUMNS)), np.nan), tmp_path / "a.nc")
    assert np.isnan(written.worst_error)
    assert written.statuses[Status.PENDING] == 4
    assert np.isnan(contents(tmp_path / "a.nc", Chunks((4,))).worst_error)
    assert open_result(tmp_path / "a.nc").status.values.tolist() == [127] * 4


def test_errors_of_means_and_of_orbits_are_apart(tmp_path: Path) -> None:
    settings = from_mapping(SWEEPS["one axis"])
    rows, error = numbered_rows(4), RESULT_COLUMNS.index("amplitude_error")
    rows[:, STATUS] = [Status.OK, Status.APERIODIC, Status.APERIODIC, Status.OK]
    rows[:, error] = [1e-8, 0.41, 0.03, 2e-7]
    written = write(settings, rows, tmp_path / "a.nc")
    assert (written.worst_error, written.statistical_error) == (2e-7, 0.41)
    rows[:, STATUS] = Status.APERIODIC
    written = write(settings, rows, tmp_path / "b.nc")
    assert np.isnan(written.worst_error)
    assert written.statistical_error == 0.41


# --- failures ---


def refused(path: Path, **changes: Any) -> str:
    """The reason why a result was not written; an older one is unchanged and alone."""
    path.write_bytes(b"the older result")
    settings = from_mapping(SWEEPS["three axes"])
    with pytest.raises(StorageError) as caught:
        write(settings, numbered_rows(12), path, **changes)
    assert path.read_bytes() == b"the older result"
    assert list(path.parent.iterdir()) == [path]
    return str(caught.value)


@pytest.mark.parametrize(("name", "place"), [("status", 0), ("status", -1), ("asymmetry", 5)])
def test_a_file_that_does_not_read_back_is_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, place: int
) -> None:
    read = sweep_file.digests_of

    def damaged(path: Path, chunks: Chunks) -> list[str]:
        with netCDF4.Dataset(path, "a") as file:
            variable = file[name]
            variable.set_auto_mask(False)
            values = variable[...]
            values.flat[place] += 1
            variable[...] = values
        return read(path, chunks)

    monkeypatch.setattr(sweep_file, "digests_of", damaged)
    assert refused(tmp_path / "a.nc").endswith(
        "a.nc: the file does not read back as it was written"
    )


FULL = OSError(28, "No space left on device")


@pytest.mark.parametrize(
    ("owner", "name", "error", "reason"),
    [
        (netCDF4, "Dataset", PermissionError(13, "Permission denied"), "Permission denied"),
        (sweep_file, "digests_of", FULL, "No space left on device"),
        (os, "fsync", FULL, "No space left on device"),
        (Path, "replace", FULL, "No space left on device"),
    ],
)
def test_a_step_that_fails_leaves_the_older_result_alone(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    owner: Any,
    name: str,
    error: BaseException,
    reason: str,
) -> None:
    monkeypatch.setattr(owner, name, Mock(side_effect=error))
    path = tmp_path / "a.nc"
    assert refused(path) == f"cannot write {path}: {reason}"


@pytest.mark.parametrize(
    "error", [OSError(5, "Input/output error"), RuntimeError("NetCDF: HDF error")]
)
def test_rows_that_cannot_be_read_leave_the_older_result_alone(
    tmp_path: Path, error: Exception
) -> None:
    path = tmp_path / "a.nc"
    reason = getattr(error, "strerror", None) or error
    assert refused(path, rows=Mock(side_effect=error)) == f"cannot write {path}: {reason}"


def test_ctrl_c_leaves_nothing_half_made(tmp_path: Path) -> None:
    settings = from_mapping(SWEEPS["one axis"])
    broken = Mock(side_effect=KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        write(settings, numbered_rows(4), tmp_path / "a.nc", rows=broken)
    assert list(tmp_path.iterdir()) == []


def test_the_trial_leaves_nothing_and_names_an_unwritable_folder(tmp_path: Path) -> None:
    settings = from_mapping(SWEEPS["three axes"])
    grid = Grid.from_config(settings)
    chunks, attributes = Chunks(grid.shape, 3), global_attributes(settings)
    try_writing(grid, chunks, attributes, tmp_path / "result.nc")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(StorageError, match=f"cannot write into {tmp_path / 'missing'}: "):
        try_writing(grid, chunks, attributes, tmp_path / "missing" / "result.nc")


# --- existing files ---


@pytest.mark.parametrize("processor", one_then("stress", ["this, that", ""]))
@sweeps
def test_the_file_of_a_dataset_holds_finished_points(
    tmp_path: Path, config: dict[str, Any], processor: str
) -> None:
    settings = from_mapping(config)
    ds, grid = run(settings), Grid.from_config(settings)
    ds.attrs.pop("processor")  # earlier versions did not say
    if processor:
        ds.attrs["processor"] = processor
    write_dataset(ds, tmp_path / "a.nc")
    found = found_in_file(tmp_path / "a.nc")
    assert found.settings == settings_of(settings)
    assert found.config.resolved_yaml() == settings.resolved_yaml()
    assert found.history == ds.attrs["history"]
    assert found.processors == ({"this", "that"} if processor else set())
    ((indices, rows),) = found.points()
    np.testing.assert_array_equal(indices, np.arange(grid.size))
    assert rows.tobytes() == compute(settings).tobytes()


def test_pending_points_of_a_file_are_not_finished(tmp_path: Path) -> None:
    settings = from_mapping(SWEEPS["three axes"])
    rows = numbered_rows(12)
    rows[[0, 4, 11]] = np.nan
    rows[7] = failed_row()
    write(settings, rows, tmp_path / "a.nc")
    ((indices, found),) = found_in_file(tmp_path / "a.nc").points()
    np.testing.assert_array_equal(indices, [1, 2, 3, 5, 6, 7, 8, 9, 10])
    np.testing.assert_array_equal(found, rows[indices])


def test_an_unreadable_file_has_no_summary(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_bytes(b"no result")
    with pytest.raises(StorageError, match="cannot read"):
        contents(tmp_path / "a.nc", Chunks((4,)))


def test_what_a_killed_process_left_in_memory_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_file, "_MEMORY", str(tmp_path))
    with subprocess.Popen([sys.executable, "-c", ""]) as dead:
        pass
    stem = f"stickslip.{socket.gethostname()}."
    left, alive, other = (
        tmp_path / f"{stem}{name}" for name in (f"{dead.pid}.abc", f"{os.getppid()}.abc", "x.abc")
    )
    for folder in (left, alive, other):
        folder.mkdir()
        (folder / "result.nc").touch()
    settings = from_mapping({})
    write(settings, compute(settings), tmp_path / "a.nc")
    assert sorted(tmp_path.iterdir()) == sorted([alive, other, tmp_path / "a.nc"])


def test_a_full_memory_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=100))
    monkeypatch.setattr(tempfile, "TemporaryDirectory", lambda **_: pytest.fail("in memory"))
    settings = from_mapping({})
    write(settings, compute(settings), tmp_path / "a.nc")
