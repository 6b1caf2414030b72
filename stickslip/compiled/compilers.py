"""Compilers for the two kinds of compiled functions: sealed kernels, and the parts that they call.

This subclasses private parts of Numba. test_compilers.py and test_symbols.py in tests/compiled fail
if a new version of Numba changes them, which is why pyproject.toml sets an upper bound on that
version.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import cached_property
from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher
from numba.core.types import unliteral


class _SealedLibrary(JITCodeLibrary):
    """Machine code of which other code sees only the entry point.

    The functions inside become private before they are optimised. Internal linkage would not be
    enough: the loader uses the first copy of a function that it sees for all weak ones of the same
    name, even internal ones, and optimisation changes their calling conventions, which crashes
    callers.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = Linkage.private
        super()._optimize_final_module()


class SealedCompiler(Compiler):
    """Compiles a kernel and everything that it calls into private code.

    Numba keeps the functions that a kernel calls as weak symbols, of which a process uses the copy
    that it loaded first: after a compilation the one compiled by itself, after loading from the
    cache that of some kernel. The copies were optimised in different contexts and differ in the
    last bits, so that a first run gave different numbers from all later ones.
    """

    def __init__(self, typing_context: Any, target: Any, library: Any, *others: Any) -> None:
        library = _SealedLibrary(target.codegen(), "sealed kernel")
        library.enable_object_caching()
        super().__init__(typing_context, target, library, *others)

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile without garbage collection, which takes a tenth of the time and finds little."""
        collecting = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            if collecting:
                gc.enable()


class _PartLibrary(JITCodeLibrary):
    """LLVM code to be linked into kernels; it never becomes machine code by itself."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class _PartCompiler(Compiler):
    def __init__(self, typing_context: Any, target: Any, library: Any, *others: Any) -> None:
        library = _PartLibrary(target.codegen(), "part of a kernel")
        super().__init__(typing_context, target, library, *others)
        self.state.flags.no_compile = True


_NO_ENTRY = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class Part(CPUDispatcher):
    """A function that becomes machine code only in the kernels it is compiled into.

    Numba makes machine code and a Python entry for every function that a kernel calls, although
    only the kernel ever runs it; that takes a third of the compile time of a first run. When Python
    calls a part, as tests do, it is compiled `alone`.
    """

    def __init__(
        self,
        py_func: Callable[..., Any],
        locals: dict[str, Any] | None = None,  # noqa: A002 - Numba's name
        targetoptions: dict[str, Any] | None = None,
    ) -> None:
        options = {"nopython": True, **(targetoptions or {}), **_NO_ENTRY}
        super().__init__(py_func, locals, options, _PartCompiler)

    @cached_property
    def alone(self) -> Any:
        """The function with its own machine code and Python entry."""
        options = {**self.targetoptions, "no_cpython_wrapper": False}
        return CPUDispatcher(self.py_func, self.locals, options)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call the function from Python, compiled on its own."""
        return self.alone(*args, **kwargs)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Use one version for all constant arguments: optimisation inserts the constants anyway."""
        if "forceinline" not in self.targetoptions:
            args, kws = tuple(map(unliteral, args)), {k: unliteral(v) for k, v in kws.items()}
        return super().get_call_template(args, kws)

    def add_overload(self, result: Any) -> None:
        """Register the compiled code with its callers.

        Numba identifies a function by its entry point; without one, any unique object will do.
        """
        key = object()
        self.targetctx.insert_user_function(key, result.fndesc, [result.library])
        self.overloads[tuple(result.signature.args)] = result._replace(entry_point=key)
