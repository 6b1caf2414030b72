"""The journal of a sweep: finished points, appended with checksums and never changed.

One file of records. The first holds a manifest (what is computed, as JSON), the others finished
points: their numbers in the grid and their result rows. Each record carries a checksum and the key
of the computation that it belongs to; a record whose checksum fails is passed over, whatever is
around it is used. So neither a torn write nor a damaged byte can bring a wrong number in, and none
takes a sound record with it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import struct
import time
from array import array
from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from stickslip.variables import RESULT_COLUMNS
from sweeps.files.chunks import Slabs

Indices = NDArray[np.int64]
Rows = NDArray[np.float64]

COLUMNS = len(RESULT_COLUMNS)
BYTES_PER_POINT = 8 * (1 + COLUMNS)

# Begins every record; the bytes above 127 and the line ends show a transfer as text.
_MAGIC = b"\x9fslip\r\n\n"
_HEADER = struct.Struct("<8sQ16sc7x16s")  # magic, length of the payload, key, kind, checksum
_MANIFEST, _ROWS = b"M", b"R"
_CHECKSUM_BYTES = 16
_LONGEST = 1 << 31  # bytes of a payload: a longer one is a damaged length

# A power cut costs what was finished since the last flush; a killed process costs nothing.
_SECONDS_BETWEEN_FLUSHES = 0.5


class _Record(NamedTuple):
    kind: bytes
    key: bytes
    payload: bytes
    end: int


class Journal:
    """The finished points of one computation on a grid of `size` points.

    `done` tells which points are there, `manifest` what the file says it belongs to (None where
    that is unreadable), `damaged` how many bytes were passed over when it was opened.
    """

    def __init__(self, handle: int, key: bytes, slabs: Slabs, size: int) -> None:
        self._handle, self._key, self._slabs = handle, key, slabs
        self.done = np.zeros(size, dtype=bool)
        self.statuses = np.zeros(128, dtype=np.int64)
        self.manifest: dict[str, Any] | None = None
        self.damaged = 0
        self._end = 0
        self._slab, self._offset, self._count = array("q"), array("q"), array("q")
        self._room: Rows | None = None
        self._flushed = time.monotonic()

    # --- making and opening ---

    @classmethod
    def create(
        cls,
        path: Path,
        key: bytes,
        manifest: dict[str, Any],
        slabs: Slabs,
        size: int,
        carried: Iterable[tuple[Indices, Rows]] = (),
    ) -> Self:
        """A new journal, which takes the place of an older one when it has all that is carried.

        Raises OSError; then the older one is as it was, or the new one is whole.
        """
        new = path.with_name(path.name + ".new")
        handle = os.open(new, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o666)
        journal = cls(handle, key, slabs, size)
        try:
            journal.note(manifest)
            for indices, rows in carried:
                journal.append(indices, rows)
            journal.flush()
            new.replace(path)
            flush_folder(path.parent)
        except BaseException:
            journal.close()
            with contextlib.suppress(OSError):
                new.unlink()
            raise
        return journal

    @classmethod
    def open(
        cls, path: Path, key: bytes, slabs: Slabs, size: int, *, readonly: bool = False
    ) -> Self:
        """The journal in a file; to be continued, what is torn off at its end is cut away.

        Only records with this key count: those of another computation are as good as not there.
        """
        journal = cls(os.open(path, os.O_RDONLY if readonly else os.O_RDWR), key, slabs, size)
        try:
            journal._scan()
            if not readonly:
                os.ftruncate(journal._handle, journal._end)
        except BaseException:
            journal.close()
            raise
        return journal

    def close(self) -> None:
        """Close the file; the journal must not be used any more."""
        os.close(self._handle)

    # --- writing ---

    def note(self, manifest: dict[str, Any]) -> None:
        """Record a manifest, which replaces the one before; raises OSError."""
        self._write(_MANIFEST, np.frombuffer(json.dumps(manifest).encode(), np.uint8))
        self.manifest = manifest

    def append(self, indices: Indices, rows: Rows) -> None:
        """Record finished points; those that are there already are left as they are.

        Raises OSError where it cannot be written: what is noted as done is there, whole.
        """
        if np.isnan(rows[:, -1]).any():
            raise ValueError("a row without a status is no finished point")
        fresh = ~self.done[indices]
        order = np.flatnonzero(fresh)[np.argsort(indices[fresh], kind="stable")]
        indices, rows = indices[order].astype("<i8"), rows[order].astype("<f8")
        borders = np.flatnonzero(np.diff(self._slabs.of(indices))) + 1
        for first, last in zip([0, *borders], [*borders, len(indices)], strict=True):
            if last > first:
                part, results = indices[first:last], rows[first:last]
                start = self._write(_ROWS, part, results)
                self._count_in(start, part, results)
        if time.monotonic() - self._flushed >= _SECONDS_BETWEEN_FLUSHES:
            self.flush()

    def flush(self) -> None:
        """Have everything on the disk."""
        os.fsync(self._handle)
        self._flushed = time.monotonic()

    def _write(self, kind: bytes, *arrays: NDArray[Any]) -> int:
        """Append one record; returns where its payload begins."""
        payload = [array.data.cast("B") for array in map(np.ascontiguousarray, arrays)]
        length, start = sum(map(len, payload)), self._end
        header = _HEADER.pack(_MAGIC, length, self._key, kind, _checksum(kind, *payload))
        try:
            _write_all(self._handle, [memoryview(header), *payload], start)
        except OSError:
            with contextlib.suppress(OSError):
                os.ftruncate(self._handle, start)
            raise
        self._end = start + len(header) + length
        return start + len(header)

    def _count_in(self, start: int, indices: Indices, rows: Rows) -> None:
        self.done[indices] = True
        self.statuses += np.bincount(rows[:, -1].astype(np.int64), minlength=128)
        self._slab.append(int(self._slabs.of(indices[:1])[0]))
        self._offset.append(start)
        self._count.append(len(indices))

    # --- reading ---

    def slab(self, number: int) -> Rows:
        """The result rows of a slab, in order; NaN where a point is not there.

        They are valid until the next call: new memory for each would take longer than filling it.
        """
        begin, end = self._slabs.range(number)
        if self._room is None or len(self._room) < end - begin:
            self._room = np.empty((end - begin, COLUMNS))
        found = self._room[: end - begin]
        found.fill(np.nan)
        for record in np.flatnonzero(np.frombuffer(self._slab, dtype=np.int64) == number):
            indices, rows = self._points(self._offset[record], self._count[record])
            found[indices - begin] = rows
        return found

    def records(self) -> Iterator[tuple[Indices, Rows]]:
        """All finished points, record by record."""
        for start, count in zip(self._offset, self._count, strict=True):
            yield self._points(start, count)

    def _points(self, start: int, count: int) -> tuple[Indices, Rows]:
        payload = _read(self._handle, count * BYTES_PER_POINT, start)
        return _split(payload)

    def _scan(self) -> None:
        for record in _records(self._handle):
            self.damaged += record.end - _size(record) - self._end
            self._end = record.end
            if record.kind == _MANIFEST:
                self.manifest = json.loads(record.payload)
            elif record.key == self._key:
                indices, rows = _split(record.payload)
                if not self.done[indices].any():  # a point counts once, as it was recorded first
                    self._count_in(record.end - len(record.payload), indices, rows)
        rest = os.fstat(self._handle).st_size - self._end
        self.damaged += rest


def read_manifest(path: Path) -> dict[str, Any] | None:
    """What a journal says that it belongs to; None where no manifest is sound.

    Raises OSError where there is no such file or it cannot be read.
    """
    handle = os.open(path, os.O_RDONLY)
    try:
        payloads = (record.payload for record in _records(handle) if record.kind == _MANIFEST)
        last = deque(payloads, maxlen=1)
        return json.loads(last[0]) if last else None
    finally:
        os.close(handle)


def flush_folder(path: Path) -> None:
    """Have a folder's entries on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _checksum(kind: bytes, *payload: bytes | memoryview) -> bytes:
    digest = hashlib.sha256(kind)  # processors have instructions for it
    for part in payload:
        digest.update(part)
    return digest.digest()[:_CHECKSUM_BYTES]


