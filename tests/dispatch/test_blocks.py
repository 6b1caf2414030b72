"""Points are dealt out once each, evenly over the grid, in blocks of about a second."""

from __future__ import annotations

import tracemalloc
from itertools import islice

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.dispatch.blocks import PILOT_BLOCKS, Blocks, Costs, pilot_blocks

costs = st.lists(st.tuples(st.integers(1, 500), st.floats(0.0, 1e4)), max_size=20)


def nothing(size: int) -> np.ndarray:
    return np.zeros(size, dtype=bool)


@given(
    size=st.integers(1, 20_000),
    part=st.floats(0.0, 1.0),
    slots=st.integers(1, 64),
    block_points=st.none() | st.integers(1, 30_000),
    learned=costs,
)
def test_every_missing_point_is_dealt_once(
    size: int,
    part: float,
    slots: int,
    block_points: int | None,
    learned: list[tuple[int, float]],
) -> None:
    done = np.random.default_rng(size).random(size) < part
    before, times = done.copy(), np.zeros(size, dtype=int)
    blocks = Blocks(done, slots, block_points=block_points)
    assert blocks.left == np.count_nonzero(~done)
    for block in blocks:
        assert len(block)
        assert (np.diff(block) > 0).all()
        times[block] += 1
        assert blocks.left == size - done.sum() - times.sum()
        if learned:
            blocks.learn(*learned.pop())
    np.testing.assert_array_equal(times, ~done)
    np.testing.assert_array_equal(done, before)


@pytest.mark.parametrize("block_points", [1, 7, 64, 999, 5000])
def test_a_fixed_size_is_kept_to_the_last_block(block_points: int) -> None:
    done = np.arange(2000) % 2 == 0
    sizes = [len(block) for block in Blocks(done, 3, block_points=block_points)]
    assert sizes[:-1] == [block_points] * (len(sizes) - 1)
    assert sum(sizes) == 1000


@given(
    cost=st.floats(1e-6, 100.0),
    slots=st.integers(1, 16),
    seconds=st.floats(0.5, 5.0),
)
def test_a_block_lasts_the_wanted_seconds_and_leaves_work_for_the_others(
    cost: float, slots: int, seconds: float
) -> None:
    size = 100_000
    blocks = Blocks(nothing(size), slots, seconds=seconds)
    for number, block in enumerate(islice(blocks, 30)):
        points, before = len(block), blocks.left + len(block)
        if number == 0:
            assert points == 256  # no cost is known yet
        else:
            fair = before // (2 * slots)
            wanted = int(seconds / cost * (1.0 + 1e-9))
            expected = min(wanted, fair, 16_384)
            assert abs(points - min(max(expected, 64), before)) <= 1
        blocks.learn(points, cost * points)


def test_the_cost_follows_the_finished_blocks() -> None:
    blocks = Blocks(nothing(10_000), 1)
    cut = iter(blocks)
    assert len(next(cut)) == 256
    blocks.learn(256, 2.56)  # 10 ms each
    assert len(next(cut)) == 100
    blocks.learn(100, 1.5)  # 15 ms each, halfway to 12.5 ms
    assert len(next(cut)) == 80


# --- evenly over the grid ---


def unevenness(points: np.ndarray, size: int) -> float:
    """Return the largest distance of the points' distribution function from a uniform one."""
    place = np.sort(points) / size
    share = np.arange(len(place)) / len(place)
    return float(np.abs(place - share).max())


