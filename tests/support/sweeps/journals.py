"""A small journal whose points can be told apart, and what a journal must hold to be sound."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.orbit import failed_row
from stickslip.variables import RESULT_COLUMNS
from sweeps.files.chunks import Chunks
from sweeps.files.columns import STATUS
from sweeps.files.journal import Journal

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
