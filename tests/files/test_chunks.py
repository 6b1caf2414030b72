"""Chunks: ranges of points without a gap that are boxes of the result's array."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweeps.files.chunks import CHUNK_POINTS, Chunks

shapes = st.lists(st.integers(1, 7), max_size=5).map(tuple)
sizes = st.integers(1, 200)


@given(shape=shapes, most=sizes)
def test_slabs_share_out_the_points_in_order_and_without_a_gap(
    shape: tuple[int, ...], most: int
) -> None:
    chunks, size = Chunks(shape, most), math.prod(shape)
    ranges = [chunks.range(number) for number in range(len(chunks))]
    assert [begin for begin, _ in ranges] == [0, *(end for _, end in ranges[:-1])]
    assert ranges[-1][1] == size
    assert all(0 < end - begin <= most for begin, end in ranges)


@given(shape=shapes, most=sizes)
def test_a_slab_is_a_box_of_the_array(shape: tuple[int, ...], most: int) -> None:
    chunks = Chunks(shape, most)
    points = np.arange(math.prod(shape)).reshape(shape)
    for number in range(len(chunks)):
        box = points[chunks.box(number)]
        assert box.shape == chunks.shape(number)
        assert all(
            length <= most for length, most in zip(chunks.shape(number), chunks.extent, strict=True)
        )
        np.testing.assert_array_equal(np.ravel(box), np.arange(*chunks.range(number)))


@given(shape=shapes, most=sizes)
def test_each_point_knows_its_slab(shape: tuple[int, ...], most: int) -> None:
    chunks = Chunks(shape, most)
    expected = [
        number for number in range(len(chunks)) for _ in range(*chunks.range(number))
    ]  # the numbers, each as often as it has points
    found = chunks.of(np.arange(math.prod(shape)))
    np.testing.assert_array_equal(found, expected)


@given(shape=shapes, most=sizes)
def test_every_slab_is_one_chunk_of_a_file(shape: tuple[int, ...], most: int) -> None:
    chunks = Chunks(shape, most)
    assert len(chunks.extent) == len(shape)
    assert len(chunks) == math.prod(
        -(-length // chunk) for length, chunk in zip(shape, chunks.extent, strict=True)
    )
    for number in range(len(chunks)):
        for part, chunk in zip(chunks.box(number), chunks.extent, strict=True):
            assert (part.start or 0) % chunk == 0
    assert chunks.shape(0) == chunks.extent


@given(shape=shapes, most=sizes)
def test_slabs_are_no_smaller_than_they_must_be(shape: tuple[int, ...], most: int) -> None:
    chunks, size = Chunks(shape, most), math.prod(shape)
    if size <= most:
        assert len(chunks) == 1
    else:
        begin, end = chunks.range(0)
        thicker = [
            math.prod(shape[axis + 1 :]) * (chunks.extent[axis] + 1)
            for axis, length in enumerate(shape)
            if chunks.extent[axis] < length
        ]
        assert min(thicker) > most
        assert end - begin == math.prod(chunks.extent)


@pytest.mark.parametrize(
    ("shape", "most", "chunk", "count"),
    [
        ((), 1, (), 1),
        ((1,), 1, (1,), 1),
        ((10,), 3, (3,), 4),
        ((4, 5, 6), 120, (4, 5, 6), 1),
        ((4, 5, 6), 119, (3, 5, 6), 2),
        ((4, 5, 6), 30, (1, 5, 6), 4),
        ((4, 5, 6), 29, (1, 4, 6), 8),
        ((4, 5, 6), 1, (1, 1, 1), 120),
        ((1000, 1000, 1000), CHUNK_POINTS, (1, 131, 1000), 8000),
    ],
)
def test_slabs_of_some_grids(
    shape: tuple[int, ...], most: int, chunk: tuple[int, ...], count: int
) -> None:
    chunks = Chunks(shape, most)
    assert (chunks.extent, len(chunks)) == (chunk, count)
    assert chunks.range(count - 1)[1] == math.prod(shape)
