"""The journal of a sweep: its finished points, appended and never changed.

It is a file of records of equal size: the key of a point, its result row, and a checksum over both.
A record is valid in every grid that has its key, so nothing is translated when a config grows; of
several records with one key the last sound one counts. A JSON file beside the journal, the
manifest, describes the computation. Only the numerics version that began a journal reads it.

A torn write or a damaged byte costs the record that contains it and no other, and a read never
returns wrong bytes. That holds for every read, not only the first: a file can be damaged while it
is open.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import stat
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.keys import checksums
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.exits import StorageError
from sweeps.files.atomic import begin, replacing
from sweeps.files.result_rows import STATUS, STATUS_CODES, Chunks, Rows, status_counts
from sweeps.identity import PointKeys

Indices = NDArray[np.int64]
Manifest = dict[str, Any]
Records = NDArray[np.uint64]

# A record in words of eight bytes: two for the key, then the row and the checksum.
_KEY, _ROW, _SUM = slice(0, 2), slice(2, -1), -1
_WORDS = 2 + len(RESULT_COLUMNS) + 1
BYTES_PER_POINT = 8 * _WORDS

# The number of records written or read together, which fit into a core's cache; and the largest gap
# between wanted records that is read rather than skipped.
_AT_ONCE, _GAP = 1 << 11, 256

_COPIED = 1 << 20  # bytes copied at a time

SECONDS_BETWEEN_FLUSHES = 0.5
"""A power cut costs the points finished since the last flush; a killed process costs none."""

_OLDER = b"\x9fslip\r\n\n"  # the first bytes of journals in the format of older versions

_ABSENT = -1


class DamagedRecordError(StorageError):
    """A record that differs from the one that was appended."""


class Journal:
    """The finished points of a grid with these `keys`, in a file.

    `done` (size,) flags the points in the journal, `statuses` (128,) counts those of each status,
    `chunks` cuts the grid, and `manifest` describes the computation. `damaged` is the number of
    bytes skipped when the file was opened.

    Interpolated points have no key: they are only kept in memory, and made again after the file is
    opened.
    """

    def __init__(
        self, path: Path, handle: int, manifest: Manifest, keys: PointKeys, chunks: Chunks
    ) -> None:
        self.path, self.manifest, self.chunks = path, manifest, chunks
        self._handle, self._keys = handle, keys
        self._count = 0
        self._room: Rows | None = None
        self._flushed = time.monotonic()
        self._forget_all()

    @classmethod
    def create(cls, path: Path, manifest: Manifest, keys: PointKeys, chunks: Chunks) -> Self:
        """Create a journal without points, replacing an older one; raises OSError."""
        begin(path)
        journal = cls.open(path, manifest, keys, chunks)
        try:
            journal.note(manifest)
        except BaseException:
            journal.close()
            raise
        return journal

    @classmethod
    def open(
        cls,
        path: Path,
        manifest: Manifest,
        keys: PointKeys,
        chunks: Chunks,
        *,
        readonly: bool = False,
    ) -> Self:
        """Open the journal in a file and, unless `readonly`, cut off a torn end.

        Raises OSError.
        """
        journal = cls(path, _opened(path, readonly=readonly), manifest, keys, chunks)
        try:
            journal._scan()
            if not readonly:
                journal._cut()
        except BaseException:
            journal.close()
            raise
        return journal

    def close(self) -> None:
        """Close the file; the journal must not be used afterwards."""
        os.close(self._handle)

    def recover(self) -> int:
        """Keep the records that are still sound, and return how many recorded points were lost.

        Raises OSError.
        """
        before = np.count_nonzero(self.done) - len(self._interpolated[0])
        self._forget_all()
        self._scan()
        self._cut()
        return int(before - np.count_nonzero(self.done))

    def note(self, manifest: Manifest) -> None:
        """Write a manifest in place of the previous one; raises OSError."""
        text = json.dumps(manifest)
        path = manifest_path(self.path)
        path.parent.mkdir(parents=True, exist_ok=True)  # the folder may have been deleted meanwhile
        with replacing(path, path.with_name(f"{path.name}.new"), follow=False) as new:
            new.write_text(f"{_digest(text)}\n{text}\n", encoding="utf-8")
        self.manifest = manifest

    def append(self, indices: Indices, rows: Rows) -> None:
        """Record finished points: (n,) numbers and (n, columns) rows; known points stay.

        Raises OSError; even then all computed points in `done` are completely in the file.
        """
        if np.isnan(rows[:, STATUS]).any():
            raise ValueError("a row without a status is not a finished point")
        fresh = ~self.done[indices]
        order = np.flatnonzero(fresh)[np.argsort(indices[fresh], kind="stable")]
        indices, rows = indices[order], rows[order]
        interpolated = rows[:, STATUS] == Status.INTERPOLATED
        self._write(indices[~interpolated], rows[~interpolated])
        if interpolated.any():
            self._interpolated = indices[interpolated], rows[interpolated]
            self._count_in(*self._interpolated)
        if time.monotonic() - self._flushed >= SECONDS_BETWEEN_FLUSHES:
            self.flush()

    def forget(self, points: NDArray[np.bool_]) -> None:
        """Count points (size,) as missing; records appended later take their place."""
        gone = np.flatnonzero(points & (self._place != _ABSENT))
        for _, rows in self._rows_of(gone):
            self.statuses -= status_counts(rows[:, STATUS])
        self._place[gone], self.done[gone] = _ABSENT, False

    def flush(self) -> None:
        """Flush everything to disk; files deleted in the meantime are made again."""
        if not self.path.exists():
            self._put_back()
        os.fsync(self._handle)
        self._flushed = time.monotonic()

    def chunk(self, number: int) -> Rows:
        """Return the result rows (n, columns) of a chunk, in order; NaN for points not recorded.

        They are valid until the next call, which uses the same memory: allocating it takes longer
        than filling it.
        Raises DamagedRecordError if a record has been damaged.
        """
        first, end = self.chunks.range(number)
        if self._room is None or len(self._room) < end - first:
            self._room = np.empty((end - first, len(RESULT_COLUMNS)))
        found = self._room[: end - first]
        found.fill(np.nan)
        there = np.flatnonzero(self._place[first:end] != _ABSENT)
        for some, rows in self._rows_of(first + there):
            found[there[some]] = rows
        numbers, rows = self._interpolated
        own = slice(*np.searchsorted(numbers, [first, end]))
        found[numbers[own] - first] = rows[own]
        return found

    def rows(self) -> Rows:
        """Return the result rows (size, columns) of all points; NaN for points not recorded."""
        return np.concatenate([self.chunk(number).copy() for number in range(len(self.chunks))])

    def failures_before(self, count: int) -> NDArray[np.bool_]:
        """Return which points (size,) failed according to the first `count` records."""
        failed = np.zeros(len(self.done), dtype=bool)
        early = np.flatnonzero((self._place != _ABSENT) & (self._place < count))
        ok = [status for status in Status if status.is_result]
        for some, rows in self._rows_of(early):
            failed[early[some]] = ~np.isin(rows[:, STATUS], ok)
        return failed

    @property
    def records(self) -> int:
        """The number of records in the file."""
        return self._count

    # --- records ---

    def _write(self, indices: Indices, rows: Rows) -> None:
        """Append the records of points; whatever a failed write leaves behind is cut off."""
        for first in range(0, len(indices), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            records = np.empty((len(indices[part]), _WORDS), np.uint64)
            records[:, _KEY] = self._keys.of(indices[part])
            records.view(np.float64)[:, _ROW] = rows[part]
            records[:, _SUM] = checksums(records)
            written = records.astype("<u8", copy=False).tobytes()
            try:
                _write_all(self._handle, written, self._count * BYTES_PER_POINT)
            except OSError:
                with contextlib.suppress(OSError):
                    self._cut()
                raise
            self._place[indices[part]] = np.arange(self._count, self._count + len(records))
            self._count += len(records)
            self._count_in(indices[part], rows[part])

    def _count_in(self, indices: Indices, rows: Rows) -> None:
        self.done[indices] = True
        self.statuses += status_counts(rows[:, STATUS])

    def _forget_all(self) -> None:
        size = self.chunks.size
        self._place = np.full(size, _ABSENT, dtype=np.int32)
        self.done = np.zeros(size, dtype=bool)
        self.statuses = np.zeros(STATUS_CODES, dtype=np.int64)
        self._interpolated = np.empty(0, np.int64), np.empty((0, len(RESULT_COLUMNS)))
        self.damaged = 0

    def _scan(self) -> None:
        """Find the points in the file; the last record of each counts."""
        length = os.fstat(self._handle).st_size
        self._count, self.damaged = divmod(length, BYTES_PER_POINT)
        status = np.full(len(self.done), Status.PENDING, dtype=np.uint8)
        for first in range(0, self._count, _AT_ONCE):
            records = self._read(first, min(first + _AT_ONCE, self._count))
            sound = _are_sound(records)
            self.damaged += BYTES_PER_POINT * int(np.count_nonzero(~sound))
            places, records = first + np.flatnonzero(sound), records[sound]
            numbers = self._keys.find(records[:, _KEY])
            known = numbers != _ABSENT
            self._place[numbers[known]] = places[known]  # the last record of a number stays
            status[numbers[known]] = records.view(np.float64)[known, _ROW][:, STATUS]
        self.done = status != Status.PENDING
        self.statuses += status_counts(status[self.done])

    def _rows_of(self, numbers: Indices) -> Iterator[tuple[Indices, Rows]]:
        """Yield the rows of points, each time with their positions in `numbers` (n,).

        The points come a few at a time, in the order of the file.
        """
        places = self._place[numbers]
        order = np.argsort(places, kind="stable")
        for first in range(0, len(order), _AT_ONCE):
            some = order[first : first + _AT_ONCE]
            records = self._gathered(places[some])
            same = np.array_equal(records[:, _KEY], self._keys.of(numbers[some]))
            if not (same and _are_sound(records).all()):
                raise DamagedRecordError(
                    f"{self.path} was damaged while it was in use; run the same command again"
                )
            yield some, records.view(np.float64)[:, _ROW]

    def _gathered(self, places: NDArray[np.int32]) -> Records:
        """Return the records (n, words) at increasing places (n,), reading close ones together."""
        borders = np.flatnonzero(np.diff(places) > _GAP) + 1
        stretches = np.split(places, borders)
        found = [self._read(int(each[0]), int(each[-1]) + 1)[each - each[0]] for each in stretches]
        return np.concatenate(found) if len(found) > 1 else found[0]

    def _read(self, first: int, end: int) -> Records:
        """Return the records `first` to `end` - 1; records beyond the end of the file are zeros."""
        room = bytearray((end - first) * BYTES_PER_POINT)
        view, start = memoryview(room), first * BYTES_PER_POINT
        while view and (count := os.preadv(self._handle, [view], start)):
            view, start = view[count:], start + count
        return np.frombuffer(room, "<u8").reshape(-1, _WORDS).astype(np.uint64, copy=False)

    def _cut(self) -> None:
        """Cut the file after its last complete record."""
        os.ftruncate(self._handle, self._count * BYTES_PER_POINT)

    def _put_back(self) -> None:
        """Write the contents of the open file to its path again, and go on with that file."""
        if not manifest_path(self.path).exists():
            self.note(self.manifest)
        end = self._count * BYTES_PER_POINT
        with replacing(self.path) as new:
            handle = os.open(new, os.O_RDWR | os.O_NOFOLLOW)
            try:
                for start in range(0, end, _COPIED):
                    piece = os.pread(self._handle, min(_COPIED, end - start), start)
                    _write_all(handle, piece, start)
            except BaseException:
                os.close(handle)
                raise
        os.close(self._handle)
        self._handle = handle


def manifest_path(path: Path) -> Path:
    """Return the path of a journal's manifest."""
    return path.with_name(f"{path.name}.json")


