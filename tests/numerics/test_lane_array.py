"""Lanes in one flat array: every slot of every lane is a place of its own."""

import numpy as np

from stickslip.numerics.lane_array import aligned


def test_lanes_begin_with_a_cache_line() -> None:
    for size in (64, 1000):
        lanes = aligned(size)
        assert lanes.ctypes.data % 64 == 0
        assert np.array_equal(lanes, np.zeros(size))
