"""The bisection of edges finds the borders of plain shapes, which are known exactly."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from support.bisecting import Model

from sweeps.borders.crossings import NO_KIND, Axis, Bisection, Crossings, Floats, Kinds

CIRCLE = 0.6180339  # squared radius


def disc(places: Floats) -> Kinds:
    return ((places**2).sum(axis=-1) < CIRCLE).astype(np.int64)


def bisection_on(axes: list[Axis], model: Model, accuracy: float, pause: float = 0.0) -> Bisection:
    places = np.stack(np.meshgrid(*(axis.values for axis in axes), indexing="ij"), axis=-1)
    return Bisection(axes, model.kinds(places), places[..., 0].copy(), accuracy, pause)


def found_on(axes: list[Axis], model: Model, accuracy: float) -> Crossings:
    return model.bisect(bisection_on(axes, model, accuracy))


@pytest.fixture
def axes() -> list[Axis]:
    return [Axis(np.linspace(-1, 1, 8)), Axis(np.linspace(-1, 1.2, 8))]


def test_every_crossing_lies_on_the_border(axes: list[Axis]) -> None:
    model = Model(disc)
    found = found_on(axes, model, 1e-9)
    radii = (found.places(axes) ** 2).sum(axis=1)
    np.testing.assert_allclose(radii, CIRCLE, atol=1e-8)
    assert (found.widths(axes) <= 1e-9).all()
    assert (disc(found.low) == found.kinds[:, 0]).all()
    assert (disc(found.high) == found.kinds[:, 1]).all()
    np.testing.assert_array_equal(found.numbers, np.stack([found.low, found.high])[..., 0].T)
    assert len(set(model.calls)) == 1  # all edges at once
    assert len(model.calls) == np.ceil(np.log2(1 / 7 / 1e-9))


def test_one_of_the_coordinates_is_that_of_the_grid(axes: list[Axis]) -> None:
    found = found_on(axes, Model(disc), 1e-9)
    for axis, place in zip(found.axis, found.places(axes), strict=True):
        other = 1 - axis
        assert place[other] in axes[other].values


def test_a_third_kind_splits_an_edge() -> None:
    axes = [Axis(np.array([0.0, 1.0, 2.0]))]
    model = Model(lambda places: np.digitize(places[..., 0], [0.3, 0.6, 1.5]))
    found = found_on(axes, model, 1e-6)
    order = np.argsort(found.places(axes)[:, 0])
    np.testing.assert_allclose(found.places(axes)[order, 0], [0.3, 0.6, 1.5], atol=1e-6)
    assert found.kinds[order].tolist() == [[0, 1], [1, 2], [2, 3]]


def test_points_without_a_kind_make_no_edges() -> None:
    axes = [Axis(np.arange(4.0))]
    model = Model(lambda places: np.array([0, NO_KIND, 1, 0])[places[..., 0].astype(int)])
    found = model.bisect(Bisection(axes, np.array([0, NO_KIND, 1, 1]), np.zeros(4), 0.5))
    assert len(found) == 0


def test_a_middle_without_a_kind_ends_the_bisection_in_a_wide_bracket() -> None:
    axes = [Axis(np.array([0.0, 1.0]))]
    hole = 0.7

    def kinds(places: Floats) -> Kinds:
        x = places[..., 0]
        return np.where(np.abs(x - hole) < 0.1, NO_KIND, (x > hole).astype(np.int64))

    found = found_on(axes, Model(kinds), 1e-6)
    assert (found.low[0, 0], found.high[0, 0]) == (0.5, 1.0)
    assert found.kinds.tolist() == [[0, 1]]


def test_a_geometric_axis_is_bisected_on_its_own_scale() -> None:
    axes = [Axis(np.geomspace(1e-6, 1.0, 7), geometric=True)]
    model = Model(lambda places: (places[..., 0] > 3e-6).astype(np.int64))
    found = found_on(axes, model, 1e-7)
    assert found.places(axes)[0, 0] == pytest.approx(3e-6, rel=1e-6)
    assert len(model.calls) == np.ceil(np.log2(1 / 6 / 1e-7))


@pytest.mark.parametrize("most", [1, 3, 7])
def test_kinds_may_become_known_in_any_order(axes: list[Axis], most: int) -> None:
    at_once, one_by_one = (found_on(axes, Model(disc, n), 1e-6) for n in (None, most))
    for field in fields(Crossings):
        np.testing.assert_array_equal(*(getattr(f, field.name) for f in (at_once, one_by_one)))


def test_the_number_of_middles_left_is_known(axes: list[Axis]) -> None:
    model = Model(disc)
    bisection = bisection_on(axes, model, 1e-6)
    expected = bisection.left
    model.bisect(bisection)
    assert sum(model.calls) == expected == len(bisection)


def test_narrow_brackets_wait_until_the_bisection_resumes(axes: list[Axis]) -> None:
    model = Model(disc)
    bisection = bisection_on(axes, model, 1e-6, pause=1e-3)
    expected = bisection.left
    assert len(model.answer(bisection)) == 0
    assert bisection.left == expected - sum(model.calls)
    assert len(model.calls) == np.ceil(np.log2(1 / 7 / 1e-3))
    bisection.resume()
    found = model.bisect(bisection, first=sum(model.calls))
    at_once = found_on(axes, Model(disc), 1e-6)
    for field in fields(Crossings):
        np.testing.assert_array_equal(*(getattr(f, field.name) for f in (found, at_once)))
    assert sum(model.calls) == expected


def test_a_bracket_is_never_narrower_than_floats_allow() -> None:
    axes = [Axis(np.array([1e6, 1e6 + 1e-9]))]
    found = found_on(axes, Model(lambda places: (places[..., 0] > 1e6).astype(np.int64)), 1e-12)
    assert len(found) == 1
