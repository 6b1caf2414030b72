"""NetCDF files as Datasets: written by commands and read back, opened, hashed."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from sweeps.exits import ExpectedError, StorageError
from sweeps.files.attributes import foreign_attributes
from sweeps.files.run_folder import RunFolder
from sweeps.files.sweep_file import open_file, whole_chunks
from sweeps.watch import require_readable

if TYPE_CHECKING:
    import xarray as xr


DAMAGE = (OSError, RuntimeError, AttributeError, LookupError, TypeError, ValueError)
"""Errors that have been seen on reading damaged files."""


def write_checked(
    ds: xr.Dataset, path: Path, groups: Mapping[str, xr.Dataset] = MappingProxyType({})
) -> None:
    """Write `ds` and its groups to a temporary file, and read `ds` back.

    Raises OSError and RuntimeError.
    """
    ds.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=_encoding(ds))
    for name, group in groups.items():
        group.to_netcdf(
            path, "a", "NETCDF4", group=name, engine="netcdf4", encoding=_encoding(group)
        )
    with _opened(path) as written:
        if content_hash(written.load()) != content_hash(ds):
            raise OSError("the file does not read back as it was written")


def open_result(path: Path, *, whole: bool = True) -> xr.Dataset:
    """Return the Dataset in a file, loaded if `whole`, else read when accessed.

    Raises StorageError if the file is not readable NetCDF, or if an attribute would make a reader
    see values that were not written.
    """
    require_readable(path)
    with readable(path):
        if not whole:
            return _opened(path)
        with _opened(path) as ds:
            return ds.load()


def _opened(path: Path) -> xr.Dataset:
    """Return the Dataset in a file; raises StorageError if attributes do not suit a variable."""
    import xarray as xr

    file = open_file(path)
    found = [
        f"{path}: {name} {what}"
        for name, variable in file.variables.items()
        for what in foreign_attributes(name, variable.__dict__)
    ]
    if found:
        file.close()
        remedy = "the file was changed after it was written, and its values would be misread"
        raise StorageError("\n".join([*found, f"{remedy}: restore it, or compute it again"]))
    whole_chunks(file)
    store = xr.backends.NetCDF4DataStore(file)  # type: ignore[no-untyped-call]
    ds = xr.open_dataset(store, cache=False)
    ds.encoding["source"] = str(path)  # as xarray sets it
    return ds


@contextlib.contextmanager
def readable(path: Path) -> Iterator[None]:
    """Raise the errors of reading a damaged file as a StorageError."""
    try:
        yield
    except (ExpectedError, BrokenPipeError):  # these have a message, or no reader
        raise
    except FileNotFoundError:
        raise StorageError(RunFolder(path).absence()) from None
    except DAMAGE as error:
        raise StorageError(f"{path} is not a readable NetCDF file: {error}") from error


def content_hash(ds: xr.Dataset) -> str:
    """Return the SHA-256 of all variables, coordinates and attributes except `history`, as hex.

    A result is called reproducible if its hash is always the same: it does not depend on the number
    of workers or the size of blocks.
    """
    digest = hashlib.sha256()
    for name, value in sorted(ds.attrs.items()):
        if name != "history":
            digest.update(f"{name}={_canonical(value)}\0".encode())
    for name in sorted(map(str, ds.variables)):
        variable = ds.variables[name]
        values = np.ascontiguousarray(variable.values)
        if values.dtype.kind in "OT":  # texts read from a file
            values = np.asarray(values.tolist(), dtype=np.str_)
        attrs = sorted((key, _canonical(value)) for key, value in variable.attrs.items())
        head = f"{name}{variable.dims}{values.dtype.str}{values.shape}{attrs}"
        digest.update(head.encode() + values.tobytes())
    return digest.hexdigest()


def _canonical(value: object) -> str:
    return repr(value.tolist()) if isinstance(value, (np.ndarray, np.generic)) else repr(value)


def _encoding(ds: xr.Dataset) -> dict[str, dict[str, object]]:
    """Return the encoding: arrays are compressed, and only floats have a fill value, as in CF."""
    encoding: dict[str, dict[str, object]] = {str(name): {"_FillValue": None} for name in ds.coords}
    for name, variable in ds.data_vars.items():
        packed = {"zlib": True, "complevel": 4, "shuffle": True} if variable.ndim else {}
        fill = np.nan if variable.dtype.kind == "f" else None
        encoding[str(name)] = packed | {"_FillValue": fill}
    return encoding