def _size(record: _Record) -> int:
    return _HEADER.size + len(record.payload)


def _split(payload: bytes) -> tuple[Indices, Rows]:
    count = len(payload) // BYTES_PER_POINT
    indices = np.frombuffer(payload, "<i8", count)
    return indices, np.frombuffer(payload, "<f8", offset=8 * count).reshape(count, COLUMNS)


def _records(handle: int) -> Iterator[_Record]:
    """The sound records of a file, in order."""
    position: int | None = 0
    while position is not None:
        record = _record_at(handle, position)
        if record is not None:
            yield record
            position = record.end
        else:
            position = _next_magic(handle, position)


def _record_at(handle: int, position: int) -> _Record | None:
    header = _read(handle, _HEADER.size, position)
    if len(header) < _HEADER.size:
        return None
    magic, length, key, kind, checksum = _HEADER.unpack(header)
    if magic != _MAGIC or length > _LONGEST:
        return None
    payload = _read(handle, length, position + _HEADER.size)
    if len(payload) < length or _checksum(kind, payload) != checksum:
        return None
    return _Record(kind, key, payload, position + _HEADER.size + length)


def _next_magic(handle: int, position: int) -> int | None:
    """Where the next record may begin, after a damaged one at `position`."""
    window = 1 << 20
    position += 1
    while piece := _read(handle, window, position):
        found = piece.find(_MAGIC)
        if found >= 0:
            return position + found
        position += max(1, len(piece) - len(_MAGIC) + 1)
    return None


def _read(handle: int, length: int, position: int) -> bytes:
    pieces = []
    while length > 0 and (piece := os.pread(handle, length, position)):
        pieces.append(piece)
        position += len(piece)
        length -= len(piece)
    return b"".join(pieces)


def _write_all(handle: int, parts: list[memoryview], position: int) -> None:
    for part in parts:
        while part:
            written = os.pwrite(handle, part, position)
            part, position = part[written:], position + written
