"""The house decorators for compiled code, and the reason for every flag.

`error_model="numpy"`: a division by zero gives inf, which the drives detect, instead of an
exception that no loop over lanes or GPU thread could raise. `nogil`: blocks of points run on
threads. Never `fastmath=True`: it lets NaN pass `err <= 1` (docs/decisions/compiled-code.md).
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from typing import Any

import numba

from stickslip.compiled.cache import CacheFolder, SteadyCache, warn_once
from stickslip.compiled.compilers import Part, SealedCompiler

# No C wrapper: nobody calls these functions from C, and each wrapper is compiled as a function.
_FLAGS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}

KERNEL_NAMES: set[str] = set()
_factories = threading.RLock()

# a*b + c in one rounding, and one reciprocal for several divisions by the same number: both keep
# NaN and are exact under the model's scalings by powers of two. Never to be added: `reassoc`, which
# would break the roundings in elementary.py, and `nsz`, which takes the sign off a zero and with it
# the direction in which the error estimate looks away from a cusp (a test fails).
_FASTMATH = {"contract", "arcp"}


def jit(function: Callable[..., Any]) -> Any:
    """A compiled function that belongs to a drive; it is compiled into the kernel that calls it."""
    return Part(function, targetoptions={**_FLAGS, "fastmath": _FASTMATH})


def inline(function: Callable[..., Any]) -> Any:
    """A small scalar function that must vanish into its caller: every equation of the model."""
    return Part(function, targetoptions={**_FLAGS, "fastmath": _FASTMATH, "forceinline": True})


def kernel(function: Callable[..., Any]) -> Any:
    """A compiled entry point: takes plain data only and is cached on disk.

    Numba's own check sees only the file that holds the kernel, so an edit of the physics in
    another file would go unnoticed; the cache folder is therefore named by a hash of all sources.
    """
    return named_kernel(f"{function.__module__}.{function.__qualname__}", function)


def kernel_factory(make: Callable[..., Any]) -> Callable[..., Any]:
    """A function that makes kernels, and gives the same ones to who asks again, in any thread."""
    made: dict[tuple[Any, ...], Any] = {}

    @wraps(make)
    def kernel_of(*arguments: Any) -> Any:
        with _factories:
            if arguments not in made:
                made[arguments] = make(*arguments)
            return made[arguments]

    return kernel_of


def named_kernel(name: str, function: Callable[..., Any]) -> Any:
    """A kernel that a factory made; `name` tells by the factory's arguments what it computes.

    The name is the kernel's symbol and its entry in the cache. It must not depend on the order in
    which a process makes its kernels: two processes would give one symbol to different code.

    Raises ValueError where the name is taken.
    """
    if name in KERNEL_NAMES:
        raise ValueError(f"there is a kernel called {name} already")
    KERNEL_NAMES.add(name)
    function.__qualname__ = name
    dispatcher = numba.njit(**_FLAGS, fastmath=_FASTMATH, pipeline_class=SealedCompiler)(function)
    try:
        with CacheFolder():
            dispatcher._cache = SteadyCache(function)  # what njit(cache=True) does, with our class
    except RuntimeError:  # no writable folder anywhere
        warn_once("compiled code cannot be cached: no writable folder; set NUMBA_CACHE_DIR")
    return dispatcher
