"""Result files: written beside the old one, read back, then put in its place; hashed; opened."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

# What may differ between two files with the same numbers.
_NOT_IDENTITY = ("history",)


class StorageError(OSError):
    """A file that cannot be written, or was not written as it was meant."""


def require_writable(ds: xr.Dataset, path: Path) -> None:
    """Write `ds`, which has the size and the attributes of the result, and take it away again.

    Raises StorageError: better before the computation than after it.
    """
    temporary = _temporary(path)
    try:
        _write(ds, temporary)
    finally:
        _remove(temporary)


def write_dataset(ds: xr.Dataset, path: Path) -> None:
    """Write `ds` to `path`; an older file there is replaced completely or not at all.

    Raises StorageError where the file cannot be written or does not read back as it was.
    """
    temporary = _temporary(path)
    try:
        _write(ds, temporary)
        _compare(ds, temporary)
        put_in_place(temporary, path)
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise StorageError(f"cannot write {path}: {reason}") from error
    finally:
        _remove(temporary)


def refuse_odd_output(output: Path) -> None:
    """Raise StorageError where the output is something that a file must not replace."""
    try:
        if output.is_dir():
            raise StorageError(f"{output} is a folder; -o names a file")
        if output.exists() and not output.is_file():  # a device or a pipe would be replaced
            raise StorageError(f"{output} is no ordinary file; -o names one")
        above = next(folder for folder in output.absolute().parents if folder.exists())
        if not above.is_dir():
            shown = next(f for f in output.parents if f.absolute() == above)
            raise StorageError(f"cannot write {output}: {shown} is no folder")
        if output.is_symlink() and not output.exists():
            output.resolve(strict=True)
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise StorageError(f"cannot write {output}: {reason}") from error


def put_in_place(temporary: Path, path: Path) -> None:
    """Give a finished file its name; whatever happens, `path` is the old one or this one, whole."""
    _flush(temporary)
    temporary.replace(path)
    _flush(path.parent)


def open_result(path: Path, *, whole: bool = True) -> xr.Dataset:
    """The Dataset in a file, loaded, or read variable by variable when it is looked at.

    Raises StorageError where it is not a readable NetCDF file.
    """
    import xarray as xr

    try:
        if not whole:
            return xr.open_dataset(path, engine="netcdf4", cache=False)
        with xr.open_dataset(path, engine="netcdf4") as ds:
            return ds.load()
    except FileNotFoundError:
        raise StorageError(f"{path} does not exist") from None
    except (OSError, ValueError, RuntimeError) as error:
        raise StorageError(f"{path} is not a readable NetCDF file: {error}") from error


def content_hash(ds: xr.Dataset) -> str:
    """SHA-256 over all variables, coordinates and attributes but `history`, in hexadecimal.

    Files with the same hash are identical in the sense that this project promises: for any number
    of workers, any size of blocks.
    """
    digest = hashlib.sha256()
    for name, value in sorted(ds.attrs.items()):
        if name not in _NOT_IDENTITY:
            digest.update(f"{name}={_canonical(value)}\0".encode())
    for name in sorted(map(str, ds.variables)):
        variable = ds.variables[name]
        values = np.ascontiguousarray(variable.values)
        attrs = sorted((key, _canonical(value)) for key, value in variable.attrs.items())
        head = f"{name}{variable.dims}{values.dtype.str}{values.shape}{attrs}"
        digest.update(head.encode() + values.tobytes())
    return digest.hexdigest()


def _canonical(value: object) -> str:
    return repr(value.tolist()) if isinstance(value, (np.ndarray, np.generic)) else repr(value)


def _temporary(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def _remove(temporary: Path) -> None:
    with suppress(OSError):  # what went wrong before is the message; here nothing more can be done
        temporary.unlink()


def _write(ds: xr.Dataset, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        ds.to_netcdf(path, engine="netcdf4", format="NETCDF4", encoding=_encoding(ds))
    except (OSError, RuntimeError) as error:  # the HDF5 library reports a full disk as RuntimeError
        target = path.name.removeprefix(".").rsplit(".", 2)[0]
        reason = getattr(error, "strerror", None) or error
        if isinstance(error, FileExistsError):  # of mkdir: `File exists` would mislead
            reason = f"{path.parent} is no folder"
        raise StorageError(f"cannot write {path.with_name(target)}: {reason}") from error


def _encoding(ds: xr.Dataset) -> dict[str, dict[str, object]]:
    """Compression for arrays, and a fill value for nothing but measured floats, as CF asks."""
    encoding: dict[str, dict[str, object]] = {}
    for name, variable in ds.variables.items():
        measured = name in ds.data_vars and variable.dtype.kind == "f"
        entry: dict[str, object] = {"_FillValue": np.nan if measured else None}
        if variable.ndim and name in ds.data_vars:
            entry |= {"zlib": True, "complevel": 4, "shuffle": True}
        encoding[str(name)] = entry
    return encoding


def _compare(ds: xr.Dataset, path: Path) -> None:
    import xarray as xr

    with xr.open_dataset(path, engine="netcdf4") as written:
        if content_hash(written.load()) != content_hash(ds):
            raise OSError("the file does not read back as it was written")


def _flush(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
