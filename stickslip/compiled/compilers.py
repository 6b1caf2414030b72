"""Compilers for the two kinds of compiled functions, sealed kernels and the parts that they call.

The classes here extend private parts of Numba. If a new version of Numba changes those,
tests/compiled/test_compilers.py fails; therefore pyproject.toml sets an upper bound on the version.
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
    enough. For all weak functions of a name, even internal ones, the loader takes the first copy
    that it sees. Optimisation changes their calling conventions, so that a caller of the wrong copy
    crashes.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                function.linkage = Linkage.private
        super()._optimize_final_module()


class SealedCompiler(Compiler):
    """Compiles a kernel and everything that it calls into private code.

    Numba keeps the functions that a kernel calls as weak symbols, of which a process uses the copy
    that it loaded first. After a compilation this is the copy compiled separately; after loading
    from the cache it comes from one of the kernels. The copies were optimised in different contexts
    and differ in the last bits, so a first run gave different numbers from all later ones.
    """

    def __init__(self, typing_context: Any, target: Any, library: Any, *others: Any) -> None:
        library = _SealedLibrary(target.codegen(), "sealed kernel")
        library.enable_object_caching()
        super().__init__(typing_context, target, library, *others)

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Compile without garbage collection, which takes a tenth of the time and frees little."""
        collecting = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            if collecting:
                gc.enable()


class _PartLibrary(JITCodeLibrary):
    """LLVM code that is linked into kernels and never becomes separate machine code."""

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
    """A function that becomes machine code only inside the kernels that call it.

    Numba would make machine code and a Python entry for every such function, although only the
    kernel runs it. That takes a third of the compile time of a first run. When Python calls a part,
    as tests do, the part is compiled `alone`.
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
        """The function compiled with a Python entry."""
        options = {**self.targetoptions, "no_cpython_wrapper": False}
        return CPUDispatcher(self.py_func, self.locals, options)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call the function from Python."""
        return self.alone(*args, **kwargs)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Use one version for all constant arguments, as optimisation inserts them anyway."""
        if "forceinline" not in self.targetoptions:
            args, kws = tuple(map(unliteral, args)), {k: unliteral(v) for k, v in kws.items()}
        return super().get_call_template(args, kws)

    def add_overload(self, result: Any) -> None:
        """Register the compiled code with its callers.

        Numba identifies a function by its entry point. A part has none, but any unique object will
        do.
        """
        key = object()
        self.targetctx.insert_user_function(key, result.fndesc, [result.library])
        self.overloads[tuple(result.signature.args)] = result._replace(entry_point=key)
