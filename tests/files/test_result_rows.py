"""Result rows: their values in a file, and chunks, which are boxes of its array."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.datasets import result_values
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS
from sweeps.files.result_rows import CHUNK_POINTS, STATUS, STATUS_CODES, Chunks, status_counts

shapes = st.lists(st.integers(1, 7), max_size=5).map(tuple)
sizes = st.integers(1, 200)


@given(shape=shapes, most=sizes)
def test_chunks_share_out_the_points_in_order_as_boxes_of_the_array(
    shape: tuple[int, ...], most: int
) -> None:
    chunks, end = Chunks(shape, most), 0
    points = np.arange(math.prod(shape)).reshape(shape)
    for number in range(len(chunks)):
        begin, end = end, chunks.range(number)[1]
        assert chunks.range(number)[0] == begin
        assert 0 < end - begin <= most
        box = points[chunks.box(number)]
        assert box.shape == chunks.shape(number)
        np.testing.assert_array_equal(np.ravel(box), np.arange(begin, end))
        # It is one chunk of a file.
        for part, length, extent in zip(chunks.box(number), box.shape, chunks.extent, strict=True):
            assert (part.start or 0) % extent == 0
            assert length <= extent
    assert end == points.size
    assert chunks.shape(0) == chunks.extent


@given(shape=shapes, most=sizes)
def test_chunks_are_no_smaller_than_they_must_be(shape: tuple[int, ...], most: int) -> None:
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
def test_chunks_of_some_grids(
    shape: tuple[int, ...], most: int, chunk: tuple[int, ...], count: int
) -> None:
    chunks = Chunks(shape, most)
    assert (chunks.extent, len(chunks)) == (chunk, count)
    assert chunks.range(count - 1)[1] == math.prod(shape)


@pytest.mark.parametrize("name", RESULT_COLUMNS)
def test_a_point_that_is_not_computed_has_the_missing_value_of_its_variable(name: str) -> None:
    found = result_values(name, np.array([np.nan, 3.0]))
    assert found.dtype.str[1:] == RESULTS[name].dtype
    np.testing.assert_array_equal(found, [RESULTS[name].missing, 3])


def test_the_sign_of_a_nan_stays() -> None:
    column = np.array([np.copysign(np.nan, -1.0)])
    assert result_values("asymmetry", column).tobytes() == column.tobytes()


def test_statuses_are_counted_by_code() -> None:
    counts = status_counts(np.array([[0, 0, 5], [127, 1, 0]], dtype=np.int8))
    assert counts.shape == (STATUS_CODES,)
    assert counts[[0, 1, 5, Status.PENDING]].tolist() == [3, 1, 1, 1]
    assert RESULT_COLUMNS[STATUS] == "status"
