"""From the journal to the result file, slab by slab: memory for one slab, whatever the size."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from stickslip.variables import RESULT_COLUMNS
from sweeps.files.attributes import coordinates, data_sha256, result_values, variable_attributes
from sweeps.files.chunks import Slabs
from sweeps.files.datasets import StorageError, put_in_place
from sweeps.grid import Grid

Rows = NDArray[np.float64]

# Level 1 takes half the time of level 4 and makes files a few percent larger: mantissas are noise.
_COMPRESSION: Mapping[str, Any] = {"compression": "zlib", "complevel": 1, "shuffle": True}


@dataclass(frozen=True)
class Written:
    """What a result file holds: how many points of each status, and the largest error."""

    statuses: NDArray[np.int64]
    worst_error: float


def write_result(
    grid: Grid,
    key: bytes,
    slabs: Slabs,
    rows: Callable[[int], Rows],
    attributes: Mapping[str, str],
    temporary: Path,
    path: Path,
) -> Written:
    """Write a result, read it back, and put it in place of an older one.

    Parameters
    ----------
    key
        `identity.seal_key` of what was computed.
    rows
        Gives the result rows (n, 13) of a slab; NaN rows become `pending`.
    attributes
        The global attributes.
    temporary
        Where the file is made, on the file system of `path`.

    Raises
    ------
    StorageError
        The file cannot be written or does not read back as it was meant; an older one is as it
        was.
    """
    try:
        with netCDF4.Dataset(temporary, "w", format="NETCDF4") as file:
            _define(file, grid, slabs, attributes)
            statuses, worst, digests = _fill(file, slabs, rows)
            file.data_sha256 = data_sha256(key, digests)
        if _digests(temporary, slabs) != digests:
            raise OSError("the file does not read back as it was written")
        put_in_place(temporary, path)
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:  # HDF5 reports a full disk as RuntimeError
        reason = getattr(error, "strerror", None) or error
        raise StorageError(f"cannot write {path}: {reason}") from error
    finally:
        temporary.unlink(missing_ok=True)
    return Written(statuses, worst)


def try_writing(grid: Grid, slabs: Slabs, attributes: Mapping[str, str], temporary: Path) -> None:
    """Write a result without its numbers, and take it away again: better before the sweep.

    Raises StorageError.
    """
    try:
        with netCDF4.Dataset(temporary, "w", format="NETCDF4") as file:
            _define(file, grid, slabs, attributes)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise StorageError(f"cannot write into {temporary.parent}: {reason}") from error
    finally:
        temporary.unlink(missing_ok=True)


def whole_chunks(file: netCDF4.Dataset) -> None:
    """Have a result file read and written by whole slabs, as they are.

    A slab is a chunk of the file; the library would keep many of them, which only needs memory.
    """
    file.set_auto_mask(False)
    for name in RESULT_COLUMNS:
        if file[name].dimensions:
            file[name].set_var_chunk_cache(size=1)


def read_rows(file: netCDF4.Dataset, slabs: Slabs, number: int) -> Rows:
    """The result rows (n, 13) of a slab of a result file; NaN where the status is pending."""
    begin, end = slabs.range(number)
    rows = np.empty((end - begin, len(RESULT_COLUMNS)))
    for column, name in enumerate(RESULT_COLUMNS):
        rows[:, column] = np.asarray(file[name][slabs.box(number)], dtype=float).ravel()
    rows[rows[:, -1] == 127] = np.nan
    return rows


def contents(path: Path, slabs: Slabs) -> Written:
    """What a result file holds, read slab by slab; raises StorageError."""
    statuses, worst = np.zeros(128, dtype=np.int64), np.nan
    try:
        with netCDF4.Dataset(path) as file:
            whole_chunks(file)
            for number in range(len(slabs)):
                box = slabs.box(number)
                statuses += np.bincount(file["status"][box].ravel(), minlength=128)
                worst = np.fmax(worst, np.fmax.reduce(file["amplitude_error"][box].ravel()))
    except (OSError, RuntimeError) as error:
        raise StorageError(f"{path} cannot be read: {error}") from error
    return Written(statuses, float(worst))


def _define(file: netCDF4.Dataset, grid: Grid, slabs: Slabs, attributes: Mapping[str, str]) -> None:
    file.setncatts(attributes)
    for dim, length in zip(grid.dims, grid.shape, strict=True):
        file.createDimension(dim, length)
    along = coordinates(grid)
    attached = " ".join(name for name in along if name not in grid.dims)
    for name in RESULT_COLUMNS:
        values = result_values(name, np.empty(0))
        real = values.dtype.kind == "f"
        settings: dict[str, Any] = {"fill_value": np.nan if real else False}
        if grid.dims:
            settings |= {"chunksizes": slabs.chunk, **_COMPRESSION}
        variable = file.createVariable(name, values.dtype.str[1:], grid.dims, **settings)
        variable.setncatts(variable_attributes(name) | {"coordinates": attached})
    for name, (dims, values, attrs) in along.items():
        variable = file.createVariable(name, values.dtype.str[1:], dims, fill_value=False)
        variable.setncatts(attrs)
        variable[...] = values
    whole_chunks(file)


def _fill(
    file: netCDF4.Dataset, slabs: Slabs, rows: Callable[[int], Rows]
) -> tuple[NDArray[np.int64], float, list[str]]:
    statuses, worst = np.zeros(128, dtype=np.int64), np.nan
    digests = [hashlib.sha256() for _ in RESULT_COLUMNS]
    for number in range(len(slabs)):
        found = rows(number)
        for column, name in enumerate(RESULT_COLUMNS):
            values = np.ascontiguousarray(result_values(name, found[:, column]))
            file[name][slabs.box(number)] = values.reshape(slabs.extent(number))
            digests[column].update(values.tobytes())
            if name == "status":
                statuses += np.bincount(values, minlength=128)
            elif name == "amplitude_error":
                worst = np.fmax(worst, np.fmax.reduce(values))
    return statuses, float(worst), [digest.hexdigest() for digest in digests]


def seal_of(path: Path, key: bytes, slabs: Slabs) -> str:
    """The `data_sha256` that the numbers in a file would have; raises OSError and RuntimeError."""
    return data_sha256(key, _digests(path, slabs))


def _digests(path: Path, slabs: Slabs) -> list[str]:
    """The SHA-256 of each result variable as it stands in a file."""
    with netCDF4.Dataset(path) as file:
        whole_chunks(file)
        return [_digest(file[name], slabs) for name in RESULT_COLUMNS]


def _digest(variable: Any, slabs: Slabs) -> str:
    digest = hashlib.sha256()
    for part in _boxes(slabs):
        digest.update(np.ascontiguousarray(variable[part]).tobytes())
    return digest.hexdigest()


def _boxes(slabs: Slabs) -> Iterator[tuple[slice, ...]]:
    return (slabs.box(number) for number in range(len(slabs)))
