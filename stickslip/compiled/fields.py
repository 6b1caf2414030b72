"""Compiled functions that are generated from a declaration, field by field.

Numba compiles neither `Tuple(*row)` nor keywords that are known only at run time. So we generate
the source of the function, as `dataclasses` does, and name every field in it. A missing value is
then an error when the function is made, and not a default that nobody notices.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from stickslip.compiled.decorators import inline


def make_tuple_maker(
    kind: Any, arguments: str, values: Mapping[str, str | float], names: Mapping[str, Any]
) -> Any:
    """Return an inline function of `arguments` that makes a `kind` from an expression per field.

    Parameters
    ----------
    kind
        A NamedTuple class.
    arguments
        The arguments of the function as in a definition, such as `row` or `p, s`.
    values
        For each field an expression in the arguments, or a number. A number becomes a literal, so
        that the compiler removes operations that a 0 or a 1 makes superfluous.
    names
        Other names that the expressions use.

    Raises
    ------
    TypeError
        A field without a value, or a value without a field.
    """
    if set(values) != set(kind._fields):
        wrong = sorted(set(values) ^ set(kind._fields))
        raise TypeError(f"{kind.__name__}: missing or unknown fields: {', '.join(wrong)}")
    # Numba allows no conditional among more than fifteen keywords, so each value has its own line.
    lines = [f"the_{field} = {values[field]!s}" for field in kind._fields]
    fields = ", ".join(f"the_{field}" for field in kind._fields)
    return make_function(
        f"make_{kind.__name__}[{_digest(values)}]",
        arguments,
        [*lines, f"return kind({fields})"],
        {"kind": kind} | dict(names),
    )


def make_row_reader(kind: Any) -> Any:
    """Return an inline function that makes a `kind` from the first numbers of an array."""
    values = {field: f"row[{i}]" for i, field in enumerate(kind._fields)}
    return make_tuple_maker(kind, "row", values, {})


def make_lane_reader(kind: Any, first: int, get: Callable[..., float]) -> Any:
    """Return an inline function of (lanes, lane) that makes a `kind` from the slots at `first`.

    `get(lanes, slot, lane)` reads a slot, as in `numerics.lane_array`.
    """
    values = {field: f"get(lanes, {first + i}, lane)" for i, field in enumerate(kind._fields)}
    return make_tuple_maker(kind, "lanes, lane", values, {"get": get})


def make_tuple_reader(width: int) -> Any:
    """Return an inline function of a row or tuple that returns its first elements as a tuple."""
    return make_map(f"read_tuple[{width}]", "row", (f"row[{i}]" for i in range(width)), {})


def make_map(name: str, arguments: str, components: Iterable[str], names: Mapping[str, Any]) -> Any:
    """Return an inline function of `arguments` that returns a tuple of these expressions."""
    return make_function(name, arguments, [f"return ({', '.join(components)},)"], names)


def make_function(name: str, arguments: str, lines: Iterable[str], names: Mapping[str, Any]) -> Any:
    """Return an inline function with these lines, which may use `names` besides the arguments."""
    scope, body = dict(names), "\n    ".join(lines)
    exec(f"def function({arguments}):\n    {body}\n", scope)
    function = scope["function"]
    function.__qualname__, function.__module__ = name, __name__
    return inline(function)


def _digest(values: Mapping[str, str | float]) -> str:
    """Return a digest that distinguishes functions that make the same class."""
    return hashlib.sha256(repr(sorted(values.items())).encode()).hexdigest()[:8]
