"""Lanes in one flat array: every slot of every lane is a place of its own."""

import numpy as np
import pytest

from stickslip.numerics.lane_array import aligned, lane_array, lane_vectors

LANES, SLOTS = 4, 7


def numbers() -> np.ndarray:
    return np.arange(float(SLOTS * LANES))


def test_slot_after_slot_with_one_number_a_lane() -> None:
    get, values = lane_array(LANES).get, numbers()
    table = values.reshape(SLOTS, LANES)
    for slot in range(SLOTS):
        for lane in range(LANES):
            assert get(values, slot, lane) == table[slot, lane]


def test_what_is_put_is_read_and_nothing_else_changes() -> None:
    array = lane_array(LANES)
    for slot, lane in ((0, 0), (3, 2), (SLOTS - 1, LANES - 1)):
        values = numbers()
        array.put(values, slot, lane, -1.0)
        assert array.get(values, slot, lane) == -1.0
        assert np.count_nonzero(values != numbers()) == 1


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_the_components_of_a_vector_lie_in_neighbouring_slots(width: int) -> None:
    vectors, values = lane_vectors(LANES, width), numbers()
    table = values.reshape(SLOTS, LANES)
    assert vectors.get(values, 2, 1) == tuple(table[2 : 2 + width, 1])
    y = tuple(-1.0 - i for i in range(width))
    vectors.put(values, 2, 1, y)
    assert vectors.get(values, 2, 1) == y
    assert np.count_nonzero(values != numbers()) == width


def test_lanes_begin_with_a_cache_line() -> None:
    for size in (64, 1000):
        lanes = aligned(size)
        assert lanes.ctypes.data % 64 == 0
        assert np.array_equal(lanes, np.zeros(size))
