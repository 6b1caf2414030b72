"""The journal returns appended rows bit for bit, each point once, by its key.

No full disk, killed process or damaged byte adds a wrong number or removes a sound record.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.marks import one_then

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.orbit import failed_row
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import from_mapping
from sweeps.exits import StorageError
from sweeps.files.journal import (
    BYTES_PER_POINT,
    DamagedRecordError,
    Journal,
    manifest_path,
    readable_manifest,
)
from sweeps.files.result_rows import STATUS, Chunks
from sweeps.grid import Grid
from sweeps.identity import PointKeys

COLUMNS = len(RESULT_COLUMNS)
SHAPE = (3, 5, 2)
SIZE = 30
CHUNKS = Chunks(SHAPE, most=4)  # several chunks, the last along the second axis a thin one
AXES = {"T": [200, 210, 220], "k": [1e4, 2e4, 3e4, 4e4, 5e4], "K": [2000, 3000]}
MANIFEST = {"numerics_version": NUMERICS_VERSION, "columns": list(RESULT_COLUMNS), "number": 1}


def keys_of(axes: dict[str, Any], **settings: Any) -> PointKeys:
    return PointKeys(Grid.from_config(from_mapping({"sweep": axes})), settings)


KEYS = keys_of(AXES)


def result_rows() -> np.ndarray:
    """Rows that differ for each point and column; some points ended without amplitudes."""
    rows = np.random.default_rng(1).normal(size=(SIZE, COLUMNS))
    rows[:, STATUS] = np.arange(SIZE) % 4 // 3
    rows[5::7] = failed_row()
    rows[2, 0], rows[3, 1] = np.copysign(np.nan, -1.0), -0.0
    return rows


ROWS = result_rows()


def blocks(count: int = 20, seed: int = 2) -> list[np.ndarray]:
    """All points once, distributed at random over blocks; each block is in order."""
    shuffled = np.random.default_rng(seed).permutation(SIZE)
    return [np.sort(part) for part in np.array_split(shuffled, count)]


def created(path: Path, parts: list[np.ndarray]) -> None:
    """A journal with these points, each part a block."""
    journal = Journal.create(path, MANIFEST, KEYS, CHUNKS)
    for part in parts:
        journal.append(part, ROWS[part])
    journal.close()


def opened(path: Path, keys: PointKeys = KEYS, *, readonly: bool = True) -> Journal:
    """The journal in a file."""
    return Journal.open(path, MANIFEST, keys, CHUNKS, readonly=readonly)


def assert_sound(journal: Journal, expected: np.ndarray) -> None:
    """Fail unless the journal has exactly these points, bit for bit."""
    np.testing.assert_array_equal(journal.done, expected)
    assert journal.rows()[expected].tobytes() == ROWS[expected].tobytes()
    statuses = ROWS[expected, STATUS].astype(int)
    np.testing.assert_array_equal(journal.statuses, np.bincount(statuses, minlength=128))
    for number in range(len(CHUNKS)):
        within = slice(*CHUNKS.range(number))
        chunk, there = journal.chunk(number), expected[within]
        assert chunk[there].tobytes() == ROWS[within][there].tobytes()
        assert np.isnan(chunk[~there]).all()


def assert_file(path: Path, expected: np.ndarray) -> None:
    """Fail unless the file, opened now, has exactly these points."""
    journal = opened(path)
    assert_sound(journal, expected)
    journal.close()


def only(*parts: np.ndarray) -> np.ndarray:
    """The mask of these points."""
    mask = np.zeros(SIZE, dtype=bool)
    for part in parts:
        mask[part] = True
    return mask


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("count", [1, 7, 30])
def test_appended_rows_come_back_bit_for_bit_in_any_order(
    path: Path, count: int, seed: int
) -> None:
    created(path, blocks(count, seed))
    for readonly in (True, False):
        journal = opened(path, readonly=readonly)
        assert_sound(journal, only(np.arange(SIZE)))
        assert journal.damaged == 0
        journal.close()
    assert path.stat().st_size == SIZE * BYTES_PER_POINT


def test_an_appended_point_can_be_read_at_once(path: Path) -> None:
    first, second = blocks(2)
    journal = Journal.create(path, MANIFEST, KEYS, CHUNKS)
    assert_sound(journal, only())
    journal.append(first, ROWS[first])
    assert_sound(journal, only(first))
    shuffled = np.random.default_rng(4).permutation(second)
    journal.append(shuffled, ROWS[shuffled])
    assert_sound(journal, only(first, second))
    journal.append(second[:0], ROWS[:0])
    journal.close()
    assert_file(path, only(first, second))


def test_a_point_is_recorded_once(path: Path) -> None:
    created(path, [np.arange(10)])
    journal = opened(path, readonly=False)
    again = np.arange(5, 20)
    rows = ROWS[again]
    rows[:5] = 77.0
    journal.append(again, rows)
    assert_sound(journal, only(np.arange(20)))
    size = path.stat().st_size
    journal.append(again, rows + 1.0)
    assert path.stat().st_size == size
    journal.close()
    # The same records twice, as two writers without a lock would leave them.
    path.write_bytes(path.read_bytes() * 2)
    assert_file(path, only(np.arange(20)))


def test_the_last_record_of_a_point_counts(path: Path) -> None:
    created(path, [np.arange(10)])
    journal = opened(path, readonly=False)
    failed = journal.failures_before(journal.records)
    assert failed.any()
    assert not journal.failures_before(0).any()
    journal.forget(failed)
    assert_sound(journal, only(np.arange(10)) & ~failed)
    better = np.full((np.count_nonzero(failed), COLUMNS), 2.0)
    better[:, STATUS] = Status.OK
    journal.append(np.flatnonzero(failed), better)
    for found in (journal, again := opened(path)):
        assert (found.rows()[failed] == better).all()
        assert found.statuses.sum() == found.done.sum() == 10
        assert not found.failures_before(found.records).any()
    journal.close()
    again.close()


def test_points_are_found_by_their_keys_in_another_grid(path: Path) -> None:
    created(path, blocks(3))
    more = AXES | {"K": [1000, 3000, 2000]}
    grid = Grid.from_config(from_mapping({"sweep": more}))
    journal = Journal.open(path, MANIFEST, keys_of(more), Chunks(grid.shape))
    rows = journal.rows().reshape(*grid.shape, COLUMNS)
    expected = ROWS.reshape(*SHAPE, COLUMNS)
    assert np.isnan(rows[:, :, 0]).all()
    assert rows[:, :, 1].tobytes() == expected[:, :, 1].tobytes()
    assert rows[:, :, 2].tobytes() == expected[:, :, 0].tobytes()
    journal.close()


def test_records_of_other_settings_are_ignored(path: Path) -> None:
    first, second = blocks(2)
    created(path, [first])
    other = opened(path, keys_of(AXES, seed=2), readonly=False)
    assert_sound(other, only())
    other.append(np.arange(SIZE), np.full((SIZE, COLUMNS), 3.0))
    other.close()
    mine = opened(path, readonly=False)
    assert_sound(mine, only(first))
    assert mine.damaged == 0
    mine.append(second, ROWS[second])
    mine.close()
    assert_file(path, only(first, second))


def test_interpolated_points_are_kept_only_in_memory(path: Path) -> None:
    created(path, [np.arange(10)])
    size = path.stat().st_size
    journal = opened(path, readonly=False)
    rows = ROWS[10:].copy()
    rows[:, STATUS] = Status.INTERPOLATED
    shuffled = np.random.default_rng(4).permutation(20)
    journal.append(10 + shuffled, rows[shuffled])
    assert journal.rows()[10:].tobytes() == rows.tobytes()
    assert journal.done.all()
    assert journal.statuses[Status.INTERPOLATED] == 20
    journal.close()
    assert path.stat().st_size == size
    assert_file(path, only(np.arange(10)))


def test_the_last_manifest_counts(path: Path) -> None:
    created(path, [np.arange(3)])
    journal = opened(path, readonly=False)
    journal.note(MANIFEST | {"number": 2})
    journal.append(np.arange(3, 6), ROWS[3:6])
    assert journal.manifest == MANIFEST | {"number": 2}
    journal.close()
    assert readable_manifest(path) == MANIFEST | {"number": 2}
    assert_file(path, only(np.arange(6)))


def test_a_manifest_is_read_whole_or_not_at_all(path: Path) -> None:
    assert readable_manifest(path) is None
    created(path, [np.arange(3)])
    assert readable_manifest(path) == MANIFEST
    beside = manifest_path(path)
    content = beside.read_bytes()
    for place in range(len(content) - 1):  # the last byte ends the line
        damaged = bytearray(content)
        damaged[place] ^= 0x10
        beside.write_bytes(damaged)
        with pytest.raises(StorageError, match="it is unknown which points"):
            readable_manifest(path)
    for length in (0, 10, len(content) - 2):
        beside.write_bytes(content[:length])
        with pytest.raises(StorageError, match="it is unknown which points"):
            readable_manifest(path)
    beside.unlink()
    with pytest.raises(StorageError, match="it is unknown which points"):
        readable_manifest(path)
    assert_file(path, only(np.arange(3)))
    path.write_bytes(b"")  # it was just being created
    assert readable_manifest(path) is None


def test_a_journal_of_an_older_form_is_refused(path: Path) -> None:
    path.write_bytes(b"\x9fslip\r\n\n" + bytes(100))
    with pytest.raises(StorageError, match="begun by another version of stickslip"):
        readable_manifest(path)


def test_reading_changes_nothing(path: Path) -> None:
    created(path, blocks(3))
    path.write_bytes(path.read_bytes()[:-1])
    os.utime(path, ns=(1, 1))
    content = path.read_bytes()
    journal = opened(path)
    whole = only(*blocks(3)) & journal.done
    assert_sound(journal, whole)
    assert 0 < journal.damaged < len(content)
    with pytest.raises(OSError, match=os.strerror(errno.EBADF)):
        journal.append(np.flatnonzero(~whole), ROWS[~whole])
    journal.close()
    assert (path.read_bytes(), path.stat().st_mtime_ns) == (content, 1)


# --- disks and processes that fail ---


def filling_up(room: int) -> Callable[..., int]:
    """A write with room for some bytes, which then reports a full disk."""
    left, write = [room], os.pwrite

    def attempt(handle: int, content: memoryview, position: int) -> int:
        if not left[0]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = write(handle, content[: left[0]], position)
        left[0] -= written
        return written

    return attempt


def test_a_disk_that_is_full_after_any_byte_leaves_the_file_sound(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there, more = np.arange(4), np.arange(4, 6)
    created(path, [there])
    before = path.read_bytes()
    for room in range(2 * BYTES_PER_POINT):
        path.write_bytes(before)
        journal = opened(path, readonly=False)
        with monkeypatch.context() as broken:
            broken.setattr(os, "pwrite", filling_up(room))
            with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
                journal.append(more, ROWS[more])
        assert path.read_bytes() == before
        assert_sound(journal, only(there))
        journal.append(more, ROWS[more])
        assert_sound(journal, only(there, more))
        journal.close()
        assert_file(path, only(there, more))


def test_the_half_record_of_a_killed_process_is_cut_off(path: Path) -> None:
    there, more = np.arange(4), np.arange(4, 6)
    created(path, [there, more])
    content = path.read_bytes()
    for length in range(4 * BYTES_PER_POINT, len(content)):
        path.write_bytes(content[:length])
        journal = opened(path, readonly=False)
        whole = only(np.arange(length // BYTES_PER_POINT))
        assert_sound(journal, whole)
        assert path.stat().st_size == np.count_nonzero(whole) * BYTES_PER_POINT
        journal.append(more, ROWS[more])
        journal.close()
        assert_file(path, only(there, more))


def test_a_write_that_takes_several_calls_is_whole(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = os.pwrite
    monkeypatch.setattr(os, "pwrite", lambda handle, part, at: whole(handle, part[:7], at))
    created(path, blocks(3))
    assert_file(path, only(np.arange(SIZE)))


# --- damage ---


def assert_healed(path: Path, journal: Journal) -> None:
    """Append the missing points; fail unless the file then has all points."""
    missing = ~journal.done
    journal.append(np.flatnonzero(missing), ROWS[missing])
    journal.close()
    assert_file(path, only(np.arange(SIZE)))


# The distance between damaged bytes; `make faults` damages all.
STRIDES = one_then("faults", [29, 1])


@pytest.mark.slow
@pytest.mark.parametrize("stride", STRIDES)
def test_no_damaged_byte_adds_a_wrong_number_or_removes_a_sound_record(
    path: Path, stride: int
) -> None:
    order = np.concatenate(blocks(20))
    created(path, [*order[:, None]])
    content = path.read_bytes()
    flips = np.random.default_rng(3).integers(1, 256, size=len(content))
    for offset in range(0, len(content), stride):
        damaged = bytearray(content)
        damaged[offset] ^= int(flips[offset])
        path.write_bytes(damaged)
        journal = opened(path, readonly=False)
        assert_sound(journal, ~only(order[[offset // BYTES_PER_POINT]]))
        assert journal.damaged == BYTES_PER_POINT
        assert_healed(path, journal)


@pytest.mark.slow
@pytest.mark.parametrize("stride", STRIDES)
def test_a_byte_damaged_while_the_file_is_open_is_noticed(path: Path, stride: int) -> None:
    created(path, [np.arange(SIZE)])
    content = path.read_bytes()
    journal = opened(path, readonly=False)
    for offset in range(0, len(content), stride):
        damaged = bytearray(content)
        damaged[offset] ^= 0x10
        path.write_bytes(damaged)
        ends = [CHUNKS.range(number)[1] for number in range(len(CHUNKS))]
        hit = int(np.searchsorted(ends, offset // BYTES_PER_POINT, side="right"))
        with pytest.raises(DamagedRecordError, match="was damaged while it was in use"):
            journal.chunk(hit)
    assert journal.recover() == 1
    assert_healed(path, journal)


def test_two_exchanged_records_are_noticed(path: Path) -> None:
    created(path, [np.arange(SIZE)])
    content = path.read_bytes()
    journal = opened(path, readonly=False)
    first, second = content[:BYTES_PER_POINT], content[BYTES_PER_POINT : 2 * BYTES_PER_POINT]
    path.write_bytes(second + first + content[2 * BYTES_PER_POINT :])
    with pytest.raises(DamagedRecordError):
        journal.chunk(0)
    assert journal.recover() == 0
    assert_healed(path, journal)


def test_interpolated_points_do_not_count_as_lost(path: Path) -> None:
    created(path, [np.arange(10)])
    rows = ROWS.copy()
    rows[:, STATUS] = Status.INTERPOLATED
    journal = opened(path, readonly=False)
    journal.append(np.arange(10, SIZE), rows[10:])
    path.write_bytes(bytes(BYTES_PER_POINT) + path.read_bytes()[BYTES_PER_POINT:])
    assert journal.recover() == 1
    journal.close()
