"""The cache of compiled code: a folder for each hash of all sources, and files with checksums.

The classes here extend private parts of Numba. If a new version of Numba changes those,
tests/compiled/test_cache.py fails; therefore pyproject.toml sets an upper bound on the version.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import shutil
import stat
import time
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from llvmlite.binding import get_host_cpu_name
from numba.core import config as numba_config
from numba.core.caching import FunctionCache, IndexDataCacheFile, UserProvidedCacheLocator
from numba.core.runtime import rtsys

_PREFIX = "stickslip-"
_KEPT_SECONDS = 30 * 86400.0


class SteadyCache(FunctionCache):
    """Numba's file cache, which compiles again instead of raising an error for a damaged file."""

    def __init__(self, function: Callable[..., Any]) -> None:
        try:
            super().__init__(function)
        except RuntimeError:  # Numba's message names one function of many
            raise RuntimeError("no writable folder; set NUMBA_CACHE_DIR") from None
        impl = self._impl
        stamp = impl.locator.get_source_stamp()
        self._name = function.__qualname__
        self._cache_file = _CheckedFile(self._cache_path, impl.filename_base, stamp)

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        """Return signature, processor and name; Numba's own key depends on a closure's identity.

        A name is enough, since the folder belongs to one hash of the sources.
        """
        return sig, codegen.magic_tuple(), self._name

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached code, or None if it is damaged.

        Numba's own method first imports everything that a compilation needs, which takes a quarter
        of a second.
        """
        try:
            rtsys.initialize(target_context)
            return self._load_overload(sig, target_context)
        except Exception as error:  # noqa: BLE001 - a damaged pickle can raise nearly anything
            warn_once(f"the cache of compiled code is damaged and will be rebuilt ({error!r})")
            with contextlib.suppress(OSError):  # an index that cannot be replaced stays
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store compiled code; if that fails, warn."""
        try:
            super().save_overload(sig, data)
        except Exception as error:  # noqa: BLE001 - a full disk must not stop a computation
            warn_once(f"compiled code could not be cached ({error!r})")


def is_kept(kernel: Any) -> bool:
    """Return whether a kernel, which has a single signature, is compiled here or on disk."""
    if kernel.signatures:
        return True
    file = getattr(kernel._cache, "_cache_file", None)  # None without a cache folder
    return file is not None and Path(file._index_path).exists()


class _CheckedFile(IndexDataCacheFile):
    """Numba's data file with a checksum, as code with a missing page would crash the process."""

    def _save_data(self, name: str, data: Any) -> None:
        pickled = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(hashlib.sha256(pickled).digest() + pickled)

    def _load_data(self, name: str) -> Any:
        stored = memoryview(Path(self._data_path(name)).read_bytes())
        if hashlib.sha256(stored[32:]).digest() != stored[:32]:
            raise ValueError(f"the checksum of {name} is wrong")
        return pickle.loads(stored[32:])


class OneFolder(UserProvidedCacheLocator):
    """Keeps all code in one folder, wherever the sources are.

    Numba's own locator would make a folder for each location. The kernels have unique names.
    """

    @classmethod
    def get_suitable_cache_subpath(cls, py_file: str) -> str:  # noqa: ARG003 - Numba's
        """Return no subfolder."""
        return ""


class CacheFolder:
    """Points Numba to the package's own cache folder while a kernel is declared.

    Raises RuntimeError if there is no such folder, or none that can be trusted.
    """

    def __enter__(self) -> None:
        folder = usable_cache_folder()
        self._previous = numba_config.CACHE_DIR, numba_config.CACHE_LOCATOR_CLASSES
        numba_config.CACHE_DIR = str(folder)
        # With its other locators Numba would replace an unwritable folder by __pycache__, which is
        # not tied to a hash of the sources.
        numba_config.CACHE_LOCATOR_CLASSES = f"{__name__}.{OneFolder.__name__}"

    def __exit__(self, *exception: object) -> None:
        numba_config.CACHE_DIR, numba_config.CACHE_LOCATOR_CLASSES = self._previous


def cache_folder() -> Path:
    """Return the folder for the compiled code of exactly these sources.

    Where several users share the cache, as in /tmp, each has a separate folder. Raises RuntimeError
    if there is no home folder.
    """
    root = _cache_root()
    user = f"{os.geteuid()}-" if root.is_dir() and writable_by_others(root.stat()) else ""
    return root / f"{_PREFIX}{user}{source_hash()[:16]}"


def usable_cache_folder() -> Path:
    """Make and return the `cache_folder`; raises RuntimeError if it cannot be used."""
    folder = cache_folder()
    _prepare(folder)
    _refuse_planted(folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise RuntimeError(f"{folder} is not writable; set NUMBA_CACHE_DIR")
    return folder


def _refuse_planted(folder: Path) -> None:
    """Raise RuntimeError if another user could have put code that we would run into the folder.

    A folder that does not exist, or cannot be inspected, is accepted: no code comes from it.
    """
    with contextlib.suppress(OSError):
        root, found = folder.parent.stat(), folder.lstat()
        if not stat.S_ISDIR(found.st_mode):
            raise RuntimeError(f"{folder} is not a folder; remove it")
        for path, status in ((folder.parent, root), (folder, found)):
            if status.st_uid not in (0, os.geteuid()):
                raise RuntimeError(f"{path} belongs to another user; set NUMBA_CACHE_DIR")
        if writable_by_others(found):
            raise RuntimeError(f"others can write into {folder}; remove it")
        if writable_by_others(root) and not root.st_mode & stat.S_ISVTX:
            raise RuntimeError(f"others can replace files in {folder.parent}; run chmod go-w on it")


def writable_by_others(status: os.stat_result) -> bool:
    """Return whether anyone but its owner may write to a file or folder."""
    return bool(status.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


@cache
def _prepare(folder: Path) -> None:
    """Make the folder, accessible to its owner only, and remove folders of old sources."""
    with contextlib.suppress(OSError):  # Numba reports a folder that cannot be written
        if not folder.exists():
            folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            folder.mkdir(mode=0o700, exist_ok=True)
            _remove_old(folder.parent)
        os.utime(folder)


def _remove_old(root: Path) -> None:
    """Remove this user's folders that no process has used for a long time."""
    for folder in root.glob(f"{_PREFIX}*{'[0-9a-f]' * 16}"):
        with contextlib.suppress(OSError):
            if time.time() - folder.stat().st_mtime > _KEPT_SECONDS:
                shutil.rmtree(folder, ignore_errors=True)


def _cache_root() -> Path:
    if numba_config.CACHE_DIR:  # set by NUMBA_CACHE_DIR
        return Path(numba_config.CACHE_DIR)
    home = Path(os.environ.get("XDG_CACHE_HOME") or "")
    if home.is_absolute():  # the XDG specification says to ignore any other
        return home / "stickslip"
    try:
        return Path("~/.cache/stickslip").expanduser()
    except RuntimeError:
        raise RuntimeError("there is no home folder; set NUMBA_CACHE_DIR") from None


@cache
def source_hash() -> str:
    """Return the hexadecimal SHA-256 of the package's Python sources."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0")
        digest.update(path.read_bytes())
    return digest.hexdigest()


@cache
def processor() -> str:
    """Return the processor type of compiled code. Results of one type agree bit for bit."""
    return str(numba_config.CPU_NAME or get_host_cpu_name())


@cache
def warn_once(message: str) -> None:
    """Issue a RuntimeWarning once for each message."""
    warnings.warn(message, RuntimeWarning, stacklevel=3)
