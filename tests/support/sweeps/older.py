"""Results and journals as other versions would have written them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stickslip.variables import RESULT_COLUMNS
from sweeps.engine.existing import Target, found_in_file
from sweeps.engine.settings import read_config
from sweeps.files.attributes import data_sha256
from sweeps.files.datasets import open_result, write_dataset
from sweeps.files.journal import Journal, readable_manifest
from sweeps.files.record_log import RecordLog
from sweeps.identity import seal_key

FOUR = "sweep: {temperature: [200, 225, 250, 275]}\n"
FIVE = "sweep: {temperature: [200, 225, 250, 275, 300]}\n"
ADDED = ("melting_count", "asymmetry")  # variables that the older version did not know
KNOWN = [name for name in RESULT_COLUMNS if name not in ADDED]
OLDER = "written by an older version and lacks the variables melting_count, asymmetry"
WAYS = (
    "--recompute does so, --accept-mixed keeps them (the new variables stay missing in them), "
    "-o writes elsewhere\n"
)


def make_older(path: Path) -> None:
    """Make of a result what a version without the added variables would have written."""
    ds = open_result(path).drop_vars(ADDED)
    target = Target.of(found_in_file(path).config)
    digests = [hashlib.sha256(ds[name].values.tobytes()).hexdigest() for name in KNOWN]
    ds.attrs["data_sha256"] = data_sha256(seal_key(target.settings, target.grid), digests)
    write_dataset(ds, path)


def make_older_journal(
    path: Path, config: str, known: Sequence[str] = KNOWN, named: bool = True
) -> int:
    """The same of a journal, `named` where it names its columns; the number of its points."""
    target, manifest = Target.of(read_config(config)), readable_manifest(path)
    assert manifest is not None
    size, there = target.grid.size, [RESULT_COLUMNS.index(name) for name in known]
    new = Journal.open(path, manifest, target.chunks, size, readonly=True)
    rows = [(indices, results[:, there]) for indices, results in new.records()]
    new.close()
    log = RecordLog.create(path)
    old = Journal(log, manifest | {"columns": known}, target.chunks, size)
    if named:
        old.note(old.manifest)
    else:
        del manifest["columns"]
        append_manifest(log, manifest)
    for indices, results in rows:
        old.append(indices, results)
    old.close()
    return int(old.done.sum())


def note(log: RecordLog, manifest: dict[str, object]) -> None:
    """Append a manifest that is not of this version, and close."""
    append_manifest(log, manifest)
    log.close()


def append_manifest(log: RecordLog, manifest: dict[str, object]) -> None:
    text = np.frombuffer(json.dumps(manifest).encode(), dtype=np.uint8)
    log.append(b"M", bytes.fromhex(str(manifest["key"])), text)


def everything() -> dict[str, bytes]:
    names = ("heartbeat.json", "lock")
    return {
        str(p): p.read_bytes() for p in Path().rglob("*") if p.is_file() and p.name not in names
    }
