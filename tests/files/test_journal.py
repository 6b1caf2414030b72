"""The journal: what was appended comes back bit for bit, each point once, under its own key.

No full disk, killed process or damaged byte brings a wrong number in or takes a sound record away.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.marks import one_then

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.orbit import failed_row
from stickslip.variables import RESULT_COLUMNS
from sweeps.files.atomic import StorageError
from sweeps.files.chunks import Chunks
from sweeps.files.columns import STATUS
from sweeps.files.journal import BYTES_PER_POINT, Journal, readable_manifest

COLUMNS = len(RESULT_COLUMNS)
KEY, OTHER = b"k" * 16, b"o" * 16
SHAPE = (3, 5, 2)
SIZE = 30
CHUNKS = Chunks(SHAPE, most=4)  # several chunks, the last along the second axis a thin one
MANIFEST = {
    "key": KEY.hex(),
    "numerics_version": NUMERICS_VERSION,
    "columns": list(RESULT_COLUMNS),
    "number": 1,
}
OTHERS = MANIFEST | {"key": OTHER.hex()}


def result_rows() -> np.ndarray:
    """Rows that tell every point and column apart; some points ended without amplitudes."""
    rows = np.random.default_rng(1).normal(size=(SIZE, COLUMNS))
    rows[:, STATUS] = np.arange(SIZE) % 4 // 3
    rows[5::7] = failed_row()
    rows[2, 0], rows[3, 1] = np.copysign(np.nan, -1.0), -0.0
    return rows


ROWS = result_rows()


def blocks(count: int = 20, seed: int = 2) -> list[np.ndarray]:
    """All points once, dealt out at random; in each block in order."""
    shuffled = np.random.default_rng(seed).permutation(SIZE)
    return [np.sort(part) for part in np.array_split(shuffled, count)]


def created(path: Path, parts: list[np.ndarray]) -> None:
    """A journal with these points, each part a block."""
    journal = Journal.create(path, MANIFEST, CHUNKS, SIZE)
    for part in parts:
        journal.append(part, ROWS[part])
    journal.close()


def opened(path: Path, manifest: dict[str, Any] = MANIFEST, *, readonly: bool = True) -> Journal:
    """The journal in a file."""
    return Journal.open(path, manifest, CHUNKS, SIZE, readonly=readonly)


def recorded(journal: Journal) -> np.ndarray:
    """All rows that a journal has, NaN where it has none; no point comes twice."""
    found, times = np.full((SIZE, COLUMNS), np.nan), np.zeros(SIZE, dtype=int)
    for indices, rows in journal.records():
        found[indices] = rows
        times[indices] += 1
    np.testing.assert_array_equal(times, journal.done)
    return found


def assert_sound(journal: Journal, expected: np.ndarray) -> None:
    """These points are there, bit for bit, and no others."""
    np.testing.assert_array_equal(journal.done, expected)
    assert recorded(journal)[expected].tobytes() == ROWS[expected].tobytes()
    statuses = ROWS[expected, STATUS].astype(int)
    np.testing.assert_array_equal(journal.statuses, np.bincount(statuses, minlength=128))
    for number in range(len(CHUNKS)):
        within = slice(*CHUNKS.range(number))
        chunk, there = journal.chunk(number), expected[within]
        assert chunk[there].tobytes() == ROWS[within][there].tobytes()
        assert np.isnan(chunk[~there]).all()


def assert_file(path: Path, expected: np.ndarray, manifest: dict[str, Any] = MANIFEST) -> None:
    """The same for who opens the file now."""
    journal = opened(path, manifest)
    assert_sound(journal, expected)
    journal.close()


def only(*parts: np.ndarray) -> np.ndarray:
    """Which points these are."""
    mask = np.zeros(SIZE, dtype=bool)
    for part in parts:
        mask[part] = True
    return mask


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("count", [1, 7, 30])
def test_what_is_appended_comes_back_bit_for_bit_in_any_order(
    path: Path, count: int, seed: int
) -> None:
    created(path, blocks(count, seed))
    for readonly in (True, False):
        journal = opened(path, readonly=readonly)
        assert_sound(journal, only(np.arange(SIZE)))
        assert (journal.manifest, journal.damaged) == (MANIFEST, 0)
        journal.close()
    assert path.stat().st_size <= 800 + SIZE * BYTES_PER_POINT + 56 * (SIZE + 1)


def test_an_appended_point_is_there_at_once(path: Path) -> None:
    first, second = blocks(2)
    journal = Journal.create(path, MANIFEST, CHUNKS, SIZE)
    assert_sound(journal, only())
    journal.append(first, ROWS[first])
    assert_sound(journal, only(first))
    shuffled = np.random.default_rng(4).permutation(second)
    journal.append(shuffled, ROWS[shuffled])
    assert_sound(journal, only(first, second))
    chunks = [np.unique(CHUNKS.of(indices)).tolist() for indices, _ in journal.records()]
    assert chunks == [[number] for part in (first, second) for number in np.unique(CHUNKS.of(part))]
    journal.append(second[:0], ROWS[:0])
    journal.close()
    assert_file(path, only(first, second))


def test_a_point_counts_once_and_the_first_one_wins(path: Path) -> None:
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


def test_records_of_another_key_are_as_good_as_not_there(path: Path) -> None:
    first, second = blocks(2)
    created(path, [first])
    other = opened(path, OTHERS, readonly=False)
    assert_sound(other, only())
    other.append(np.arange(SIZE), np.full((SIZE, COLUMNS), 3.0))
    other.close()
    mine = opened(path, readonly=False)
    assert_sound(mine, only(first))
    assert mine.damaged == 0
    mine.append(second, ROWS[second])
    mine.close()
    assert_file(path, only(first, second))


def test_the_last_manifest_counts(path: Path) -> None:
    created(path, [np.arange(3)])
    journal = opened(path, readonly=False)
    journal.note(MANIFEST | {"number": 2})
    journal.append(np.arange(3, 6), ROWS[3:6])
    assert journal.manifest == MANIFEST | {"number": 2}
    journal.close()
    again = opened(path)
    assert again.manifest == MANIFEST | {"number": 2}
    again.close()
    assert_file(path, only(np.arange(6)))


def test_the_manifest_can_be_read_alone(path: Path) -> None:
    assert readable_manifest(path) is None
    created(path, [np.arange(3)])
    assert readable_manifest(path) == MANIFEST
    for content in (b"no journal, but a text that somebody put here\n" * 3, b""):
        path.write_bytes(content)
        with pytest.raises(StorageError, match="it is unknown which points it holds"):
            readable_manifest(path)
    assert_file(path, only())


def test_looking_changes_nothing(path: Path) -> None:
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


def failing(number: int, call: Callable[..., Any]) -> Callable[..., Any]:
    """`call`, but the one with this number, from 0, does half its work and reports a full disk."""
    calls = iter(range(1_000_000))

    def attempt(*args: Any, **settings: Any) -> Any:
        if next(calls) == number:
            if call is os.pwrite:
                handle, content, position = args
                call(handle, content[: len(content) // 2], position)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return call(*args, **settings)

    return attempt


@pytest.mark.parametrize("number", range(6))
def test_a_full_disk_leaves_the_file_sound(
    path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    there, more = np.arange(4), np.arange(4, 10)  # in two chunks: six writes
    created(path, [there])
    before = path.read_bytes()
    journal = opened(path, readonly=False)
    with monkeypatch.context() as broken:
        broken.setattr(os, "pwrite", failing(number, os.pwrite))
        with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
            journal.append(more, ROWS[more])
    assert path.read_bytes() == before or number > 2
    assert path.read_bytes().startswith(before)
    again = opened(path)
    assert again.damaged == 0
    assert_sound(again, journal.done)
    again.close()
    journal.append(more, ROWS[more])
    assert_sound(journal, only(there, more))
    journal.close()
    assert_file(path, only(there, more))


def test_a_write_that_takes_several_calls_is_whole(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = os.pwrite
    monkeypatch.setattr(os, "pwrite", lambda handle, part, at: whole(handle, part[:7], at))
    created(path, blocks(3))
    assert_file(path, only(np.arange(SIZE)))


class Died(BaseException):
    """What no `except Exception` catches."""


def carried(parts: list[np.ndarray], *, die: bool = False) -> Iterator[tuple[np.ndarray, ...]]:
    for part in parts:
        yield part, ROWS[part]
    if die:
        raise Died


@pytest.mark.parametrize(
    ("owner", "name"), [(os, "pwrite"), (os, "fsync"), (os, "open"), (Path, "replace")]
)
def test_a_new_journal_takes_the_place_of_the_old_one_whole_or_not_at_all(
    path: Path, monkeypatch: pytest.MonkeyPatch, owner: Any, name: str
) -> None:
    old, new = only(np.arange(7)), only(np.arange(20))
    for number in range(1000):
        created(path, [np.arange(7)])
        before = path.read_bytes()
        with monkeypatch.context() as broken:
            broken.setattr(owner, name, failing(number, getattr(owner, name)))
            try:
                journal = Journal.create(
                    path, OTHERS, CHUNKS, SIZE, carried(np.array_split(np.arange(20), 4))
                )
            except OSError as error:
                assert error.errno == errno.ENOSPC  # noqa: PT017 - the last round must not raise
            else:
                break
        assert list(path.parent.iterdir()) == [path]
        replaced = path.read_bytes() != before
        # Only the last step, having the folder on the disk, comes after the new one is in place.
        assert not replaced or (name, number) in (("fsync", 1), ("open", 3))
        assert_file(path, new if replaced else old, OTHERS if replaced else MANIFEST)
    assert 0 < number < 1000
    assert_sound(journal, new)
    journal.close()
    assert_file(path, new, OTHERS)


def test_a_source_that_fails_leaves_the_old_journal(path: Path) -> None:
    created(path, [np.arange(7)])
    before = path.read_bytes()
    with pytest.raises(Died):
        Journal.create(path, OTHERS, CHUNKS, SIZE, carried(blocks(3), die=True))
    assert list(path.parent.iterdir()) == [path]
    assert path.read_bytes() == before


# --- damage ---


def numbered_blocks(path: Path) -> tuple[bytes, np.ndarray, list[np.ndarray]]:
    """A journal of 20 records, where each of them ends, and its points; first the manifest's."""
    journal = Journal.create(path, MANIFEST, Chunks((SIZE,)), SIZE)
    ends, parts = [path.stat().st_size], blocks(20)
    for part in parts:
        journal.append(part, ROWS[part])
        ends.append(path.stat().st_size)
    journal.close()
    return path.read_bytes(), np.array(ends), [np.empty(0, dtype=np.int64), *parts]


