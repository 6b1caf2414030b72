"""An append-only file of records with checksums; a damaged record is skipped.

A torn write or a damaged byte costs the record that it is in, but no other, and no wrong bytes are
ever returned. That holds for every read, not only the first: a file can be damaged while it is
open.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from sweeps.files.atomic import StorageError, replacing

# Begins every record; the byte above 127 and the line ends reveal a transfer as text.
_MAGIC = b"\x9fslip\r\n\n"
_HEADER = struct.Struct("<8sQ16sc7s16s")  # magic, length of the payload, key, kind, 0, checksum
_PADDING = bytes(7)
_CHECKSUM_BYTES = 16
_LONGEST = 1 << 31  # bytes of a payload: anything longer is a damaged length
_WINDOW = 1 << 20  # bytes that are searched at a time for the next record


class DamagedRecordError(StorageError):
    """A record that is no longer what was appended."""


class Record(NamedTuple):
    """An intact record: a letter for its kind, a key of 16 bytes, the payload and its position."""

    kind: bytes
    key: bytes
    payload: bytes
    start: int


class RecordLog:
    """Records in a file, appended and read; `damaged` counts the bytes skipped on reading."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path = path
        self._handle = handle
        self._end = 0
        self.damaged = 0

    @classmethod
    def create(cls, path: Path) -> Self:
        """Create an empty file; raises OSError."""
        flags = os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW
        return cls(path, os.open(path, flags, 0o666))

    @classmethod
    def open(cls, path: Path, *, readonly: bool = False) -> Self:
        """Open an existing file, to be read by `scan` before appending; raises OSError."""
        # Without O_NONBLOCK, opening a pipe would wait for its other end.
        handle = os.open(path, (os.O_RDONLY if readonly else os.O_RDWR) | os.O_NONBLOCK)
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            os.close(handle)
            raise StorageError(f"{path} is not an ordinary file; move it away")
        return cls(path, handle)

    def close(self) -> None:
        """Close the file; the log must not be used afterwards."""
        os.close(self._handle)

    def flush(self) -> None:
        """Flush everything to disk; a file that was deleted meanwhile is restored."""
        if not self.path.exists():
            self._put_back()
        os.fsync(self._handle)

    def append(self, kind: bytes, key: bytes, *arrays: NDArray[Any]) -> int:
        """Append one record and return where its payload begins; raises OSError.

        A record that cannot be written completely is cut off again.
        """
        payload = [array.data.cast("B") for array in map(np.ascontiguousarray, arrays)]
        length, start = sum(map(len, payload)), self._end
        header = _HEADER.pack(_MAGIC, length, key, kind, _PADDING, _checksum(kind, *payload))
        try:
            _write_all(self._handle, [memoryview(header), *payload], start)
        except OSError:
            with contextlib.suppress(OSError):
                os.ftruncate(self._handle, start)
            raise
        self._end = start + len(header) + length
        return start + len(header)

    def read(self, start: int, length: int, key: bytes) -> bytes:
        """Return the payload that begins at `start`; raises DamagedRecordError.

        The key is the only part of a record that no checksum covers: the caller knows it.
        """
        record = self._record_at(start - _HEADER.size)
        if record is None or len(record.payload) != length or record.key != key:
            raise DamagedRecordError(
                f"{self.path} was damaged while it was in use; give the same command again"
            )
        return record.payload

    def begin_again(self) -> None:
        """Reset, so that `scan` can go through the file once more."""
        self._end = self.damaged = 0

    def scan(self) -> Iterator[Record]:
        """Yield the intact records of the file in order; appending continues after the last one."""
        for record in self._records():
            self.damaged += record.start - _HEADER.size - self._end
            self._end = record.start + len(record.payload)
            yield record
        self.damaged += os.fstat(self._handle).st_size - self._end

    def cut_torn_end(self) -> None:
        """Cut off everything after the last intact record."""
        os.ftruncate(self._handle, self._end)

    def _records(self) -> Iterator[Record]:
        position: int | None = 0
        while position is not None:
            if record := self._record_at(position):
                yield record
                position = record.start + len(record.payload)
            else:
                position = self._next_magic(position)

    def _record_at(self, position: int) -> Record | None:
        header = self._bytes(position, _HEADER.size)
        if len(header) < _HEADER.size:
            return None
        magic, length, key, kind, padding, checksum = _HEADER.unpack(header)
        if magic != _MAGIC or padding != _PADDING or length > _LONGEST:
            return None
        start = position + _HEADER.size
        payload = self._bytes(start, length)
        if len(payload) < length or _checksum(kind, payload) != checksum:
            return None
        return Record(kind, key, payload, start)

    def _bytes(self, start: int, length: int) -> bytes:
        """Return this many bytes of the file, or as many as there are."""
        pieces = []
        while length > 0 and (piece := os.pread(self._handle, length, start)):
            pieces.append(piece)
            start, length = start + len(piece), length - len(piece)
        return b"".join(pieces)

    def _put_back(self) -> None:
        """Write the contents of the open file to its path again, and continue there."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(self.path) as new:
            handle = os.open(new, os.O_RDWR | os.O_NOFOLLOW)
            try:
                for start in range(0, self._end, _WINDOW):
                    piece = self._bytes(start, min(_WINDOW, self._end - start))
                    _write_all(handle, [memoryview(piece)], start)
            except BaseException:
                os.close(handle)
                raise
        os.close(self._handle)
        self._handle = handle

    def _next_magic(self, position: int) -> int | None:
        """Return where the next record may begin, after a damaged one at `position`."""
        position += 1
        while piece := self._bytes(position, _WINDOW):
            found = piece.find(_MAGIC)
            if found >= 0:
                return position + found
            position += max(1, len(piece) - len(_MAGIC) + 1)
        return None


def _checksum(kind: bytes, *payload: bytes | memoryview) -> bytes:
    digest = hashlib.sha256(kind)  # processors have instructions for it
    for part in payload:
        digest.update(part)
    return digest.digest()[:_CHECKSUM_BYTES]


def _write_all(handle: int, parts: list[memoryview], position: int) -> None:
    for part in parts:
        while part:
            written = os.pwrite(handle, part, position)
            part, position = part[written:], position + written
