"""The estimate of a run time: a ratio of totals, with an interval that keeps what it promises."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweeps.engine.cost import Costs, Estimate

# Two-sided 95 % quantiles of Student's distribution, from a table, by the degrees of freedom.
QUANTILES = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 7: 2.365, 10: 2.228}


def costs_of(points: np.ndarray, seconds: np.ndarray) -> Costs:
    costs = Costs()
    for number, time in zip(points.tolist(), seconds.tolist(), strict=True):
        costs.learn(number, time)
    return costs


@given(
    blocks=st.lists(st.tuples(st.integers(1, 1000), st.floats(1e-3, 1e3)), min_size=2, max_size=40),
    points=st.integers(0, 10**7),
    slots=st.integers(1, 64),
)
def test_the_time_is_that_of_the_ratio_of_totals(
    blocks: list[tuple[int, float]], points: int, slots: int
) -> None:
    size, seconds = np.array(blocks, dtype=float).T
    estimate = costs_of(size, seconds).estimate(points, slots)
    ratio = seconds.sum() / size.sum()
    assert estimate.seconds == pytest.approx(ratio * points / slots)
    residuals, count = seconds - ratio * size, len(size)
    deviation = np.sqrt((residuals**2).sum() * count / (count - 1)) / size.sum()
    quantile = QUANTILES.get(count - 1, 1.96 if count > 11 else None)
    if quantile:
        margin = quantile * deviation * points / slots
        # Equal costs leave the rounding of sums of squares.
        slack = 1e-2 * margin + 1e-6 * estimate.seconds
        assert estimate.high == pytest.approx(estimate.seconds + margin, abs=slack)
        assert estimate.low == pytest.approx(max(estimate.seconds - margin, 0.0), abs=slack)
    assert 0.0 <= estimate.low <= estimate.seconds <= estimate.high


def test_blocks_that_cost_the_same_leave_no_doubt() -> None:
    estimate = costs_of(np.full(5, 256), np.full(5, 0.5)).estimate(25_600, 2)
    assert estimate.seconds == pytest.approx(25.0)
    assert estimate.low == pytest.approx(25.0, rel=1e-6)
    assert estimate.high == pytest.approx(25.0, rel=1e-6)


@pytest.mark.parametrize("count", [2, 3, 5, 8, 11, 20])
def test_the_interval_holds_the_truth_about_95_times_of_100(count: int) -> None:
    rng, trials, hits = np.random.default_rng(count), 2000, 0
    for _ in range(trials):
        points = rng.integers(200, 300, size=count)
        seconds = 1e-3 * points * rng.normal(1.0, 0.2, size=count)
        estimate = costs_of(points, seconds).estimate(1_000_000, 4)
        hits += estimate.low <= 250.0 <= estimate.high
    # Student's quantile of 19 degrees of freedom, taken as normal, gives 93.5 %.
    assert 0.92 <= hits / trials <= 0.97


def test_blocks_of_very_different_cost_widen_the_interval_but_do_not_miss() -> None:
    rng, trials, hits = np.random.default_rng(1), 2000, 0
    for _ in range(trials):
        factor = rng.lognormal(0.0, 0.7, size=8)
        estimate = costs_of(np.full(8, 256), 0.1 * factor).estimate(256_000, 1)
        hits += estimate.low <= 100.0 * math.exp(0.7**2 / 2) <= estimate.high
    assert 0.85 <= hits / trials <= 0.97  # a skew distribution, of which eight blocks are seen


def test_one_block_gives_a_time_without_an_interval() -> None:
    estimate = costs_of(np.array([100]), np.array([2.0])).estimate(1000, 4)
    assert estimate == Estimate(5.0, 0.0, math.inf)
    assert str(estimate) == "about 5.0 s"


def test_no_block_gives_nothing() -> None:
    assert Costs().estimate(1000, 4) == Estimate(0.0, 0.0, math.inf)


def test_costs_add_up() -> None:
    costs = costs_of(np.array([100, 50]), np.array([2.0, 0.5]))
    assert (costs.blocks, costs.points, costs.seconds) == (2, 150, 2.5)


def test_an_estimate_reads_as_it_is_said() -> None:
    assert str(Estimate(95.0, 80.0, 110.0)) == "about 1 min 35 s (1 min 20 s to 1 min 50 s)"
