"""Lanes in a flat array (structure of arrays); every slot holds one number for each lane."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, jit_making_arrays
from stickslip.compiled.fields import make_function, make_map
from stickslip.numerics.linear import Vector


class LaneArray(NamedTuple):
    """Access to an array of lanes; inline functions."""

    get: Callable[..., float]
    """(values, slot, lane): return the number in a slot of a lane."""

    put: Callable[..., None]
    """(values, slot, lane, number): write it."""


@cache
def lane_array(lanes: int) -> LaneArray:
    """Return access to arrays of this many lanes."""

    @inline
    def get(values: np.ndarray, slot: int, lane: int) -> float:
        return values[slot * lanes + lane]

    @inline
    def put(values: np.ndarray, slot: int, lane: int, number: float) -> None:
        values[slot * lanes + lane] = number

    return LaneArray(get, put)


class LaneVectors(NamedTuple):
    """Access to vectors in consecutive slots; inline functions."""

    get: Callable[..., Vector]
    """(values, first, lane): return the vector that begins in the slot `first` of a lane."""

    put: Callable[..., None]
    """(values, first, lane, vector): write it."""


@cache
def lane_vectors(lanes: int, width: int) -> LaneVectors:
    """Return access to vectors of this width in arrays of this many lanes."""
    array = lane_array(lanes)
    name = f"[{lanes} lanes, {width}]"
    read = (f"get(values, first + {i}, lane)" for i in range(width))
    write = (f"put(values, first + {i}, lane, y[{i}])" for i in range(width))
    return LaneVectors(
        get=make_map(f"get_vector{name}", "values, first, lane", read, {"get": array.get}),
        put=make_function(f"put_vector{name}", "values, first, lane, y", write, {"put": array.put}),
    )


@jit_making_arrays
def aligned(size: int) -> np.ndarray:
    """Return zeros aligned to a cache line; vectors across two lines slow steps 1.3-fold."""
    line = 8
    room = np.zeros(size + line)
    first = -(room.ctypes.data // 8) % line
    return room[first : first + size]
