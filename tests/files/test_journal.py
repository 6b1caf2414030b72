"""The journal: what was appended comes back bit for bit, each point once, under its own key."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest
from support.sweeps.journals import (
    CHUNKS,
    COLUMNS,
    MANIFEST,
    OTHERS,
    ROWS,
    SIZE,
    assert_file,
    assert_sound,
    blocks,
    created,
    only,
    opened,
)

from sweeps.files.atomic import StorageError
from sweeps.files.journal import BYTES_PER_POINT, Journal, readable_manifest


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
    assert path.stat().st_size <= 550 + SIZE * BYTES_PER_POINT + 56 * (SIZE + 1)


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
