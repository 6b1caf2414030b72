"""Small functions of the state for the components of a model."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from stickslip.compiled.fields import make_map, make_tuple_reader
from stickslip.model.state import Component


class StateFunctions(NamedTuple):
    """Compiled operations on a state y in the units of a point."""

    of_row: Callable[..., Any]
    """(row) -> the state in the first numbers of a row."""

    mirrored: Callable[..., Any]
    """(y) -> the state half a period later in the mirror image of the motion."""

    judged: Callable[..., Any]
    """(y) -> the state in the weighted form in which its repetition is tested."""

    unjudged: Callable[..., Any]
    """(z) -> the state, the inverse of `judged`."""

    moved: Callable[..., Any]
    """(y, dx, du) -> the state shifted in x and u, with the components that follow them."""


@cache
def state_functions(components: tuple[Component, ...]) -> StateFunctions:
    """Return the operations on states of these components."""
    width, numbered = len(components), list(enumerate(components))

    def made(name: str, arguments: str, values: list[str]) -> Any:
        return make_map(f"{name}[{width}]", arguments, values, {})

    def judged(i: int, c: Component) -> str:
        value = f"y[{i}]" if c.follows < 0 else f"(y[{i}] - y[{c.follows}])"
        if c.floor > -math.inf:
            value = f"({c.floor} if {value} < {c.floor} else {value})"  # NaN stays NaN
        return f"{c.weight} * {value}"

    def unjudged(i: int, c: Component) -> str:
        value = f"z[{i}] / {c.weight}"
        return value if c.follows < 0 else f"{value} + {unjudged(c.follows, components[c.follows])}"

    shifts = {0: " + dx", 1: " + du", -1: ""}
    moved = [f"y[{i}]{shifts[i if i < 2 else c.follows]}" for i, c in numbered]

    return StateFunctions(
        of_row=make_tuple_reader(width),
        mirrored=made("mirrored", "y", [f"{c.mirror} * y[{i}]" for i, c in numbered]),
        judged=made("judged", "y", [judged(i, c) for i, c in numbered]),
        unjudged=made("unjudged", "z", [unjudged(i, c) for i, c in numbered]),
        moved=made("moved", "y, dx, du", moved),
    )
