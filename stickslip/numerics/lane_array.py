"""Lanes in one flat array (structure of arrays): slot after slot, each with one number a lane."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.fields import make_function, make_map
from stickslip.numerics.linear import Vector


class LaneArray(NamedTuple):
    """Access to an array of so many lanes; inline functions."""

    lanes: int

    get: Callable[..., float]
    """(values, slot, lane): the number in a slot of a lane."""

    put: Callable[..., None]
    """(values, slot, lane, number): write it."""


@cache
def lane_array(lanes: int) -> LaneArray:
    """Access to arrays of so many lanes."""

    @inline
    def get(values: np.ndarray, slot: int, lane: int) -> float:
        return values[slot * lanes + lane]

    @inline
    def put(values: np.ndarray, slot: int, lane: int, number: float) -> None:
        values[slot * lanes + lane] = number

    return LaneArray(lanes, get, put)


class LaneVectors(NamedTuple):
    """Access to vectors that lie in neighbouring slots; inline functions."""

    get: Callable[..., Vector]
    """(values, first, lane): the vector that begins in the slot `first` of a lane."""

    put: Callable[..., None]
    """(values, first, lane, vector): write it."""


@cache
def lane_vectors(lanes: int, width: int) -> LaneVectors:
    """Access to vectors of so many components in arrays of so many lanes."""
    array = lane_array(lanes)
    name = f"[{lanes} lanes, {width}]"
    read = (f"get(values, first + {i}, lane)" for i in range(width))
    write = (f"put(values, first + {i}, lane, y[{i}])" for i in range(width))
    return LaneVectors(
        get=make_map(f"get_vector{name}", "values, first, lane", read, {"get": array.get}),
        put=make_function(f"put_vector{name}", "values, first, lane, y", write, {"put": array.put}),
    )


@jit
def aligned(size: int) -> np.ndarray:
    """Zeros from the beginning of a cache line: with vectors across two, a step takes 1.3 times."""
    line = 8
    room = np.zeros(size + line)
    first = -(room.ctypes.data // 8) % line
    return room[first : first + size]
