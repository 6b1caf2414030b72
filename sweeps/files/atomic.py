"""Files written completely or not at all, and errors of the disk."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

from sweeps.exits import StorageError
from sweeps.human import reason

_LEAST_ROOM = 1 << 17  # bytes; even an empty result needs more


@contextlib.contextmanager
def replacing(
    path: Path,
    temporary: Path | None = None,
    *,
    fsync: bool = True,
    follow: bool = True,
) -> Iterator[Path]:
    """Give the body a temporary file to write, which then replaces `path`.

    Whatever happens, `path` is the complete old file or the complete new one; if the body raises,
    it is the old one. The temporary file, on the same file system and by default a hidden one
    beside `path`, is removed in either case. With `fsync` the new file survives a power cut. With
    `follow` a link stays, and the file that it points to is replaced. The new file gets the
    permissions of the old one.
    """
    path = followed(path) if follow else path
    temporary = temporary or beside(path)
    try:
        begin(temporary)
        settle_mode(temporary, path)
        yield temporary
        if fsync:
            flush(temporary)
        temporary.replace(path)
        if fsync:
            flush(path.parent)
    finally:
        remove(temporary)


def settle_mode(temporary: Path, path: Path, like: Path | None = None) -> None:
    """Give a file the permissions of the one it replaces, or at most those of `like`."""
    if path.is_file() and not path.is_symlink():
        temporary.chmod(stat.S_IMODE(path.stat().st_mode) & 0o666)
    elif like is not None:
        temporary.chmod(stat.S_IMODE(temporary.stat().st_mode & like.stat().st_mode))


def appear(temporary: Path, path: Path) -> None:
    """Give a finished file its name; raises FileExistsError if another file has that name."""
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: an empty file reserves the name
        begin_new(path)
        temporary.replace(path)
    else:
        remove(temporary)


def followed(path: Path) -> Path:
    """Return the end of a chain of links; a path that is not a link stays the same."""
    return path.resolve() if path.is_symlink() else path


def begin(path: Path) -> None:
    """Create an empty file; whatever has this name, even a link, is removed."""
    remove(path)
    begin_new(path)


def begin_new(path: Path) -> None:
    """Create an empty file; raises FileExistsError if anything, even a link, has this name."""
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666))


def fingerprint(path: Path) -> list[int] | None:
    """Return size and time of a file, which show whether it has changed; None if it is missing."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    return [status.st_size, status.st_mtime_ns]


def beside(path: Path) -> Path:
    """Return a hidden name in the same folder, unique to this process.

    Removes the files that killed processes of this machine have left under such names.
    """
    stem = f".{path.name}.{socket.gethostname()}."
    for left in left_by_killed(path.parent, stem):
        if left.suffix == ".tmp":
            remove(left)
    return path.with_name(f"{stem}{os.getpid()}.tmp")


def left_by_killed(folder: Path, stem: str) -> Iterator[Path]:
    """Yield what has a name of `stem` and the number of a process that no longer runs."""
    for left in folder.glob(f"{glob.escape(stem)}*"):
        pid = left.name[len(stem) :].partition(".")[0]
        if pid.isdecimal() and not _is_running(int(pid)):
            yield left


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:  # it belongs to somebody else
        return True
    return True


def remove(path: Path) -> None:
    """Remove a file if it exists; a failure is ignored, so that it hides no earlier error."""
    with contextlib.suppress(OSError):
        path.unlink()


def flush(path: Path) -> None:
    """Flush a file, or the entries of a folder, to disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextlib.contextmanager
def storage_errors(what: str, where: Path | None = None) -> Iterator[None]:
    """Raise failures of the disk as a StorageError, such as `cannot write a.nc: File exists`.

    The HDF5 library reports a full disk as a RuntimeError without a reason, or as a missing
    permission; if `where`, the folder being written to, is given, the message has the real reason.
    """
    try:
        yield
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:
        full = where is not None and is_full(where)
        cause = "no space left on the disk" if full else reason(error)
        raise StorageError(f"{what}: {cause}") from error


def is_full(folder: Path) -> bool:
    """Return whether a folder has almost no space left."""
    try:
        usage = shutil.disk_usage(folder)
        return usage.total > 0 and usage.free < _LEAST_ROOM  # /proc has no size
    except OSError:
        return False


def refuse_odd_output(output: Path) -> None:
    """Raise StorageError if the output is not something that a file may replace."""
    with storage_errors(f"cannot write {output}"):
        if output.is_dir():
            raise StorageError(f"{output} is a folder; -o must name a file")
        if output.exists() and not output.is_file():  # a device or a pipe would be replaced
            raise StorageError(f"{output} is not an ordinary file; -o must name one")
        above = next(folder for folder in output.absolute().parents if folder.exists())
        if not above.is_dir():
            named = next(f for f in output.parents if f.absolute() == above)
            raise StorageError(f"cannot write {output}: {named} is not a folder")
        if output.is_symlink() and not output.exists():
            with contextlib.suppress(FileNotFoundError):  # a link to a file not made yet
                output.resolve(strict=True)  # raises where a chain of links ends in itself
            end = followed(output)
            if not end.parent.is_dir():
                raise StorageError(
                    f"cannot write {output}: it is a link to {end}, whose folder does not exist"
                )
