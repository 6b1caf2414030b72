"""NetCDF files of sweeps, written and read chunk by chunk, with one chunk in memory."""

from __future__ import annotations

import hashlib
import os
import shutil
import socket
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from stickslip.datasets import result_attributes, result_values
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS
from sweeps.files.atomic import begin, left_by_killed, remove, replacing, storage_errors
from sweeps.files.attributes import Place, coordinates, data_sha256, places, seal_key
from sweeps.files.result_rows import STATUS, STATUS_CODES, Chunks, Rows, status_counts
from sweeps.grid import CASE, DIRECTION, Grid

# Level 1 takes half the time of level 4; files are a few percent larger: mantissas are noise.
_COMPRESSION: Mapping[str, Any] = {"compression": "zlib", "complevel": 1, "shuffle": True}

# Bytes per point: 8 for each float and 4 for each count, less the gain of compression. This is for
# stochastic films and motions that never close, of which nearly every number is noise (140 to 158).
# Periodic points of a random sample take 132, and those of a smooth map as few as 95.
RESULT_BYTES_PER_POINT = 160
RESULT_BYTES = 1 << 18  # for its structure and the files beside it
_SEAL = 1 << 11  # for the seal, and what a sweep adds to the attributes

# If the disk fails while the HDF5 library has a file open, the library crashes the process, so
# files up to this size are made and read in memory: in this folder, on systems that have it.
_LARGE = 1 << 25
_MEMORY = "/dev/shm"


@dataclass(frozen=True)
class Written:
    """Summary of a result file: the number of points of each status (128,), and largest errors.

    `statistical_error` is the largest error of aperiodic points (amplitudes averaged over a
    window), `worst_error` that of the others.
    """

    statuses: NDArray[np.int64]
    worst_error: float
    statistical_error: float = np.nan


def write_result(
    grid: Grid,
    chunks: Chunks,
    rows: Callable[[int], Rows],
    statuses: NDArray[np.int64],
    attributes: Mapping[str, str],
    temporary: Path,
    path: Path,
) -> Written:
    """Write a result to `temporary`, read it back, and let it replace an older one.

    `rows` returns the result rows (n, columns) of a chunk; NaN rows become `pending`; `statuses`
    (128,) is the expected number of points of each status. The seal is added to the `attributes`,
    which hold the config.

    Raises StorageError if the file cannot be written or does not read back as written; an older
    file stays as it was.
    """
    with storage_errors(f"cannot write {path}", path.parent), replacing(path, temporary):
        with _new_file(temporary, grid) as file:
            _define(file, grid, chunks, attributes)
            digests = _fill(file, chunks, rows)
            key = seal_key(attributes["config"], places(grid))
            file.data_sha256 = data_sha256(key, digests)
        with open_file(temporary) as file:
            same = seal_key(file.config, coordinates_in(file)) == key
        if not same or digests_of(temporary, chunks) != digests:
            raise OSError("the file does not read back as it was written")
        written = contents(temporary, chunks)
        if not np.array_equal(written.statuses, statuses):
            raise OSError("the file does not hold the points that were written to it")
        return written


def try_writing(grid: Grid, chunks: Chunks, attributes: Mapping[str, str], temporary: Path) -> None:
    """Write a result without its numbers, and remove it, so that errors come before the sweep.

    Raises StorageError.
    """
    with storage_errors(f"cannot write into {temporary.parent}", temporary.parent):
        try:
            begin(temporary)
            with _new_file(temporary, grid) as file:
                _define(file, grid, chunks, attributes)
        finally:
            remove(temporary)


def most_bytes(grid: Grid, chunks: Chunks, attributes: Mapping[str, str]) -> int:
    """Return a size that a result file hardly ever exceeds; nothing is left on the disk.

    Its structure, which depends on the axes and on the length of the config, is written to measure.
    """
    nothing = np.full((1, len(RESULT_COLUMNS)), np.nan)
    with _folder_in_memory(RESULT_BYTES) or tempfile.TemporaryDirectory() as place:
        path = Path(place) / "structure.nc"
        with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
            _define(file, grid, chunks, attributes)
            for column, name in enumerate(RESULT_COLUMNS):  # the first chunk begins an index
                file[name][(0,) * len(grid.dims)] = result_values(name, nothing[:, column])[0]
        return path.stat().st_size + _SEAL + grid.size * RESULT_BYTES_PER_POINT


@contextmanager
def _new_file(path: Path, grid: Grid) -> Iterator[netCDF4.Dataset]:
    """Provide a file to write; a small one is made in memory first."""
    size = grid.size * len(RESULT_COLUMNS) * 8
    in_memory = _folder_in_memory(size + RESULT_BYTES) if size <= _LARGE else None
    with in_memory or nullcontext() as folder:
        place = path if folder is None else Path(folder) / path.name
        with netCDF4.Dataset(place, "w", format="NETCDF4") as file:
            yield file
        if place != path:
            path.write_bytes(place.read_bytes())


