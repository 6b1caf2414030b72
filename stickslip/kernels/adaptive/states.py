"""States in lanes, rows and searches: small functions for each model of the strain."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.fields import make_map
from stickslip.compiled.simd import LANES
from stickslip.kernels.adaptive.recording import SLOTS, put
from stickslip.model.state import components_of
from stickslip.numerics.lane_array import lane_vectors


class StateFunctions(NamedTuple):
    """What is done with a state y of the lanes, as compiled functions."""

    get: Callable[..., Any]
    """(values, slot, lane): the state that begins in a slot."""

    put: Callable[..., None]
    """(values, slot, lane, y): write it."""

    begin_half: Callable[..., None]
    """(values, lane, y): put a lane at phase 0."""

    of_row: Callable[..., Any]
    """(row): the state held by the first numbers of a row."""

    mirrored: Callable[..., Any]
    """(y): the state half a period later in the mirror image of the motion."""

    judged: Callable[..., Any]
    """(y): the state as its repetition is judged."""

    unjudged: Callable[..., Any]
    """(z): the state that is judged as z."""

    moved: Callable[..., Any]
    """(y, dx, dv): the state shifted in x and u."""


@cache
def state_functions(strain: str) -> StateFunctions:
    """The functions for a model of the strain, one of `options.STRAINS`."""
    components = components_of(strain)
    width, numbered = len(components), list(enumerate(components))
    vectors = lane_vectors(LANES, width)
    put_state = vectors.put

    def made(name: str, arguments: str, values: list[str]) -> Any:
        return make_map(f"{name}[{width}]", arguments, values, {})

    judged = [
        f"{c.weight} * y[{i}]"
        if c.floor == -math.inf
        else f"{c.weight} * ({c.floor} if y[{i}] < {c.floor} else y[{i}])"  # NaN stays NaN
        for i, c in numbered
    ]
    with_plane = made("with_plane", "y, x, v", ["x", "v", *(f"y[{i}]" for i in range(2, width))])

    @jit
    def begin_half(values: np.ndarray, lane: int, y: Any) -> None:
        put_state(values, SLOTS.state, lane, y)
        put(values, SLOTS.time, lane, 0.0)

    @inline
    def moved(y: Any, dx: float, dv: float) -> Any:
        return with_plane(y, y[0] + dx, y[1] + dv)

    return StateFunctions(
        get=vectors.get,
        put=put_state,
        begin_half=begin_half,
        of_row=made("of_row", "row", [f"row[{i}]" for i in range(width)]),
        mirrored=made("mirrored", "y", [f"{c.mirror} * y[{i}]" for i, c in numbered]),
        judged=made("judged", "y", judged),
        unjudged=made("unjudged", "z", [f"z[{i}] / {c.weight}" for i, c in numbered]),
        moved=moved,
    )
