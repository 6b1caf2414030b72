"""The decorators for compiled code, and the reason for every flag.

`error_model="numpy"`: a division by zero gives inf, which the drives detect, instead of an
exception that neither a loop over lanes nor a GPU thread could raise. `nogil`: blocks of points run
on threads. Never `fastmath=True`: it lets NaN pass `err <= 1` (docs/decisions/compiled-code.md).
`_nrt=False`: compiled code works in the arrays of its caller, who holds them; counting references
to them, each time with an atomic operation, makes a step in lanes a fifth longer. What makes arrays
of its own says so, or does not compile.
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
_FLAGS: dict[str, Any] = {
    "error_model": "numpy",
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}

KERNEL_NAMES: set[str] = set()
_factories = threading.RLock()

# a*b + c with one rounding, and one reciprocal for several divisions by the same number: both
# propagate NaN and are exact under scaling by powers of two. Never add `reassoc`, which would break
# the rounding in elementary.py, or `nsz`, which drops the sign of a zero and with it the side of a
# cusp at which the error estimate evaluates the law (a test fails).
_FASTMATH = {"contract", "arcp"}


def jit(function: Callable[..., Any]) -> Any:
    """Declare a compiled function of a drive; it is compiled into the kernels that call it."""
    return Part(function, targetoptions={**_FLAGS, "fastmath": _FASTMATH})


def jit_making_arrays(function: Callable[..., Any]) -> Any:
    """Declare the same for a function that makes arrays, or calls one that returns them."""
    return Part(function, targetoptions={**_FLAGS, "fastmath": _FASTMATH, "_nrt": True})


def inline(function: Callable[..., Any]) -> Any:
    """Declare a small scalar function to be inlined in its callers: every equation of the model."""
    return Part(function, targetoptions={**_FLAGS, "fastmath": _FASTMATH, "forceinline": True})


def kernel(function: Callable[..., Any]) -> Any:
    """Declare a compiled entry point, which takes only plain data and is cached on disk.

    Numba's own check covers only the file of the kernel, so an edit of the physics in another file
    would go unnoticed; the cache folder is therefore named by a hash of all sources.
    """
    return named_kernel(_full_name(function), function)


def kernel_making_arrays(function: Callable[..., Any]) -> Any:
    """Declare the same for a function that makes arrays."""
    return named_kernel(_full_name(function), function, makes_arrays=True)


def _full_name(function: Callable[..., Any]) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def kernel_factory(make: Callable[..., Any]) -> Callable[..., Any]:
    """Declare a function that makes kernels, one for each set of arguments, in any thread."""
    made: dict[tuple[Any, ...], Any] = {}

    @wraps(make)
    def kernel_of(*arguments: Any) -> Any:
        with _factories:
            if arguments not in made:
                made[arguments] = make(*arguments)
            return made[arguments]

    return kernel_of


def named_kernel(name: str, function: Callable[..., Any], *, makes_arrays: bool = False) -> Any:
    """Declare a kernel made by a factory; `name` identifies it by the factory's arguments.

    The name is the kernel's symbol and its entry in the cache. It must not depend on the order in
    which a process makes its kernels, or two processes would give the same symbol to different
    code.

    Raises ValueError if the name is taken.
    """
    if name in KERNEL_NAMES:
        raise ValueError(f"there is a kernel called {name} already")
    KERNEL_NAMES.add(name)
    function.__qualname__ = name
    flags = _FLAGS | {"fastmath": _FASTMATH, "_nrt": makes_arrays}
    dispatcher = numba.njit(**flags, pipeline_class=SealedCompiler)(function)
    try:
        with CacheFolder():
            dispatcher._cache = SteadyCache(function)  # as njit(cache=True), but with our class
    except RuntimeError as error:  # no folder, or none that can be written or trusted
        warn_once(f"compiled code is not cached: {error}")
    return dispatcher
