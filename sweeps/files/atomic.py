"""Files that are written whole or not at all, and what stands in the way of writing one."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from sweeps.exits import Exit, ExpectedError
from sweeps.human import reason


class StorageError(ExpectedError, OSError):
    """A file that cannot be read or written, or was not written as it was meant."""

    code = Exit.STORAGE


@contextlib.contextmanager
def replacing(path: Path, temporary: Path | None = None, *, fsync: bool = True) -> Iterator[Path]:
    """Give the body a temporary file to write, and afterwards let it take the place of `path`.

    Whatever happens, `path` is the old file or the new one, whole; a body that raises leaves the
    old one. The temporary file, on the same file system and by default a hidden name beside `path`,
    is gone in either case. With `fsync` the file survives a power cut.
    """
    temporary = temporary or beside(path)
    try:
        yield temporary
        if fsync:
            flush(temporary)
        temporary.replace(path)
        if fsync:
            flush(path.parent)
    finally:
        remove(temporary)


def beside(path: Path) -> Path:
    """A hidden name in the same folder, of this process alone."""
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def remove(path: Path) -> None:
    """Take a file away if it is there; an earlier failure is the message, not that of cleaning."""
    with contextlib.suppress(OSError):
        path.unlink()


def flush(path: Path) -> None:
    """Have a file, or the entries of a folder, on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextlib.contextmanager
def storage_errors(what: str) -> Iterator[None]:
    """Raise failures of the disk as a StorageError, such as `cannot write a.nc: File exists`."""
    try:
        yield
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:  # the HDF5 library reports a full disk as RuntimeError
        raise StorageError(f"{what}: {reason(error)}") from error


def refuse_odd_output(output: Path) -> None:
    """Raise StorageError where the output is something that a file must not replace."""
    with storage_errors(f"cannot write {output}"):
        if output.is_dir():
            raise StorageError(f"{output} is a folder; -o names a file")
        if output.exists() and not output.is_file():  # a device or a pipe would be replaced
            raise StorageError(f"{output} is not an ordinary file; -o names one")
        above = next(folder for folder in output.absolute().parents if folder.exists())
        if not above.is_dir():
            named = next(f for f in output.parents if f.absolute() == above)
            raise StorageError(f"cannot write {output}: {named} is not a folder")
        if output.is_symlink() and not output.exists():
            output.resolve(strict=True)  # raises where a chain of links ends in itself
