"""Files that are written whole or not at all, and what stands in the way of writing one."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

from sweeps.exits import Exit, ExpectedError
from sweeps.human import reason

_LEAST_ROOM = 1 << 17  # bytes: less than the structure of an empty result


class StorageError(ExpectedError, OSError):
    """A file that cannot be read or written, or was not written as it was meant."""

    code = Exit.STORAGE


@contextlib.contextmanager
def replacing(
    path: Path,
    temporary: Path | None = None,
    *,
    fsync: bool = True,
    follow: bool = True,
    like: Path | None = None,
) -> Iterator[Path]:
    """Give the body a temporary file to write, and afterwards let it take the place of `path`.

    Whatever happens, `path` is the old file or the new one, whole; a body that raises leaves the
    old one. The temporary file, on the same file system and by default a hidden name beside `path`,
    is gone in either case. With `fsync` the file survives a power cut. With `follow` a link stays
    one, and the file that it leads to is replaced. An older file passes on who may read it; a
    new one is readable by no more people than the file `like`.
    """
    path = followed(path) if follow else path
    temporary = temporary or beside(path)
    try:
        begin(temporary)
        if path.is_file() and not path.is_symlink():
            temporary.chmod(stat.S_IMODE(path.stat().st_mode) & 0o666)
        elif like is not None:
            temporary.chmod(stat.S_IMODE(temporary.stat().st_mode & like.stat().st_mode))
        yield temporary
        if fsync:
            flush(temporary)
        temporary.replace(path)
        if fsync:
            flush(path.parent)
    finally:
        remove(temporary)


def followed(path: Path) -> Path:
    """Where a chain of links ends; a path that is none as it is."""
    return path.resolve() if path.is_symlink() else path


def begin(path: Path) -> None:
    """Make an empty file of our own: whatever somebody put there, a link too, is taken away."""
    remove(path)
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666))


def fingerprint(path: Path) -> list[int] | None:
    """Tells whether a file is still the same; None where there is none."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    return [found.st_size, found.st_mtime_ns]


def beside(path: Path) -> Path:
    """Return a hidden name in the same folder, of this process alone.

    The files that killed processes of this machine left there under such names are removed.
    """
    stem = f".{path.name}.{socket.gethostname()}."
    for left in path.parent.glob(f"{glob.escape(stem)}*.tmp"):
        pid = left.name[len(stem) : -len(".tmp")]
        if pid.isdecimal() and not _is_running(int(pid)):
            remove(left)
    return path.with_name(f"{stem}{os.getpid()}.tmp")


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # somebody else's
        return True
    return True


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
def storage_errors(what: str, where: Path | None = None) -> Iterator[None]:
    """Raise failures of the disk as a StorageError, such as `cannot write a.nc: File exists`.

    The HDF5 library reports a full disk as a RuntimeError without a reason, or as a permission that
    is missing: with `where`, the folder that was written to, the reason is told.
    """
    try:
        yield
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:
        full = where is not None and is_full(where)
        told = "no space left on the disk" if full else reason(error)
        raise StorageError(f"{what}: {told}") from error


def is_full(folder: Path) -> bool:
    """Whether next to nothing can be written into a folder any more."""
    try:
        usage = shutil.disk_usage(folder)
        return usage.total > 0 and usage.free < _LEAST_ROOM  # /proc has no size
    except OSError:
        return False


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