@pytest.mark.parametrize("first", [0, 3, 9])
def test_any_tenth_of_the_order_is_spread_evenly_over_the_grid(first: int) -> None:
    relative = []
    for size in (*range(640, 20_000, 487), 65_536, 1_000_000, 1_234_567):
        tenth = list(Blocks(nothing(size), 1, block_points=-(-size // 10)))[first]
        runs = min(len(tenth), 1638)  # large grids are dealt in 16384 runs of neighbours
        relative.append(unevenness(tenth, size) * np.sqrt(runs))
    assert max(relative) < 2.0  # one random order in 1500 exceeds this


def test_the_beginning_of_the_order_is_spread_along_an_inner_axis_too() -> None:
    # Here a stride near the golden section of the grid would nearly repeat itself along this axis.
    outer, inner = 55, 474
    first = next(iter(Blocks(nothing(outer * inner), 1, block_points=64)))
    assert unevenness(first % inner, inner) * np.sqrt(64) < 2.0


@pytest.mark.parametrize("done", [0.5, 0.95])
def test_a_block_is_spread_evenly_over_what_is_missing(done: float) -> None:
    size = 200_000
    mask = np.random.default_rng(1).random(size) < done
    missing = np.flatnonzero(~mask)
    block = next(iter(Blocks(mask, 1, block_points=2000)))
    assert unevenness(np.searchsorted(missing, block), len(missing)) < 0.05


def test_a_large_grid_is_dealt_in_runs_of_neighbours() -> None:
    block = next(iter(Blocks(nothing(10_000_000), 1, block_points=12_200)))
    runs = np.split(block, np.flatnonzero(np.diff(block) > 1) + 1)
    assert {len(run) for run in runs} == {610}  # a 16384th of the grid
    assert len(runs) == 20


def test_the_order_is_the_same_every_time() -> None:
    def order() -> np.ndarray:
        return np.concatenate(list(Blocks(nothing(50_000), 2, block_points=700)))

    np.testing.assert_array_equal(order(), order())


def test_a_huge_grid_is_dealt_without_listing_it() -> None:
    done = nothing(10_000_000)
    tracemalloc.start()
    try:
        blocks = Blocks(done, 8)
        blocks.learn(1000, 0.1)
        dealt = sum(len(block) for block in islice(blocks, 100))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert dealt > 900_000
    assert most < 13e6  # little more than a byte for each point, where a list would take 80 MB


# --- the pilot ---


@given(size=st.integers(1, 5000), part=st.floats(0.0, 1.0), points=st.integers(1, 300))
def test_a_pilot_is_a_stratified_sample_of_what_is_missing(
    size: int, part: float, points: int
) -> None:
    done = np.random.default_rng(size).random(size) < part
    blocks = pilot_blocks(done, points)
    assert len(blocks) <= PILOT_BLOCKS
    drawn = np.concatenate([np.empty(0, dtype=np.int64), *blocks])
    assert len(np.unique(drawn)) == len(drawn)
    assert not done[drawn].any()
    assert all(0 < len(block) <= points for block in blocks)
    if part == 0.0:
        strata = min(size, PILOT_BLOCKS * points)
        assert len(drawn) == strata
        inner = np.arange(strata + 1) * size // strata  # exactly one in each
        assert (np.histogram(np.sort(drawn), bins=inner)[0] == 1).all()


def test_each_block_of_a_pilot_has_points_from_all_over_the_grid() -> None:
    blocks = pilot_blocks(nothing(100_000), 256)
    assert [len(block) for block in blocks] == [256] * PILOT_BLOCKS
    for block in blocks:
        assert unevenness(block, 100_000) < 1 / 256
    again = pilot_blocks(nothing(100_000), 256)
    assert all((one == two).all() for one, two in zip(blocks, again, strict=True))
    distance = np.diff(np.sort(np.concatenate(blocks)))
    assert len(np.unique(distance)) > 20  # random, since a periodic cost would deceive a lattice


# --- the cost ---


@given(
    blocks=st.lists(st.tuples(st.integers(1, 1000), st.floats(1e-3, 1e3)), min_size=1, max_size=40),
    points=st.integers(0, 10**7),
    slots=st.integers(1, 64),
)
def test_the_estimated_time_is_a_ratio_of_totals(
    blocks: list[tuple[int, float]], points: int, slots: int
) -> None:
    costs = Costs()
    assert costs.estimate(points, slots) == 0.0  # before any block
    for block in blocks:
        costs.learn(*block)
    sizes, seconds = zip(*blocks, strict=True)
    assert costs.points == sum(sizes)
    assert costs.seconds == pytest.approx(sum(seconds))
    expected = sum(seconds) / sum(sizes) * points / slots
    assert costs.estimate(points, slots) == pytest.approx(expected)
