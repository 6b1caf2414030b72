"""Crossings are joined into lines, tested on shapes whose lines are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.bisecting import Model

from sweeps.borders.crossings import NO_KIND, Axis, Bisection, Crossings, Floats, Kinds, Line, Rims

Shape = Callable[[Floats], Kinds]


def joined(shape: Shape, size: int = 9, kinds: Kinds | None = None):
    """Lines, places of crossings, meetings and doubtful cells of a shape on the unit square."""
    axes = [Axis(np.linspace(0, 1, size))] * 2
    grid = np.stack(np.meshgrid(*(axis.values for axis in axes), indexing="ij"), axis=-1)
    kinds = shape(grid) if kinds is None else kinds

    found = Model(shape).bisect(Bisection(axes, kinds, grid[..., 0].copy(), 1e-9))
    places = found.places(axes)
    rims = Rims(kinds, found, places)
    doubtful = rims.doubtful()
    step = 1 / (size - 1)
    centres = shape((np.array(doubtful).reshape(-1, 2) + 0.5) * step).tolist()
    lines, meetings = rims.lines(dict(zip(doubtful, centres, strict=True)))
    middles = np.reshape([places[m].mean(axis=0) for m in meetings], (-1, 2))
    return lines, np.concatenate([places, middles]), meetings, doubtful


def rims_of(
    kinds: Kinds, axis: list[int], corner: list[list[int]], ends: list[list[int]], places: Floats
) -> Rims:
    """The rims of crossings at some places (n, axes), each with its edge and its ends."""
    numbers = np.zeros((len(axis), 2))
    edges = np.array(axis), np.array(corner), places, places, np.array(ends), numbers
    return Rims(kinds, Crossings(*edges), places)


def disc(centre: tuple[float, float], radius: float) -> Shape:
    return lambda p: (((p - np.array(centre)) ** 2).sum(axis=-1) < radius**2).astype(np.int64)


def on_the_left(shape: Shape, lines: list[Line], places: Floats, far: float = 0.02) -> None:
    """Assert that each straight part of each line has the right kinds on its left and right."""
    for line in lines:
        for begin, end in zip(line.points, line.points[1:], strict=False):
            along = places[end] - places[begin]
            length = np.linalg.norm(along)
            aside = np.array([-along[1], along[0]]) / length * min(far, length / 3)
            middle = (places[begin] + places[end]) / 2
            assert tuple(shape(np.array([middle + aside, middle - aside]))) == line.kinds


def test_a_disc_has_one_closed_line() -> None:
    shape = disc((0.47, 0.52), 0.3)
    (line,), places, meetings, doubtful = joined(shape)
    assert line.points[0] == line.points[-1]
    assert sorted(line.points[1:]) == list(range(len(places)))
    assert line.kinds == (0, 1)
    assert not meetings
    assert not doubtful
    on_the_left(shape, [line], places)


def test_an_open_line_goes_from_rim_to_rim() -> None:
    shape = lambda p: (p[..., 0] + 0.3 * p[..., 1] > 0.61).astype(np.int64)  # noqa: E731
    (line,), places, _, _ = joined(shape)
    ends = places[[line.points[0], line.points[-1]]]
    assert {0.0, 1.0} == set(ends[:, 1])
    on_the_left(shape, [line], places)


def test_three_kinds_meet_in_the_middle_of_their_crossings() -> None:
    def thirds(p: Floats) -> Kinds:
        angle = np.arctan2(p[..., 1] - 0.55, p[..., 0] - 0.45)
        return np.digitize(angle, [-1.5, 0.7])

    lines, places, meetings, _ = joined(thirds)
    assert len(meetings) == 1
    assert [line.kinds for line in lines] == [(0, 1), (0, 2), (1, 2)]
    meeting = len(places) - 1
    assert sum(meeting in (line.points[0], line.points[-1]) for line in lines) == 3
    assert np.linalg.norm(places[meeting] - [0.45, 0.55]) < 0.1


@pytest.mark.parametrize("centre", [0, 1, 2])
def test_the_centre_decides_a_saddle(centre: int) -> None:
    kinds = np.array([[0, 1], [1, 0]])
    axes = [Axis(np.array([0.0, 1.0]))] * 2

    def band(places: Floats) -> Kinds:
        total = places.sum(axis=1)
        return ((total > 0.5) & (total < 1.5)).astype(np.int64)

    found = Model(band).bisect(Bisection(axes, kinds, np.zeros((2, 2)), 1e-6))
    rims = Rims(kinds, found, found.places(axes))
    assert rims.doubtful() == [(0, 0)]
    lines, meetings = rims.lines({(0, 0): centre})
    if centre == 2:  # it says nothing
        assert len(meetings) == 1
        assert len(lines) == 4
        return
    assert len(lines) == 2
    cut_off = {(0, 0), (1, 1)} if centre == 1 else {(1, 0), (0, 1)}
    for line in lines:
        near = found.places(axes)[line.points].mean(axis=0)
        assert tuple(near.round()) in cut_off


def test_a_strip_thinner_than_a_cell_is_seen_where_it_splits_edges() -> None:
    def strip(p: Floats) -> Kinds:
        y = p[..., 1] - 0.03 * p[..., 0]
        return np.digitize(y, [0.55, 0.57])

    lines, places, _, _ = joined(strip)
    assert sorted(line.kinds for line in lines) == [(0, 1), (1, 2)]
    assert {len(line.points) for line in lines} == {9}
    on_the_left(strip, lines, places, 0.005)


def test_a_kind_that_comes_twice_at_a_rim_cuts_off_what_lies_between() -> None:
    kinds = np.array([[0, 0], [1, 2]])  # 0 at both points of smaller x
    places = np.array([[0.5, 0.0], [0.5, 1.0], [1.0, 0.5]])
    corner, ends = [[0, 0], [0, 1], [1, 0]], [[0, 1], [0, 2], [1, 2]]
    rims = rims_of(kinds, [0, 0, 1], corner, ends, places)
    assert rims.doubtful() == []
    # And now 0 between 1 and 2 as well.
    places = np.array([[0.5, 0.0], [0.5, 1.0], [1.0, 0.4], [1.0, 0.6]])
    corner, ends = [[0, 0], [0, 1], [1, 0], [1, 0]], [[0, 1], [0, 2], [1, 0], [0, 2]]
    rims = rims_of(kinds, [0, 0, 1, 1], corner, ends, places)
    assert rims.doubtful() == [(0, 0)]
    lines, meetings = rims.lines({(0, 0): 0})
    assert not meetings
    assert sorted((sorted(line.points), line.kinds) for line in lines) == [
        ([0, 2], (0, 1)),
        ([1, 3], (0, 2)),
    ]


def test_lines_end_beside_points_without_a_kind() -> None:
    shape = lambda p: (p[..., 0] > 0.43).astype(np.int64)  # noqa: E731 - short
    grid = np.linspace(0, 1, 9)
    kinds = np.repeat((grid > 0.43).astype(np.int64)[:, None], 9, axis=1)
    kinds[3, 4] = NO_KIND
    lines, _, _, _ = joined(shape, kinds=kinds)
    assert sorted(len(line.points) for line in lines) == [4, 4]


def test_crossings_of_one_axis_are_lines_of_a_point() -> None:
    kinds, places = np.array([0, 2, 1]), np.array([[1.5], [0.5]])
    rims = rims_of(kinds, [0, 0], [[1], [0]], [[2, 1], [0, 2]], places)
    lines, _ = rims.lines({})
    assert lines == [Line([1], (0, 2)), Line([0], (2, 1))]
