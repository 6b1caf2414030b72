"""The grid: every index is the row of parameters that the nested loops would have reached."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.parameters import Parameters
from sweeps.config.load import from_mapping
from sweeps.grid import Grid

BOTH = {
    "model": {"M": 0.5},
    "sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"]},
    "cases": {"X_m": [4e-7, 8e-7], "omega": [20, 10]},
}


def rows(grid: Grid) -> list[Parameters]:
    return [Parameters(*row) for row in grid.points(0, grid.size)]


def test_the_last_dimension_runs_fastest() -> None:
    expected = [
        Parameters(
            block_mass=0.5,
            temperature=T,
            rheological_index=gamma,
            drive_amplitude=X_m,
            angular_frequency=omega,
        )
        for T in (150, 200, 250)
        for gamma in (0, 2 / 3)
        for X_m, omega in ((4e-7, 20), (8e-7, 10))
    ]
    assert rows(Grid.from_config(from_mapping(BOTH))) == expected


def test_coordinates_and_fixed_values_share_out_the_parameters() -> None:
    grid = Grid.from_config(from_mapping(BOTH))
    assert grid.coords["temperature"][0] == ("temperature",)
    assert grid.coords["drive_amplitude"][0] == ("case",)
    np.testing.assert_array_equal(grid.coords["angular_frequency"][1], [20.0, 10.0])
    dims, case = grid.coords["case"]
    assert (dims, case.dtype, case.tolist()) == (("case",), np.int32, [0, 1])
    named = [*(name for name in grid.coords if name != "case"), *grid.fixed]
    assert sorted(named) == sorted(Parameters._fields)
    assert grid.fixed["block_mass"] == 0.5


@pytest.mark.parametrize("mapping", [{}, {"model": {"T": 250}}])
def test_a_config_without_axes_is_one_point(mapping: dict[str, object]) -> None:
    config = from_mapping(mapping)
    grid = Grid.from_config(config)
    assert (grid.dims, grid.shape, grid.size, dict(grid.coords)) == ((), (), 1, {})
    assert rows(grid) == [config.parameters()]


@settings(max_examples=100, deadline=None)
@given(
    lengths=st.lists(st.integers(1, 5), max_size=4),
    cases=st.integers(0, 3),
    cut=st.floats(0, 1),
)
def test_any_cut_of_the_grid_is_the_product(lengths: list[int], cases: int, cut: float) -> None:
    names = ["T", "k", "K", "M"][: len(lengths)]
    axes = {name: [1.0 + i for i in range(n)] for name, n in zip(names, lengths, strict=True)}
    linked = {"omega": [1.0 + i for i in range(cases)]} if cases else {}
    grid = Grid.from_config(from_mapping({"sweep": axes, "cases": linked}))
    start = int(cut * grid.size)
    everything = np.concatenate([grid.points(0, start), grid.points(start, grid.size)])
    columns = [Parameters._fields.index(name) for name in grid.coords if name != "case"]
    product = list(itertools.product(*axes.values(), *linked.values()))
    np.testing.assert_array_equal(
        everything[:, columns], np.array(product).reshape(grid.size, len(columns))
    )


def test_a_huge_grid_costs_only_the_points_that_are_asked_for() -> None:
    axis = {"linspace": [1, 2], "num": 1000}
    grid = Grid.from_config(from_mapping({"sweep": {"T": axis, "M": axis, "K": axis}}))
    assert grid.size == 10**9  # rows of 176 GB
    (last,) = grid.points(10**9 - 1, 10**9)
    assert (Parameters(*last).temperature, Parameters(*last).spring_stiffness) == (2, 2)


def test_points_are_float64_rows_of_their_own() -> None:
    grid = Grid.from_config(from_mapping(BOTH))
    block = grid.points(2, 5)
    assert (block.shape, block.dtype, block.flags.c_contiguous) == (
        (3, len(Parameters._fields)),
        np.float64,
        True,
    )
    block[:] = 0
    assert grid.points(2, 5).any()
    assert grid.points(4, 4).shape == (0, len(Parameters._fields))


@pytest.mark.parametrize(("start", "stop"), [(-1, 3), (3, 2), (0, 13), (13, 13)])
def test_a_range_outside_the_grid_is_an_error(start: int, stop: int) -> None:
    with pytest.raises(IndexError, match="not within a grid of 12"):
        Grid.from_config(from_mapping(BOTH)).points(start, stop)


# --- points by their numbers ---


def test_rows_are_the_points_with_these_numbers_in_any_order() -> None:
    grid = Grid.from_config(from_mapping(BOTH))
    everything = grid.points(0, grid.size)
    numbers = np.array([11, 0, 3, 3, 7])
    np.testing.assert_array_equal(grid.rows(numbers), everything[numbers])
    assert grid.rows(numbers[:0]).shape == (0, len(Parameters._fields))


def test_a_grid_cannot_be_changed() -> None:
    grid = Grid.from_config(from_mapping(BOTH))
    with pytest.raises(ValueError, match="read-only"):
        grid.coords["temperature"][1][0] = 1
    with pytest.raises(TypeError):
        grid.fixed["block_mass"] = 1.0  # type: ignore[index]