def readable_manifest(path: Path) -> Manifest | None:
    """Return the manifest of a journal; None if there is no journal.

    Raises StorageError if the manifest is damaged or the journal was begun by another numerics
    version, OSError if it cannot be read.
    """
    try:
        handle = _opened(path, readonly=True)
    except FileNotFoundError:
        return None
    with os.fdopen(handle, "rb") as file:
        head = file.read(len(_OLDER))
    text = _written(manifest_path(path))
    if not (head or text):
        return None  # the journal was just being created
    if head == _OLDER and not text:
        raise _of_another_version(path, "which stored its points in another format")
    digest, _, text = text.partition("\n")
    if _digest(text.rstrip("\n")) != digest:
        raise StorageError(
            f"{manifest_path(path)} is damaged or missing, so it is unknown which points {path} "
            "holds; move both away to keep them, or use --overwrite to start afresh"
        )
    manifest = cast(Manifest, json.loads(text))
    version, columns = manifest.get("numerics_version"), manifest.get("columns")
    if version != NUMERICS_VERSION:
        what = f"numerics version {version}; this one has {NUMERICS_VERSION}"
        raise _of_another_version(path, what)
    if columns != list(RESULT_COLUMNS):
        raise _of_another_version(path, "with different result variables")
    return manifest


def _of_another_version(path: Path, what: str) -> StorageError:
    return StorageError(
        f"{path} was begun by another version of stickslip ({what}) and cannot be continued; "
        "finish it with that version, or use --overwrite to start afresh"
    )


def _written(path: Path) -> str:
    """Return the text of a file, empty if the file is missing or not text."""
    try:
        return path.read_text(encoding="utf-8") if path.is_file() else ""
    except (FileNotFoundError, UnicodeDecodeError):
        return ""


def _opened(path: Path, *, readonly: bool) -> int:
    """Return a handle of an ordinary file; raises OSError and, for other files, StorageError."""
    # Without O_NONBLOCK, opening a pipe would wait for its other end.
    handle = os.open(path, (os.O_RDONLY if readonly else os.O_RDWR) | os.O_NONBLOCK)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise StorageError(f"{path} is not an ordinary file; move it away")
    return handle


def _are_sound(records: Records) -> NDArray[np.bool_]:
    return np.asarray(checksums(records) == records[:, _SUM])


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _write_all(handle: int, data: bytes, position: int) -> None:
    part = memoryview(data)
    while part:
        written = os.pwrite(handle, part, position)
        part, position = part[written:], position + written
