"""The house decorators for compiled code, and the reason for every flag.

`error_model="numpy"`: a division by zero gives inf, which the drives detect, instead of an
exception that no loop over lanes or GPU thread could raise. `nogil`: blocks of points run on
threads. Never `fastmath=True`: it lets NaN pass `err <= 1` (docs/decisions/compiled-code.md).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from llvmlite import ir
from llvmlite.binding import Linkage, get_host_cpu_name
from numba.core import cgutils, types
from numba.core import config as numba_config
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.compiler import Compiler
from numba.extending import intrinsic

_FLAGS: dict[str, Any] = {"error_model": "numpy", "nogil": True}

_products: Counter[tuple[str, str]] = Counter()

# a*b + c in one rounding, and one reciprocal for several divisions by the same number: both keep
# NaN and are exact under the model's scalings by powers of two. Never to be added: `reassoc`, which
# would break the roundings in model/elementary.py, and `nsz`, which takes the sign off a zero and
# with it the direction in which the error estimate looks away from a cusp (a test fails).
_FASTMATH = {"contract", "arcp"}

# The vectoriser left to itself takes half the width of an AVX-512 machine and one vector at a time,
# so that a step waits for its own results: with two in flight it takes 1.3 to 1.8 times less time.
# Where registers are shorter the compiler splits a vector into several, which does the same.
VECTOR = 8
"""Lanes a vector of a lane loop."""

_INTERLEAVED = 2

LANES = VECTOR * _INTERLEAVED
"""The number of lanes of a lane loop is a multiple of this."""


def jit(function: Callable[..., Any]) -> Any:
    """A compiled function that belongs to a drive; it is compiled into the door that calls it."""
    return numba.njit(**_FLAGS, fastmath=_FASTMATH)(_told_apart(function))


def inline(function: Callable[..., Any]) -> Any:
    """A small scalar function that must vanish into its caller: every equation of the model."""
    return numba.njit(**_FLAGS, fastmath=_FASTMATH, forceinline=True)(_told_apart(function))


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


@intrinsic
def _for_lanes(typing_context: Any, lanes: Any, body: Any, arguments: Any) -> Any:
    """Call `body(lane, *arguments)` for each lane, as one loop that is compiled to vectors.

    `lanes` a multiple of LANES; `body` an `inline` function without a branch, a call or a loop,
    whose lanes touch no common element. Otherwise the loop is compiled to scalar code, with the
    same results but slowly (tests look at the assembly).
    """
    signature = types.void(lanes, body, arguments)
    call = (types.int64, *arguments.types)

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        count, _, packed = values
        called = signature.args[1].get_call_type(context.typing_context, call, {})
        function = context.get_function(signature.args[1], called)
        integer = ir.IntType(64)
        before = builder.block
        loop = builder.function.append_basic_block("lanes")
        after = builder.function.append_basic_block("lanes.end")
        builder.branch(loop)
        builder.position_at_end(loop)
        lane = builder.phi(integer)
        lane.add_incoming(integer(0), before)
        function(builder, [lane, *cgutils.unpack_tuple(builder, packed)])
        following = builder.add(lane, integer(1), flags=["nuw", "nsw"])
        lane.add_incoming(following, builder.block)
        more = builder.icmp_signed("<", following, count)
        branch = builder.cbranch(more, loop, after)
        branch.set_metadata("llvm.loop", _loop_hints(builder.module))
        builder.position_at_end(after)
        return context.get_dummy_value()

    return signature, codegen


for_lanes: Any = _for_lanes  # numba's types know nothing of what an intrinsic is called with


def _loop_hints(module: Any) -> Any:
    """LLVM's loop metadata: vectorise, so wide, so many at a time, and do not unroll before."""
    hints = [
        [ir.MetaDataString(module, "llvm.loop.vectorize.enable"), ir.IntType(1)(1)],
        [ir.MetaDataString(module, "llvm.loop.vectorize.width"), ir.IntType(32)(VECTOR)],
        [ir.MetaDataString(module, "llvm.loop.interleave.count"), ir.IntType(32)(_INTERLEAVED)],
        [ir.MetaDataString(module, "llvm.loop.unroll.disable")],
    ]
    metadata = module.add_metadata([module.add_metadata(hint) for hint in hints])
    metadata.operands = (metadata, *metadata.operands)  # a loop's metadata begins with itself
    return metadata


def door(function: Callable[..., Any]) -> Any:
    """A compiled entry point: takes plain data only and is cached on disk.

    Numba's own check sees only the file that holds the door, so an edit of the physics in another
    file would go unnoticed; the cache folder is therefore named by a hash of all sources.
    """
    dispatcher = numba.njit(**_FLAGS, fastmath=_FASTMATH, pipeline_class=_SealedCompiler)(function)
    with _CacheFolder():
        try:
            dispatcher._cache = _SteadyCache(function)  # what njit(cache=True) does, with our class
        except RuntimeError:  # no writable folder anywhere
            _warn_once("compiled code cannot be cached: no writable folder; set NUMBA_CACHE_DIR")
    return dispatcher


class _SealedCompiler(Compiler):
    """Compiles a door together with all it calls into code of its own, shared with nobody.

    Numba keeps the functions that a door calls as weak symbols, of which a process uses the copy
    that it loaded first: the one compiled by itself after a compilation, some door's own after
    loading from the cache. The copies were optimised in different company and differ in the last
    bits, so that a first run gave other numbers than all later ones.
    """

    def __init__(self, typing_context: Any, target: Any, library: Any, *others: Any) -> None:
        library = target.codegen().create_library("sealed door")
        library.enable_object_caching()
        optimise = library._optimize_final_module

        def seal_and_optimise() -> None:
            for function in library._final_module.functions:
                if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                    function.linkage = Linkage.internal
            optimise()

        library._optimize_final_module = seal_and_optimise
        super().__init__(typing_context, target, library, *others)


class _SteadyCache(FunctionCache):
    """Numba's file cache, which recompiles where a damaged file would have raised."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        impl = self._impl
        stamp = impl.locator.get_source_stamp()
        self._cache_file = _CheckedFile(self._cache_path, impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # noqa: BLE001 - a damaged pickle can raise nearly anything
            _warn_once(f"the cache of compiled code is damaged and is made anew ({error!r})")
            with contextlib.suppress(OSError):  # what cannot be replaced is passed over
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except Exception as error:  # noqa: BLE001 - a full disk must not stop a computation
            _warn_once(f"compiled code could not be cached ({error!r})")


class _CheckedFile(IndexDataCacheFile):
    """Numba's data file with a checksum: code of which a page was lost would crash the process."""

    def _save_data(self, name: str, data: Any) -> None:
        pickled = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(hashlib.sha256(pickled).digest() + pickled)

    def _load_data(self, name: str) -> Any:
        stored = memoryview(Path(self._data_path(name)).read_bytes())
        if hashlib.sha256(stored[32:]).digest() != stored[:32]:
            raise ValueError(f"the checksum of {name} is wrong")
        return pickle.loads(stored[32:])


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
def processor() -> str:
    """The kind of processor that code is compiled for: numbers agree to the last bit within one."""
    return str(numba_config.CPU_NAME or get_host_cpu_name())


@cache
def _warn_once(message: str) -> None:
    warnings.warn(message, RuntimeWarning, stacklevel=3)
