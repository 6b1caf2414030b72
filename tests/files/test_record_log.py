"""A log of records: what is sound is read, whatever lies around it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sweeps.files.record_log import DamagedRecordError, RecordLog

KEY = b"k" * 16
HEAD = 56  # bytes of a record before its payload
PAYLOADS = [b"first", b"", b"third" * 1000, b"\x9fslip\r\n\n within"]  # the last looks like a head


def bytes_of(text: bytes) -> np.ndarray:
    return np.frombuffer(text, dtype=np.uint8)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    log = RecordLog.create(tmp_path / "log")
    for payload in PAYLOADS:
        log.append(b"P", KEY, bytes_of(payload))
    log.close()
    return tmp_path / "log"


def payloads(path: Path) -> tuple[list[bytes], int]:
    log = RecordLog.open(path, readonly=True)
    found = [record.payload for record in log.scan()]
    log.close()
    return found, log.damaged


def test_records_come_back_in_order(path: Path) -> None:
    assert payloads(path) == (PAYLOADS, 0)


def test_a_payload_of_several_arrays_is_read_where_it_was_written(tmp_path: Path) -> None:
    log = RecordLog.create(tmp_path / "log")
    start = log.append(b"P", KEY, np.arange(3), np.arange(2.0))
    assert log.read(start, 40, KEY) == np.arange(3).tobytes() + np.arange(2.0).tobytes()
    log.close()


@pytest.mark.parametrize("place", range(HEAD))
def test_no_byte_of_a_head_changes_unnoticed_by_who_reads_the_record(
    tmp_path: Path, place: int
) -> None:
    log = RecordLog.create(tmp_path / "log")
    start = log.append(b"P", KEY, np.arange(3))
    with (tmp_path / "log").open("r+b") as file:
        file.seek(place)
        changed = file.read(1)[0] ^ 0x10
        file.seek(place)
        file.write(bytes([changed]))
    with pytest.raises(DamagedRecordError, match="was damaged while it was in use"):
        log.read(start, 24, KEY)
    log.close()
