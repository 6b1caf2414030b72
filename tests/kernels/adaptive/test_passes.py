"""A pass gives the same bits as a whole, in portions or half period by half period."""

from __future__ import annotations

import numpy as np
import pytest
from support.points import rows

from stickslip import Status
from stickslip.kernels.adaptive import passes
from stickslip.kernels.families import Family
from stickslip.kernels.orbits.motions import (
    AHEAD,
    ATTEMPTED,
    CYCLE,
    DONE,
    OUTCOME,
    Motions,
    motions_of,
)
from stickslip.options import DEFAULTS

PHYSICS = DEFAULTS.physics
PSEUDOPLASTIC = Family(PHYSICS, -2 / 3)
POINTS = rows("temperature", np.linspace(180.0, 290.0, 21))


def worked(task: passes.Pass, attempts: int) -> tuple[Motions, int]:
    """Return pseudoplastic motions after a pass in portions of `attempts`, and the call count."""
    kernel, more = passes.pass_kernel(PSEUDOPLASTIC), np.arange(len(POINTS))
    motions, lanes, calls = motions_of(POINTS, PHYSICS), passes.new_lanes(3, len(POINTS)), 0
    left, ended = len(POINTS), []
    motions.rtols[:], motions.counts[:, CYCLE] = 1e-4, 3
    while left > 0:
        previous = left
        left = kernel(motions, more, lanes, task, attempts)
        more, calls = more[:0], calls + 1
        count = lanes.counts[passes.ENDED]
        assert left == previous - count
        ended += lanes.ended[:count].tolist()
    assert kernel(motions, more, lanes, task, attempts) == 0
    assert sorted(ended) == list(range(len(POINTS)))
    return motions, calls


@pytest.mark.parametrize("mode", [passes.TRAVEL, passes.MEASURE, passes.VARY])
def test_a_pass_in_portions_gives_the_same_bits(mode: int) -> None:
    task = passes.Pass(mode, 0, 1_000_000)
    whole, few = worked(task, 10**9)
    assert np.all(whole.counts[:, OUTCOME] == Status.OK)
    for attempts in (1, 7, 1000):
        pieces, calls = worked(task, attempts)
        assert calls > few
        for ours, theirs in zip(pieces, whole, strict=True):
            np.testing.assert_array_equal(ours, theirs, strict=True)


def after_search_pass(ahead: int, times: int) -> np.ndarray:
    """Return the last row of `ahead`, (n, columns), after passes of `ahead` half periods each."""
    motions, order = motions_of(POINTS, PHYSICS), np.random.default_rng(1)
    motions.rtols[:], motions.counts[:, AHEAD] = 1e-4, ahead
    last, width = motions.ahead[:, ahead - 1], motions.width
    for _ in range(times):
        way = passes.InLanes(motions, PSEUDOPLASTIC, passes.Pass(passes.SEARCH, 0, 1_000_000))
        way.finish(order.permutation(len(POINTS)))  # in any order
        assert (motions.counts[:, DONE] == ahead).all()
        motions.states[:], motions.control[:] = last[:, : width + 1], last[:, width + 1 : width + 3]
    return last[:, :-1].copy()


def test_a_motion_that_is_cut_into_half_periods_has_the_same_bits() -> None:
    whole = after_search_pass(8, 1)
    for ahead in (1, 2, 4):
        cut = after_search_pass(ahead, 8 // ahead)
        np.testing.assert_array_equal(cut, whole, strict=True)


def test_a_search_learns_every_half_period_before_a_failure() -> None:
    motions = motions_of(POINTS, PHYSICS)
    motions.rtols[:], motions.counts[:, AHEAD] = 1e-4, 8
    task = passes.Pass(passes.SEARCH, 0, 300)
    passes.InLanes(motions, PSEUDOPLASTIC, task).finish(np.arange(len(POINTS)))
    assert (motions.counts[:, OUTCOME] == Status.STEP_LIMIT).all()
    done = motions.counts[:, DONE]
    assert 0 < done.max() < 8
    attempts = motions.ahead[..., -1]
    for row, count in enumerate(done):
        assert (np.diff(attempts[row, : count + 1]) > 0).all()
        assert attempts[row, count] == 300
        assert (attempts[row, count + 1 :] == 0).all()


def test_failed_points_take_part_in_no_further_pass() -> None:
    points = rows("temperature", [200.0, 210.0, 220.0])
    motions = motions_of(points, PHYSICS)
    motions.counts[1, OUTCOME] = Status.DIVERGED
    motions.counts[:, CYCLE] = 2
    before = motions.states[1].copy()
    passes.work_through(motions, passes.TRAVEL, 1e-4, 10**6, PHYSICS)
    assert motions.counts[:, OUTCOME].tolist() == [Status.OK, Status.DIVERGED, Status.OK]
    np.testing.assert_array_equal(motions.states[1], before)
    assert np.all(motions.counts[[0, 2], ATTEMPTED] > 0)
    assert motions.counts[1, ATTEMPTED] == 0
