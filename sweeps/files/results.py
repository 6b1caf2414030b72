"""NetCDF files of sweeps, written and read chunk by chunk, in the memory of one chunk."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS
from sweeps.files.atomic import begin, remove, replacing, storage_errors
from sweeps.files.attributes import (
    Place,
    coordinates,
    data_sha256,
    places,
    seal_key,
    variable_attributes,
)
from sweeps.files.chunks import Chunks
from sweeps.files.columns import STATUS, STATUS_CODES, Rows, result_values, status_counts
from sweeps.grid import CASE, DIRECTION, Grid

# Level 1 takes half the time of level 4 and makes files a few percent larger: mantissas are noise.
_COMPRESSION: Mapping[str, Any] = {"compression": "zlib", "complevel": 1, "shuffle": True}

# A folder in memory, where there is one; bytes of numbers up to which files are made there.
_MEMORY = "/dev/shm"
_LARGE = 1 << 25


@dataclass(frozen=True)
class Written:
    """What a result file holds: how many points of each status (128,), and the largest error."""

    statuses: NDArray[np.int64]
    worst_error: float


def write_result(
    grid: Grid,
    chunks: Chunks,
    rows: Callable[[int], Rows],
    statuses: NDArray[np.int64],
    attributes: Mapping[str, str],
    temporary: Path,
    path: Path,
) -> Written:
    """Write a result to `temporary`, read it back, and put it in place of an older one.

    `rows` gives the result rows (n, columns) of a chunk, of which NaN rows become `pending`;
    `statuses` (128,) says how many points of each status that makes. The seal is added to the
    `attributes`, which hold the config.

    Raises StorageError where the file cannot be written or does not read back as it was meant; an
    older one is as it was.
    """
    with storage_errors(f"cannot write {path}", path.parent), replacing(path, temporary):
        with _new_file(temporary, grid) as file:
            _define(file, grid, chunks, attributes)
            digests = _fill(file, chunks, rows)
            key = seal_key(attributes["config"], places(grid))
            file.data_sha256 = data_sha256(key, digests)
        if _key_in(temporary) != key or digests_of(temporary, chunks) != digests:
            raise OSError("the file does not read back as it was written")
        written = contents(temporary, chunks)
        if not np.array_equal(written.statuses, statuses):
            raise OSError("the file does not hold the points that it is made of")
        return written


def try_writing(grid: Grid, chunks: Chunks, attributes: Mapping[str, str], temporary: Path) -> None:
    """Write a result without its numbers, and take it away again: better before the sweep.

    Raises StorageError.
    """
    with storage_errors(f"cannot write into {temporary.parent}", temporary.parent):
        try:
            begin(temporary)
            with _new_file(temporary, grid) as file:
                _define(file, grid, chunks, attributes)
        finally:
            remove(temporary)


@contextmanager
def _new_file(path: Path, grid: Grid) -> Iterator[netCDF4.Dataset]:
    """A file to be written: in memory first where it is small.

    Where the disk fails while the C library opens a file to write, the library takes the process
    with it. Large files are left to it all the same.
    """
    small = grid.size * len(RESULT_COLUMNS) * 8 <= _LARGE and os.access(_MEMORY, os.W_OK)
    with tempfile.TemporaryDirectory(dir=_MEMORY) if small else nullcontext() as folder:
        place = path if folder is None else Path(folder) / path.name
        with netCDF4.Dataset(place, "w", format="NETCDF4") as file:
            yield file
        if place != path:
            path.write_bytes(place.read_bytes())


def _define(
    file: netCDF4.Dataset, grid: Grid, chunks: Chunks, attributes: Mapping[str, str]
) -> None:
    file.setncatts(attributes)
    for dim, length in zip(grid.dims, grid.shape, strict=True):
        file.createDimension(dim, length)
    along = coordinates(grid)
    attached = " ".join(name for name in along if name not in grid.dims)
    for name in RESULT_COLUMNS:
        dtype = RESULTS[name].dtype
        fill = np.nan if dtype.startswith("f") else False
        packed = {"chunksizes": chunks.extent, **_COMPRESSION} if grid.dims else {}
        variable = file.createVariable(name, dtype, grid.dims, fill_value=fill, **packed)
        variable.setncatts(variable_attributes(name) | {"coordinates": attached})
    for name, (dims, values, attrs) in along.items():
        if values.dtype.kind == "U":
            variable = file.createVariable(name, str, dims)
        else:
            variable = file.createVariable(name, values.dtype.str[1:], dims, fill_value=False)
        variable.setncatts(attrs)
        variable[...] = values.astype(object) if values.dtype.kind == "U" else values
    whole_chunks(file)


class Digests:
    """The SHA-256 of each result variable, of values that come chunk by chunk."""

    def __init__(self, names: Iterable[str]) -> None:
        self._of = {name: hashlib.sha256() for name in names}

    def add(self, name: str, values: NDArray[np.generic]) -> None:
        """Take in the next values of a variable."""
        self._of[name].update(values.tobytes())

    def hexadecimal(self) -> list[str]:
        """One for each variable, in order."""
        return [digest.hexdigest() for digest in self._of.values()]


def _fill(file: netCDF4.Dataset, chunks: Chunks, rows: Callable[[int], Rows]) -> list[str]:
    """Fill the variables; returns the SHA-256 of each."""
    digests = Digests(RESULT_COLUMNS)
    for number in range(len(chunks)):
        found = rows(number)
        for column, name in enumerate(RESULT_COLUMNS):
            values = result_values(name, found[:, column])
            file[name][chunks.box(number)] = values.reshape(chunks.shape(number))
            digests.add(name, values)
    return digests.hexadecimal()


def _key_in(path: Path) -> bytes:
    with netCDF4.Dataset(path) as file:
        return seal_key(file.config, coordinates_in(file))


def coordinates_in(file: netCDF4.Dataset) -> dict[str, Place]:
    """Return the coordinates of a result file: dimensions and values."""
    file.set_auto_mask(False)
    names = [name for name in (*PARAMETERS, CASE, DIRECTION) if name in file.variables]
    return {name: (file[name].dimensions, _native(file[name][...])) for name in names}


def _native(values: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the values as a grid has them: the library reads texts as objects."""
    return values.astype(np.str_) if values.dtype == object else np.asarray(values)


