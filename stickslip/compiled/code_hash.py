"""A hash of what functions do, from their code and the functions and numbers that it refers to."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dis import get_instructions
from types import CodeType, FunctionType, ModuleType
from typing import Any

from numba.core.dispatcher import Dispatcher

_MODULES = ("math", "numpy", "numba", "stickslip")  # their versions are accounted for elsewhere
_PLAIN = (int, float, str, bytes, type(None), type(Ellipsis))


def code_hash(functions: Iterable[Any]) -> str:
    """Return the hexadecimal SHA-256 of functions, plain or compiled by Numba.

    It changes with their code, their defaults, and the functions and numbers that they refer to. It
    also differs between versions of Python.

    Raises TypeError with the name of a reference to anything else, which may change unnoticed.
    """
    digest, seen = hashlib.sha256(), dict[int, int]()
    for function in functions:  # the flags of the law's own functions do not count: we set them
        _take(digest, getattr(function, "py_func", function), "a function of the law", seen)
    return digest.hexdigest()


def _take(digest: Any, value: Any, name: str, seen: dict[int, int]) -> None:
    """Add a value to the hash; a function only once, with everything that it refers to.

    Later it is added by its number in `seen`, which tells it from the other functions there.
    """
    if isinstance(value, Dispatcher):
        flags = {k: sorted(v) if isinstance(v, set) else v for k, v in value.targetoptions.items()}
        digest.update(repr(sorted(flags.items())).encode())
        value = value.py_func
    home = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
    if isinstance(value, _PLAIN):
        digest.update(f"{type(value).__name__} {value!r}\0".encode())
    elif isinstance(value, (tuple, frozenset)):
        digest.update(f"{len(value)} values\0".encode())
        for each in value if isinstance(value, tuple) else sorted(value, key=repr):
            _take(digest, each, name, seen)
    elif isinstance(value, CodeType):
        digest.update(value.co_code + repr((value.co_names, value.co_varnames)).encode())
        _take(digest, value.co_consts, name, seen)
    elif str(home).partition(".")[0] in _MODULES:
        digest.update(f"{home} {getattr(value, '__qualname__', '')}\0".encode())
    elif not isinstance(value, FunctionType):
        raise TypeError(
            f"{name} is of type {type(value).__name__}; a law may refer to numbers, tuples, "
            f"functions, and the modules {', '.join(_MODULES)}"
        )
    elif id(value) in seen:
        digest.update(f"function {seen[id(value)]}\0".encode())
    else:
        seen[id(value)] = len(seen)
        _take(digest, value.__code__, name, seen)
        _take(digest, value.__defaults__ or (), name, seen)
        cells = zip(value.__code__.co_freevars, value.__closure__ or (), strict=True)
        inner = {name: cell.cell_contents for name, cell in cells}
        outer = {n: value.__globals__[n] for n in _names(value.__code__) if n in value.__globals__}
        for each, referred in sorted((outer | inner).items()):
            digest.update(f"{each}\0".encode())
            _take(digest, referred, f"`{each}`, to which {value.__name__} refers,", seen)


def _names(code: CodeType) -> set[str]:
    """Return the global names that code refers to, including the functions inside it."""
    loaded = {each.argval for each in get_instructions(code) if each.opname == "LOAD_GLOBAL"}
    inside = [constant for constant in code.co_consts if isinstance(constant, CodeType)]
    return loaded.union(*map(_names, inside))
