"""One result from several of the same config, such as the parts from an array of jobs."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.keys import checksums
from sweeps.engine.existing import (
    ExistingPoints,
    Part,
    RefusalError,
    Target,
    found_in_input,
)
from sweeps.engine.resume import manifest_of
from sweeps.engine.sweep import JournaledResult, Outcome
from sweeps.exits import StorageError
from sweeps.files.atomic import fingerprint, storage_errors
from sweeps.files.journal import Journal
from sweeps.files.outputs import Outputs
from sweeps.files.result_rows import Rows
from sweeps.files.run_folder import RunFolder
from sweeps.files.sweep_file import contents

Indices = NDArray[np.int64]

_NAMED = 8  # parts that a message lists


def merge(
    inputs: Sequence[Path], output: Path, *, overwrite: bool = False, partial: bool = False
) -> Outcome:
    """Write the points of several results of one config into one result.

    The output is the file that one sweep would have written; points in several files must be equal.
    If the output is that file already, it stays as it is. Besides its journal, the merge needs nine
    bytes of memory per point, and one chunk of a file.

    Raises RefusalError if the files differ in anything but their points, if points are missing and
    `partial` is false, or if the output exists and may not be replaced; StorageError and
    InUseError.
    """
    request = {"merged": [fingerprint(path) for path in inputs], "partial": partial}
    outputs = Outputs([output], request, overwrite=overwrite, inputs=inputs, compares=True)
    with outputs.held():
        sources = [_source(path) for path in inputs]
        target = common_target(sources, inputs[0])
        if not outputs.finished:
            _write(target, sources, outputs, partial=partial)
        return Outcome(output, **vars(contents(output, target.chunks)), complete=outputs.complete)


def _write(
    target: Target, sources: list[ExistingPoints], outputs: Outputs, *, partial: bool
) -> None:
    """Write the points of all sources into the output."""
    folder = outputs.folder
    folder.discard_leftovers()
    manifest = manifest_of(target, folder.output, sources, afresh=True)
    manifest |= {"sample": sources[0].sample}  # the config in a file has the drawn values
    points = _agreeing(sources, target.grid.size)
    with storage_errors(f"cannot write into {folder.path}", folder.path):
        # Not under the name of a sweep's journal: a killed merge is repeated, not resumed.
        journal = Journal.create(folder.merged, manifest, target.keys, target.chunks)
    with closing(journal):
        with storage_errors(f"cannot write into {folder.path}", folder.path):
            for numbers, rows in points:
                journal.append(numbers, rows)
        missing = int(np.count_nonzero(~journal.done))
        if missing and not partial:
            raise RefusalError(
                f"{missing} of {len(journal.done)} points are in none of the files"
                f"{_missing_parts(sources)}; --partial writes the result anyway, with these pending"
            )
        made = JournaledResult(target, journal, folder, None)
        made.write(outputs.place(outputs.main))
    outputs.show()


def _source(path: Path) -> ExistingPoints:
    if not path.exists():
        raise StorageError(RunFolder(path).absence())
    found = found_in_input(path)
    if found.is_fit:
        raise RefusalError(f"{path} holds a fit, not a sweep")
    return found


def common_target(sources: list[ExistingPoints], first: Path) -> Target:
    """Return the target of all sources; raises RefusalError if they have different targets."""
    target = Target.of(sources[0].config)
    if target.config.refine is not None:
        raise RefusalError(
            f"{first} is the result of a refined grid, whose points depend on each other; it has "
            "no parts to merge"
        )
    for found in sources:
        if found.foreign:
            raise RefusalError(
                f"{found.name} has variables that stickslip did not write, which would be lost: "
                f"{', '.join(found.foreign)}"
            )
        if not found.fits(target):
            lines = "\n  ".join(found.differences(target))
            raise RefusalError(
                f"{found.name} was not computed in the same way as {first}:\n  {lines}"
            )
        if found.config.resolved_yaml() != target.config.resolved_yaml():
            raise RefusalError(f"{found.name} is the result of a different config from {first}")
    return target


def _agreeing(sources: list[ExistingPoints], size: int) -> Iterator[tuple[Indices, Rows]]:
    """Yield the points of all sources; raises RefusalError if two disagree about one."""
    done, sums = np.zeros(size, dtype=bool), np.zeros(size, dtype=np.uint64)
    for found in sources:
        for indices, rows in found.points():
            checks = _checksums(rows)
            twice = done[indices]
            if (sums[indices[twice]] != checks[twice]).any():
                raise RefusalError(
                    f"{found.name} has different numbers for points that an earlier file also "
                    "holds; the two were not computed in the same way"
                )
            done[indices], sums[indices] = True, checks
            yield indices, rows


def _checksums(rows: Rows) -> NDArray[np.uint64]:
    """Return the checksum (n,) of each row (n, columns), as in a record without a key."""
    records = np.zeros((len(rows), rows.shape[1] + 3), dtype=np.uint64)
    records[:, 2:-1] = np.where(np.isnan(rows), np.nan, rows).view(np.uint64)  # all NaNs alike
    return checksums(records)


def _missing_parts(sources: list[ExistingPoints]) -> str:
    """Return the missing parts as text; empty if the files are not parts of one array."""
    try:
        parts = {Part.parse(found.part) for found in sources}
    except ValueError:
        return ""
    count = max(part.of for part in parts)
    lacking = [str(part) for n in range(1, count + 1) if (part := Part(n, count)) not in parts]
    if not lacking or any(part.of != count for part in parts):
        return ""
    listed = ", ".join(itertools.islice(lacking, _NAMED)) + (" ..." if lacking[_NAMED:] else "")
    return f" (missing parts: {listed})"
