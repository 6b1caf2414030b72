"""Blocks of points over threads: each point once, from its own parameters, taking none along."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip import Options, Status, kernels, orbit
from stickslip.kernels import RESULT_COLUMNS
from stickslip.orbit import compute_orbits, failed_row
from sweeps import execute
from sweeps.config import from_mapping
from sweeps.execute import Block, BlockSizes, compile_kernels, compute
from sweeps.grid import Grid

# Different lubricants and temperatures, so that neighbours in a block differ in cost.
GRID = Grid.from_config(
    from_mapping({"sweep": {"T": [180, 220, 260, 300], "gamma": [-2 / 3, 0, 2 / 3]}})
)
OPTIONS = Options(rtol=1e-4, stationary_rtol=1e-4)


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    results = compute(GRID, OPTIONS, workers=1)
    assert np.all(results[:, -1] == Status.OK)
    return results


@pytest.mark.parametrize("workers", [1, 2, 8])
@pytest.mark.parametrize("block_points", [1, 3, None, 100])
def test_numbers_depend_neither_on_workers_nor_on_blocks(
    reference: np.ndarray, workers: int, block_points: int | None
) -> None:
    results = compute(GRID, OPTIONS, workers=workers, block_points=block_points)
    assert results.tobytes() == reference.tobytes()


def test_a_point_does_not_depend_on_its_neighbours(reference: np.ndarray) -> None:
    points = GRID.points(0, GRID.size)
    alone = np.array([compute_orbits(point, OPTIONS)[0][0] for point in points])
    assert alone.tobytes() == reference.tobytes()
    backwards = compute_orbits(points[::-1], OPTIONS)[0][::-1]
    assert backwards.tobytes() == reference.tobytes()
    among_copies = compute_orbits(np.repeat(points, 3, axis=0), OPTIONS)[0]
    assert among_copies.tobytes() == np.repeat(reference, 3, axis=0).tobytes()


@pytest.mark.parametrize("workers", [1, 2, 8])
def test_each_block_is_reported_once_in_the_calling_thread(
    reference: np.ndarray, workers: int
) -> None:
    blocks: list[Block] = []

    def take(block: Block) -> None:
        assert threading.current_thread() is threading.main_thread()
        blocks.append(block)

    compute(GRID, OPTIONS, workers=workers, block_points=5, on_block=take)
    blocks.sort(key=lambda block: block.start)
    assert [(block.start, len(block.results)) for block in blocks] == [(0, 5), (5, 5), (10, 2)]
    assert np.concatenate([block.results for block in blocks]).tobytes() == reference.tobytes()
    assert [block.failures for block in blocks] == [0, 0, 0]
    assert all(block.seconds >= 0.0 for block in blocks)


def test_failures_of_a_block_are_the_points_that_are_not_ok() -> None:
    rows = np.zeros((7, len(RESULT_COLUMNS)))
    rows[:, -1] = [0, 1, 2, 3, 4, 5, 0]
    assert Block(0, rows, 1.0).failures == 5


# --- exceptions ---


def poisoned(temperature: float) -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """`compute_orbits`, which raises where a point has this temperature."""

    def compute_some(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
        if np.any(np.atleast_2d(points)[:, 0] == temperature):
            raise ZeroDivisionError("poison")
        return compute_orbits(points, options)

    return compute_some


@pytest.mark.parametrize("block_points", [None, 1, 5])
@pytest.mark.parametrize("workers", [1, 2])
def test_an_exception_costs_its_own_points_alone(
    reference: np.ndarray,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    workers: int,
    block_points: int | None,
) -> None:
    monkeypatch.setattr(execute, "compute_orbits", poisoned(260.0))
    results = compute(GRID, OPTIONS, workers=workers, block_points=block_points)
    lost = GRID.points(0, GRID.size)[:, 0] == 260.0
    assert results[~lost].tobytes() == reference[~lost].tobytes()
    assert lost.sum() == 3
    for row in results[lost]:
        np.testing.assert_array_equal(row, failed_row())
        assert row[-1] == Status.FAILED
    told = [record for record in caplog.records if "computation of point" in record.message]
    assert told
    assert all(record.levelname == "ERROR" and not record.exc_info for record in told)
    assert "ZeroDivisionError('poison')" in caplog.text
    for point in GRID.points(0, GRID.size)[lost]:
        assert str(point.tolist()) in caplog.text  # which one it was


def test_ctrl_c_is_no_failed_point(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(points: np.ndarray, options: Options) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(execute, "compute_orbits", interrupted)
    with pytest.raises(KeyboardInterrupt):
        compute(GRID, OPTIONS, workers=1)


def test_lost_blocks_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    class Careless:
        def __init__(self, **settings: object) -> None: ...

        def __call__(self, tasks):
            for number, (function, args, keywords) in enumerate(tasks):
                if number != 1:
                    yield function(*args, **keywords)

    monkeypatch.setattr(execute, "Parallel", Careless)
    with pytest.raises(RuntimeError, match="only 7 of 12 points"):
        compute(GRID, OPTIONS, workers=1, block_points=5)


def test_kernels_are_made_ready_for_the_fluids_of_the_grid(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = []

    def observed(gammas: np.ndarray, settings: kernels.Settings) -> None:
        asked.append((set(np.ravel(gammas).tolist()), settings.rtol))

    monkeypatch.setattr(kernels, "compile_lanes", observed)
    compile_kernels(OPTIONS, GRID)
    assert asked == [({-2 / 3, 0.0, 2 / 3}, OPTIONS.rtol)]


def test_the_fixed_step_is_made_ready_without_a_point(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def observed(points: np.ndarray, options: Options) -> tuple[np.ndarray, np.ndarray]:
        asked.append((points.shape, options.method))
        return compute_orbits(points, options)

    monkeypatch.setattr(orbit, "compute_orbits", observed)
    compile_kernels(Options(method="euler-cromer"), GRID)
    assert asked == [((0, 20), "euler-cromer")]


# --- how the blocks are cut ---

costs = st.floats(min_value=0.0, max_value=1e4)


def block_of(points: int, seconds: float) -> Block:
    return Block(0, np.zeros((points, 13)), seconds)


@given(
    size=st.integers(0, 20_000),
    workers=st.integers(1, 64),
    block_points=st.none() | st.integers(1, 30_000),
    learned=st.lists(costs, max_size=20),
)
def test_blocks_cover_the_grid_once_and_in_order(
    size: int, workers: int, block_points: int | None, learned: list[float]
) -> None:
    sizes = BlockSizes(size, workers, block_points)
    expected = 0
    for start, stop in sizes:
        assert start == expected < stop <= size
        if block_points is not None:
            assert stop - start == min(block_points, size - start)
        assert stop - start <= max(65_536, block_points or 0)
        expected = stop
        if learned:
            sizes.learn(block_of(stop - start, learned.pop()))
    assert expected == size


@given(cost=st.floats(min_value=1e-6, max_value=100.0), workers=st.integers(1, 16))
def test_a_block_lasts_about_a_second_and_leaves_work_for_the_others(
    cost: float, workers: int
) -> None:
    sizes, size = BlockSizes(100_000, workers), 100_000
    for number, (start, stop) in enumerate(sizes):
        if number == 0:
            assert stop - start == 256  # nothing is known yet
        else:
            # ... but not fewer than keep the lanes of a kernel busy, as long as there are any.
            least = min(64, size - start)
            assert (stop - start) * cost <= 1.0 or stop - start == least
            assert stop - start <= max(least, (size - start) // (2 * workers))
        if number == 1 and cost < 1e-4:
            assert stop - start > 1000  # what is cheap is handed out in bulk
        if number == 30:
            break
        sizes.learn(block_of(stop - start, cost * (stop - start)))


def test_the_cost_follows_what_is_seen() -> None:
    sizes = BlockSizes(10_000, 1)
    steps = iter(sizes)
    assert next(steps) == (0, 256)
    sizes.learn(block_of(256, 2.56))  # 10 ms each
    assert next(steps) == (256, 356)
    sizes.learn(block_of(100, 1.5))  # 15 ms each, halfway to 12.5 ms
    assert next(steps) == (356, 436)