def assert_healed(path: Path, journal: Journal) -> None:
    """The missing points appended, everything is whole again, also for the next who opens it."""
    missing = ~journal.done
    journal.append(np.flatnonzero(missing), ROWS[missing])
    journal.close()
    journal = Journal.open(path, MANIFEST, Chunks((SIZE,)), SIZE, readonly=True)
    assert recorded(journal).tobytes() == ROWS.tobytes()
    assert journal.chunk(0).tobytes() == ROWS.tobytes()
    journal.close()


# Every so many bytes; all of them in the long run.
STRIDES = one_then("faults", [7, 1])


@pytest.mark.slow
@pytest.mark.parametrize("stride", STRIDES)
def test_no_damaged_byte_brings_in_a_wrong_number_or_takes_a_sound_record_away(
    path: Path, stride: int
) -> None:
    content, ends, parts = numbered_blocks(path)
    flips = np.random.default_rng(3).integers(1, 256, size=len(content))
    for offset in range(0, len(content), stride):
        damaged = bytearray(content)
        damaged[offset] ^= int(flips[offset])
        path.write_bytes(damaged)
        journal = Journal.open(path, MANIFEST, Chunks((SIZE,)), SIZE)
        hit = int(np.searchsorted(ends, offset, side="right"))
        there = journal.done.copy()
        assert recorded(journal)[there].tobytes() == ROWS[there].tobytes()
        there[parts[hit]] = True
        assert there.all()
        assert journal.manifest == MANIFEST
        assert_healed(path, journal)


