"""The house decorators for compiled code, and the reason for every flag.

`error_model="numpy"`: a division by zero gives inf, which the drives detect, instead of an
exception that no loop over lanes or GPU thread could raise. `nogil`: blocks of points run on
threads. Never `fastmath=True`: it lets NaN pass `err <= 1` (docs/decisions/compiled-code.md).
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import config as numba_config
from numba.core.caching import FunctionCache

_FLAGS: dict[str, Any] = {"error_model": "numpy", "nogil": True}

# Contracting a*b + c into one rounding is exact under the model's scalings by powers of two and
# keeps NaN; the other fastmath flags are not needed.
_CONTRACT = {"contract"}

_products: Counter[tuple[str, str]] = Counter()


def jit(function: Callable[..., Any]) -> Any:
    """A compiled function that belongs to a drive; it is compiled into the door that calls it."""
    return numba.njit(**_FLAGS, fastmath=_CONTRACT)(_told_apart(function))


def inline(function: Callable[..., Any]) -> Any:
    """A small scalar function that must vanish into its caller: every equation of the model."""
    return numba.njit(**_FLAGS, fastmath=_CONTRACT, forceinline=True)(_told_apart(function))


def _told_apart(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function under a name of its own, where a factory makes several of one name.

    Numba tells those apart by a counter that starts anew in each process. Two doors that were
    cached by different processes could so hold different code under one symbol, and the linker
    would take the first for both.
    """
    name = function.__module__, function.__qualname__
    number = _products[name]
    _products[name] += 1
    if number:
        function.__qualname__ += f"_{number}"
    return function


def door(function: Callable[..., Any]) -> Any:
    """A compiled entry point: takes plain data only and is cached on disk.

    Numba's own check sees only the file that holds the door, so an edit of the physics in another
    file would go unnoticed; the cache folder is therefore named by a hash of all sources.
    """
    dispatcher = numba.njit(**_FLAGS, fastmath=_CONTRACT)(function)
    with _CacheFolder():
        try:
            dispatcher._cache = _SteadyCache(function)  # what njit(cache=True) does, with our class
        except RuntimeError:  # no writable folder anywhere
            _warn_once("compiled code cannot be cached: no writable folder; set NUMBA_CACHE_DIR")
    return dispatcher


class _SteadyCache(FunctionCache):
    """Numba's file cache, which recompiles where a damaged file would have raised."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # noqa: BLE001 - a damaged pickle can raise nearly anything
            _warn_once(f"the cache of compiled code is damaged and is made anew ({error!r})")
            self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except Exception as error:  # noqa: BLE001 - a full disk must not stop a computation
            _warn_once(f"compiled code could not be cached ({error!r})")


class _CacheFolder:
    """Points Numba at the package's own cache folder while a door is declared."""

    def __enter__(self) -> None:
        self._previous = numba_config.CACHE_DIR, numba_config.CACHE_LOCATOR_CLASSES
        numba_config.CACHE_DIR = str(cache_folder())
        # Without this an unwritable folder sends Numba to __pycache__, which no hash names.
        numba_config.CACHE_LOCATOR_CLASSES = "UserProvidedCacheLocator"

    def __exit__(self, *exception: object) -> None:
        numba_config.CACHE_DIR, numba_config.CACHE_LOCATOR_CLASSES = self._previous


def cache_folder() -> Path:
    """Where the compiled code of exactly these sources is kept."""
    return _cache_root() / f"stickslip-{source_hash()[:16]}"


def _cache_root() -> Path:
    if numba_config.CACHE_DIR:  # set by NUMBA_CACHE_DIR
        return Path(numba_config.CACHE_DIR)
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(home).expanduser() / "stickslip"


@cache
def source_hash() -> str:
    """Hexadecimal SHA-256 of the package's Python sources: the fingerprint of the code."""
    root = Path(__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0")
        digest.update(path.read_bytes())
    return digest.hexdigest()


@cache
def _warn_once(message: str) -> None:
    warnings.warn(message, RuntimeWarning, stacklevel=3)
