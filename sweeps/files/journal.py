"""The journal of a sweep: its finished points, appended and never changed.

A log whose first record is a manifest (what is computed, as JSON) and whose others are finished
points: their numbers in the grid and their result rows. Each carries the key of the computation
that it belongs to. A journal is read by the numerics version that began it.
"""

from __future__ import annotations

import json
import time
from array import array
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import RESULT_COLUMNS
from sweeps.files.atomic import StorageError, replacing
from sweeps.files.chunks import Chunks
from sweeps.files.columns import STATUS, STATUS_CODES, Rows, status_counts
from sweeps.files.record_log import RecordLog

Indices = NDArray[np.int64]
Manifest = dict[str, Any]

BYTES_PER_POINT = 8 * (1 + len(RESULT_COLUMNS))

_MANIFEST, _ROWS = b"M", b"R"

# A power cut costs what was finished since the last flush; a killed process costs nothing.
_SECONDS_BETWEEN_FLUSHES = 0.5


class Journal:
    """The finished points of one computation on a grid of `size` points.

    `done` (size,) tells which points are there, `statuses` (128,) how many have each status,
    `chunks` how they are cut, `manifest` what they belong to; its key is that of the records.
    """

    def __init__(self, log: RecordLog, manifest: Manifest, chunks: Chunks, size: int) -> None:
        self._log, self._key, self.chunks = log, bytes.fromhex(manifest["key"]), chunks
        self.manifest = manifest
        self.done = np.zeros(size, dtype=bool)
        self.statuses = np.zeros(STATUS_CODES, dtype=np.int64)
        self._chunk, self._offset, self._count = array("q"), array("q"), array("q")
        self._room: Rows | None = None
        self._flushed = time.monotonic()

    @classmethod
    def create(
        cls,
        path: Path,
        manifest: Manifest,
        chunks: Chunks,
        size: int,
        carried: Iterable[tuple[Indices, Rows]] = (),
    ) -> Self:
        """Create a journal that replaces an older one once it holds all `carried` points.

        Raises OSError; then the older one is as it was, or the new one is whole.
        """
        journal = None
        try:
            with replacing(path, path.with_name(path.name + ".new")) as new:
                journal = cls(RecordLog.create(new), manifest, chunks, size)
                journal.note(manifest)
                for indices, rows in carried:
                    journal.append(indices, rows)
            journal._log.path = path
        except BaseException:
            if journal is not None:
                journal.close()
            raise
        return journal

    @classmethod
    def open(
        cls, path: Path, manifest: Manifest, chunks: Chunks, size: int, *, readonly: bool = False
    ) -> Self:
        """Open the journal in a file; unless `readonly`, a torn end is cut off.

        Only records with the key of the manifest count: those of another computation are as good as
        not there. Raises OSError.
        """
        log = RecordLog.open(path, readonly=readonly)
        try:
            journal = cls(log, manifest, chunks, size)
            journal._scan()
            if not readonly:
                log.cut_torn_end()
        except BaseException:
            log.close()
            raise
        return journal

    def close(self) -> None:
        """Close the file; the journal must not be used afterwards."""
        self._log.close()

    @property
    def path(self) -> Path:
        """The file."""
        return self._log.path

    @property
    def damaged(self) -> int:
        """Number of bytes that were skipped when it was opened."""
        return self._log.damaged

    def recover(self) -> int:
        """Keep the records that are still intact, and return how many points were lost.

        Raises OSError.
        """
        before = np.count_nonzero(self.done)
        self.done[:], self.statuses[:] = False, 0
        self._chunk, self._offset, self._count = array("q"), array("q"), array("q")
        manifest, self.manifest = self.manifest, {}
        self._log.begin_again()
        self._scan()
        self._log.cut_torn_end()
        if self.manifest != manifest:
            self.note(manifest)
        return int(before - np.count_nonzero(self.done))

    def note(self, manifest: Manifest) -> None:
        """Record a manifest, which replaces the previous one; raises OSError."""
        text = np.frombuffer(json.dumps(manifest).encode(), np.uint8)
        self._log.append(_MANIFEST, self._key, text)
        self.manifest = manifest

    def append(self, indices: Indices, rows: Rows) -> None:
        """Record finished points: (n,) numbers and (n, columns) rows; earlier records stay valid.

        Raises OSError; then what is noted as done is there, whole.
        """
        if np.isnan(rows[:, STATUS]).any():
            raise ValueError("a row without a status is no finished point")
        fresh = ~self.done[indices]
        order = np.flatnonzero(fresh)[np.argsort(indices[fresh], kind="stable")]
        indices, rows = indices[order].astype("<i8"), rows[order].astype("<f8")
        borders = np.flatnonzero(np.diff(self.chunks.of(indices))) + 1
        for first, last in zip([0, *borders], [*borders, len(indices)], strict=True):
            if last > first:
                part, results = indices[first:last], rows[first:last]
                start = self._log.append(_ROWS, self._key, part, results)
                self._count_in(start, part, results)
        if time.monotonic() - self._flushed >= _SECONDS_BETWEEN_FLUSHES:
            self.flush()

    def flush(self) -> None:
        """Flush everything to disk."""
        self._log.flush()
        self._flushed = time.monotonic()

    def _count_in(self, start: int, indices: Indices, rows: Rows) -> None:
        self.done[indices] = True
        self.statuses += status_counts(rows[:, STATUS])
        self._chunk.append(int(self.chunks.of(indices[:1])[0]))
        self._offset.append(start)
        self._count.append(len(indices))

    def chunk(self, number: int) -> Rows:
        """Return the result rows (n, columns) of a chunk, in order; NaN for points not recorded.

        They are valid until the next call: new memory for each would take longer than filling it.
        Raises DamagedRecordError if a record is no longer what was appended; so does
        `records`.
        """
        begin, end = self.chunks.range(number)
        if self._room is None or len(self._room) < end - begin:
            self._room = np.empty((end - begin, len(RESULT_COLUMNS)))
        found = self._room[: end - begin]
        found.fill(np.nan)
        for record in np.flatnonzero(np.frombuffer(self._chunk, dtype=np.int64) == number):
            indices, rows = self._points(self._offset[record], self._count[record])
            found[indices - begin] = rows
        return found

    def rows(self) -> Rows:
        """Return the result rows (size, columns) of all points; NaN where a point is not there."""
        return np.concatenate([self.chunk(number).copy() for number in range(len(self.chunks))])

    def records(self) -> Iterator[tuple[Indices, Rows]]:
        """Yield all finished points, record by record: (n,) numbers and (n, columns) rows."""
        for start, count in zip(self._offset, self._count, strict=True):
            yield self._points(start, count)

    def _points(self, start: int, count: int) -> tuple[Indices, Rows]:
        length = count * 8 * (1 + len(RESULT_COLUMNS))
        return self._split(self._log.read(start, length, self._key))

    def _split(self, payload: bytes) -> tuple[Indices, Rows]:
        count = len(payload) // (8 * (1 + len(RESULT_COLUMNS)))
        indices = np.frombuffer(payload, "<i8", count)
        rows = np.frombuffer(payload, "<f8", offset=8 * count)
        return indices, rows.reshape(count, len(RESULT_COLUMNS))

    def _scan(self) -> None:
        for record in self._log.scan():
            if record.kind == _MANIFEST:
                self.manifest = json.loads(record.payload)
            elif record.key == self._key:
                indices, rows = self._split(record.payload)
                if not self.done[indices].any():  # a point counts once, as it was recorded first
                    self._count_in(record.start, indices, rows)


def readable_manifest(path: Path) -> Manifest | None:
    """Return the manifest of a journal; None if there is no journal.

    Raises StorageError if it is damaged or was begun by another numerics version, OSError if
    it cannot be read.
    """
    try:
        log = RecordLog.open(path, readonly=True)
    except FileNotFoundError:
        return None
    with closing(log):
        payloads = [record.payload for record in log.scan() if record.kind == _MANIFEST]
    if not payloads:
        raise StorageError(
            f"the beginning of {path} is damaged, so it is unknown which points it holds; move "
            "the file away to keep it, or use --overwrite to start afresh"
        )
    manifest = cast(Manifest, json.loads(payloads[-1]))
    version, columns = manifest.get("numerics_version"), manifest.get("columns")
    if version != NUMERICS_VERSION or columns != list(RESULT_COLUMNS):
        what = "with other result variables"
        if version != NUMERICS_VERSION:
            what = f"numerics version {version}, this is {NUMERICS_VERSION}"
        raise StorageError(
            f"{path} was begun by another version of stickslip ({what}) and cannot be continued; "
            "finish it with that version, or use --overwrite to start afresh"
        )
    return manifest