def whole_chunks(file: netCDF4.Dataset) -> None:
    """Have a result file read and written by whole chunks, as they are.

    The library would keep many of them in its cache, which only needs memory.
    """
    file.set_auto_mask(False)
    for name in file.variables.keys() & set(RESULT_COLUMNS):  # a trajectory has none of them
        if file[name].dimensions:
            file[name].set_var_chunk_cache(size=1)


def read_rows(
    file: netCDF4.Dataset, chunks: Chunks, number: int, digests: Digests | None = None
) -> Rows:
    """The result rows (n, columns) of a chunk of a result file; NaN where a point is pending.

    `digests` take in what was read.
    """
    begin, end = chunks.range(number)
    rows = np.empty((end - begin, len(RESULT_COLUMNS)))
    for place, name in enumerate(RESULT_COLUMNS):
        values = np.asarray(file[name][chunks.box(number)])
        if digests is not None:
            digests.add(name, values)
        rows[:, place] = values.ravel()
    rows[rows[:, STATUS] == Status.PENDING] = np.nan
    return rows


def contents(path: Path, chunks: Chunks) -> Written:
    """What a result file holds, read chunk by chunk; raises StorageError."""
    statuses, worst = np.zeros(STATUS_CODES, dtype=np.int64), np.nan
    with storage_errors(f"cannot read {path}"), netCDF4.Dataset(path) as file:
        whole_chunks(file)
        for number in range(len(chunks)):
            box = chunks.box(number)
            statuses += status_counts(file["status"][box])
            worst = np.fmax(worst, np.fmax.reduce(file["amplitude_error"][box].ravel()))
    return Written(statuses, float(worst))


def digests_of(path: Path, chunks: Chunks) -> list[str]:
    """The SHA-256 of each result variable in a file; raises OSError and RuntimeError."""
    with netCDF4.Dataset(path) as file:
        whole_chunks(file)
        digests = Digests(RESULT_COLUMNS)
        for name in RESULT_COLUMNS:
            for number in range(len(chunks)):
                digests.add(name, file[name][chunks.box(number)])
        return digests.hexadecimal()