@pytest.mark.slow
@pytest.mark.parametrize("stride", STRIDES)
def test_a_torn_tail_costs_its_own_record_wherever_it_is_torn(path: Path, stride: int) -> None:
    content, ends, parts = numbered_blocks(path)
    for length in range(0, len(content), stride):
        path.write_bytes(content[:length])
        journal = Journal.open(path, MANIFEST, Chunks((SIZE,)), SIZE)
        whole = int(np.searchsorted(ends, length, side="right"))
        expected = only(*parts[:whole])
        np.testing.assert_array_equal(journal.done, expected)
        assert recorded(journal)[expected].tobytes() == ROWS[expected].tobytes()
        kept = int(ends[whole - 1]) if whole else 0
        assert journal.damaged == length - kept
        assert path.stat().st_size == kept
        assert_healed(path, journal)


def test_sound_records_are_found_behind_any_length_of_rubbish(path: Path) -> None:
    first, second = blocks(2)
    created(path, [first])
    content = path.read_bytes()
    journal = opened(path, readonly=False)
    journal.append(second, ROWS[second])
    journal.close()
    tail = path.read_bytes()[len(content) :]
    for length in (1, 55, 57, *range((1 << 20) - 9, (1 << 20) + 9)):  # read a mebibyte at a time
        path.write_bytes(content + b"\x9f" * length + tail)
        journal = opened(path)
        assert_sound(journal, only(first, second))
        assert journal.damaged == length
        journal.close()