def _folder_in_memory(size: int) -> tempfile.TemporaryDirectory[str] | None:
    """Return a folder in memory for files of some bytes; None if there is no room, or no memory.

    Removes those that killed processes of this machine have left.
    """
    if not os.access(_MEMORY, os.W_OK) or shutil.disk_usage(_MEMORY).free < 2 * size:
        return None
    stem = f"stickslip.{socket.gethostname()}."
    for left in left_by_killed(Path(_MEMORY), stem):
        with suppress(OSError):
            if left.lstat().st_uid == os.getuid():
                shutil.rmtree(left)
    return tempfile.TemporaryDirectory(prefix=f"{stem}{os.getpid()}.", dir=_MEMORY)


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
        variable.setncatts(result_attributes(name) | {"coordinates": attached})
    for name, (dims, values, attrs) in along.items():
        if values.dtype.kind == "U":
            variable = file.createVariable(name, str, dims)
        else:
            variable = file.createVariable(name, values.dtype.str[1:], dims, fill_value=False)
        variable.setncatts(attrs)
        variable[...] = values.astype(object) if values.dtype.kind == "U" else values
    whole_chunks(file)


def columns_in(file: netCDF4.Dataset) -> dict[int, str]:
    """Return the result variables in a file by their columns in result rows."""
    names = enumerate(RESULT_COLUMNS)
    return {column: name for column, name in names if name in file.variables}


class Digests:
    """The SHA-256 of each result variable, updated chunk by chunk."""

    def __init__(self, names: Iterable[str]) -> None:
        self._of = {name: hashlib.sha256() for name in names}

    def add(self, name: str, values: NDArray[np.generic]) -> None:
        """Add the next values of a variable."""
        self._of[name].update(values.tobytes())

    def hexadecimal(self) -> list[str]:
        """Return the digest of each variable, in order."""
        return [digest.hexdigest() for digest in self._of.values()]


def _fill(file: netCDF4.Dataset, chunks: Chunks, rows: Callable[[int], Rows]) -> list[str]:
    """Fill the variables and return the SHA-256 of each."""
    columns = columns_in(file)
    digests = Digests(columns.values())
    for number in range(len(chunks)):
        found = rows(number)
        for column, name in columns.items():
            values = result_values(name, found[:, column])
            file[name][chunks.box(number)] = values.reshape(chunks.shape(number))
            digests.add(name, values)
    return digests.hexadecimal()


def open_file(path: Path) -> netCDF4.Dataset:
    """Open a file for reading; a small one is read into memory at once."""
    memory = path.read_bytes() if path.stat().st_size <= _LARGE else None
    return netCDF4.Dataset(path, memory=memory)


def coordinates_in(file: netCDF4.Dataset) -> dict[str, Place]:
    """Return the coordinates of a result file: dimensions and values."""
    file.set_auto_mask(False)
    names = [name for name in (*PARAMETERS, CASE, DIRECTION) if name in file.variables]
    return {name: (file[name].dimensions, _native(file[name][...])) for name in names}


def _native(values: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return values with the dtype of a grid: the library reads strings as objects."""
    return values.astype(np.str_) if values.dtype == object else np.asarray(values)


def whole_chunks(file: netCDF4.Dataset) -> None:
    """Set a result file to be read and written by whole chunks, without masks.

    The library's cache of many chunks would only cost memory.
    """
    file.set_auto_mask(False)
    for name in file.variables.keys() & set(RESULT_COLUMNS):  # a trajectory has none of them
        if file[name].dimensions:
            file[name].set_var_chunk_cache(size=1)


def read_rows(
    file: netCDF4.Dataset, chunks: Chunks, number: int, digests: Digests | None = None
) -> Rows:
    """Return the result rows (n, columns) of a chunk of a result file.

    Pending points, and columns of variables that the file lacks, are NaN. The values read are added
    to `digests`.
    """
    begin, end = chunks.range(number)
    rows = np.full((end - begin, len(RESULT_COLUMNS)), np.nan)
    for place, name in columns_in(file).items():
        values = np.asarray(file[name][chunks.box(number)])
        if digests is not None:
            digests.add(name, values)
        rows[:, place] = values.ravel()
    rows[rows[:, STATUS] == Status.PENDING] = np.nan
    return rows


def contents(path: Path, chunks: Chunks) -> Written:
    """Read a result file chunk by chunk and return its summary; raises StorageError."""
    statuses, worst = np.zeros(STATUS_CODES, dtype=np.int64), np.full(2, np.nan)
    with storage_errors(f"cannot read {path}"), open_file(path) as file:
        whole_chunks(file)
        for number in range(len(chunks)):
            box = chunks.box(number)
            status, errors = (file[name][box].ravel() for name in ("status", "amplitude_error"))
            statuses += status_counts(status)
            never_close = status == Status.APERIODIC
            for kind, points in enumerate((~never_close, never_close)):
                worst[kind] = np.fmax.reduce(errors[points], initial=worst[kind])
    return Written(statuses, *worst.tolist())


def digests_of(path: Path, chunks: Chunks) -> list[str]:
    """Return the SHA-256 of each result variable in a file; raises OSError and RuntimeError."""
    with open_file(path) as file:
        whole_chunks(file)
        names = columns_in(file).values()
        digests = Digests(names)
        for name in names:
            for number in range(len(chunks)):
                digests.add(name, file[name][chunks.box(number)])
        return digests.hexadecimal()
