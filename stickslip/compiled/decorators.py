"""The decorators for compiled code, and the reason for every flag.

With `error_model="numpy"` a division by zero gives inf, which the integrators detect, not an
exception, which neither a loop over lanes nor a GPU thread could raise. `nogil` lets blocks of
points run on threads. `fastmath=True` is never used, because it lets NaN pass `err <= 1`
(docs/decisions/compiled-code.md). With `_nrt=False` Numba does not count references to arrays.
Compiled code works in arrays that its caller holds, and the atomic operation of each count makes a
step in lanes take a fifth longer. Functions that make arrays need separate decorators and do
not compile with the others.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from typing import Any

import numba

from stickslip.compiled.cache import CacheFolder, SteadyCache, warn_once
from stickslip.compiled.compilers import Part, SealedCompiler

_FLAGS: dict[str, Any] = {
    "error_model": "numpy",
    "nogil": True,
    # Nobody calls these functions from C, and compiling a C wrapper takes as long as any function.
    "no_cfunc_wrapper": True,
    "_nrt": False,
    # These allow a*b + c with a single rounding, and one reciprocal for several divisions by the
    # same number. Both propagate NaN and are exact under scaling by powers of two. Never add
    # `reassoc`, which would break the rounding in elementary.py, or `nsz`, which drops the sign of
    # a zero and with it the side of a cusp at which the error estimate evaluates the law (a test
    # fails).
    "fastmath": {"contract", "arcp"},
}

KERNEL_NAMES: set[str] = set()
_factories = threading.RLock()


def jit(function: Callable[..., Any]) -> Any:
    """Declare a function that is compiled into the kernels that call it."""
    return Part(function, targetoptions=_FLAGS)


def jit_making_arrays(function: Callable[..., Any]) -> Any:
    """Declare, as `jit` does, a function that makes arrays, or calls one that returns them."""
    return Part(function, targetoptions={**_FLAGS, "_nrt": True})


def inline(function: Callable[..., Any]) -> Any:
    """Declare a small scalar function, such as an equation, that is inlined in its callers."""
    return Part(function, targetoptions={**_FLAGS, "forceinline": True})


def kernel(function: Callable[..., Any]) -> Any:
    """Declare a compiled entry point, which takes only plain data and is cached on disk.

    Numba checks only the file of the kernel for changes, so it would miss an edit of the physics in
    another file. Therefore the name of the cache folder contains a hash of all sources.
    """
    return named_kernel(_full_name(function), function)


def kernel_making_arrays(function: Callable[..., Any]) -> Any:
    """Declare, as `kernel` does, a function that makes arrays."""
    return named_kernel(_full_name(function), function, makes_arrays=True)


def _full_name(function: Callable[..., Any]) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def kernel_factory(make: Callable[..., Any]) -> Callable[..., Any]:
    """Declare a function that makes one kernel for each set of arguments, in any thread."""
    made: dict[tuple[Any, ...], Any] = {}

    @wraps(make)
    def kernel_of(*arguments: Any) -> Any:
        with _factories:
            if arguments not in made:
                made[arguments] = make(*arguments)
            return made[arguments]

    return kernel_of


def named_kernel(name: str, function: Callable[..., Any], *, makes_arrays: bool = False) -> Any:
    """Declare a kernel made by a factory, whose arguments are part of the `name`.

    The name is the kernel's symbol and its entry in the cache. It must not depend on the order in
    which a process makes its kernels, or two processes would give the same symbol to different
    code.

    Raises ValueError if another kernel has this name.
    """
    if name in KERNEL_NAMES:
        raise ValueError(f"there is already a kernel called {name}")
    KERNEL_NAMES.add(name)
    function.__qualname__ = name
    flags = {**_FLAGS, "_nrt": makes_arrays}
    dispatcher = numba.njit(**flags, pipeline_class=SealedCompiler)(function)
    try:
        with CacheFolder():
            dispatcher._cache = SteadyCache(function)  # what njit(cache=True) does with its class
    except RuntimeError as error:  # no folder, or none that can be written or trusted
        warn_once(f"compiled code is not cached: {error}")
    return dispatcher
