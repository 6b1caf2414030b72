"""Edges of maps are bisected to the borders of plain shapes, which are known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from sweeps.views.boundaries.bisection import LATE, NO_KIND, Axis, Floats, Kinds, crossings

CIRCLE = 0.6180339  # squared radius


def disc(places: Floats) -> Kinds:
    return ((places**2).sum(axis=-1) < CIRCLE).astype(np.int64)


class Model:
    """Kinds of places, and how they were asked for."""

    def __init__(self, kinds=disc, late=lambda places: np.zeros(len(places), bool)) -> None:
        self.kinds, self.late = kinds, late
        self.calls: list[tuple[int, bool]] = []

    def look(self, places: Floats, patient: bool) -> tuple[Kinds, Floats]:
        self.calls.append((len(places), patient))
        kinds = self.kinds(places)
        hidden = np.full(len(places), not patient) & self.late(places)
        return np.where(hidden, LATE, kinds), places[:, 0].copy()


def found_on(axes, model: Model, accuracy: float):
    places = np.stack(np.meshgrid(*(axis.values for axis in axes), indexing="ij"), axis=-1)
    return crossings(axes, model.kinds(places), places[..., 0].copy(), model.look, accuracy)


@pytest.fixture
def axes() -> list[Axis]:
    return [Axis(np.linspace(-1, 1, 8)), Axis(np.linspace(-1, 1.2, 8))]


def test_every_crossing_lies_on_the_border(axes: list[Axis]) -> None:
    model = Model()
    found = found_on(axes, model, 1e-9)
    radii = (found.places(axes) ** 2).sum(axis=1)
    np.testing.assert_allclose(radii, CIRCLE, atol=1e-8)
    assert (found.widths(axes) <= 1e-9).all()
    assert (disc(found.low) == found.kinds[:, 0]).all()
    assert (disc(found.high) == found.kinds[:, 1]).all()
    np.testing.assert_array_equal(found.numbers, np.stack([found.low, found.high])[..., 0].T)
    assert len({count for count, _ in model.calls}) == 1  # all edges at once
    assert len(model.calls) == np.ceil(np.log2(1 / 7 / 1e-9))


def test_one_of_the_coordinates_is_that_of_the_grid(axes: list[Axis]) -> None:
    found = found_on(axes, Model(), 1e-9)
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
    found = crossings(axes, np.array([0, NO_KIND, 1, 1]), np.zeros(4), model.look, 0.5)
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


def test_what_is_late_waits_for_the_rest_and_comes_out_the_same(axes: list[Axis]) -> None:
    plain = found_on(axes, Model(), 1e-6)
    model = Model(late=lambda places: places[:, 1] > 0.2)
    found = found_on(axes, model, 1e-6)
    both = [np.sort(each.places(axes).view("f8,f8"), axis=0) for each in (plain, found)]
    np.testing.assert_array_equal(*both)
    patient = [place for place, (_, is_patient) in enumerate(model.calls) if is_patient]
    assert patient[0] > 3  # not before all others are done
    assert model.calls[patient[0]][0] > 1


def test_a_bracket_is_never_narrower_than_floats_allow() -> None:
    axes = [Axis(np.array([1e6, 1e6 + 1e-9]))]
    found = found_on(axes, Model(lambda places: (places[..., 0] > 1e6).astype(np.int64)), 1e-12)
    assert len(found) == 1
