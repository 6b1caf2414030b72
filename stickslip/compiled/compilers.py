"""What becomes of a compiled function: a sealed kernel, or a part of those that call it.

The private parts of Numba that are subclassed here are guarded by test_compilers.py and
test_symbols.py in tests/compiled: they fail where a new version of Numba changes them, which is why
pyproject.toml bounds that version above.
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
    """Machine code of which other code sees the entry alone.

    The functions inside become private before they are optimised. Internal would not be enough: the
    loader takes the copy of a function that it saw first for all weak ones of its name, internal
    ones included, and optimising changes how those want to be called, which crashes their callers.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = Linkage.private
        super()._optimize_final_module()


class SealedCompiler(Compiler):
    """Compiles a kernel with all that it calls into private code of its own.

    Numba keeps the functions that a kernel calls as weak symbols, of which a process uses the copy
    that it loaded first: the one compiled by itself after a compilation, some kernel's own after
    loading from the cache. The copies were optimised in different company and differ in the last
    bits, so that a first run gave other numbers than all later ones.
    """

    def __init__(self, typing_context: Any, target: Any, library: Any, *others: Any) -> None:
        library = _SealedLibrary(target.codegen(), "sealed kernel")
        library.enable_object_caching()
        super().__init__(typing_context, target, library, *others)

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile without collecting garbage: that takes a tenth of the time, and finds little."""
        collecting = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            if collecting:
                gc.enable()


class _PartLibrary(JITCodeLibrary):
    """Code in LLVM's language, to be linked into kernels; it never becomes machine code."""

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
    """A function whose machine code is that of the kernels it is compiled into.

    Numba makes machine code and a Python entry for every function that a kernel calls, though only
    the kernel ever runs it: a third of the time that a first run spends compiling. Called from
    Python, as tests do, a part is compiled `alone`.
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
        """The function with machine code and a Python entry."""
        options = {**self.targetoptions, "no_cpython_wrapper": False}
        return CPUDispatcher(self.py_func, self.locals, options)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """What the function returns, by code compiled for this call."""
        return self.alone(*args, **kwargs)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """As Numba's, but one version serves all constants, which optimising brings in."""
        if "forceinline" not in self.targetoptions:
            args, kws = tuple(map(unliteral, args)), {k: unliteral(v) for k, v in kws.items()}
        return super().get_call_template(args, kws)

    def add_overload(self, result: Any) -> None:
        """Makes what was compiled known to its callers.

        Numba knows a function by its entry point; without one, any object of its own will do.
        """
        key = object()
        self.targetctx.insert_user_function(key, result.fndesc, [result.library])
        self.overloads[tuple(result.signature.args)] = result._replace(entry_point=key)
