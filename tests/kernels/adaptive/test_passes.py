"""A pass: in one go, in portions or half period by half period, the same bits."""

from __future__ import annotations

import numpy as np
import pytest
from support.points import rows

from stickslip import Status
from stickslip.kernels.adaptive import passes
from stickslip.kernels.families import Family
from stickslip.kernels.orbits.motions import ATTEMPTED, CYCLE, OUTCOME, Motions, motions_of
from stickslip.options import DEFAULTS

LAW = DEFAULTS.physics
PSEUDOPLASTIC = Family(LAW, -2 / 3)


POINTS = rows("temperature", np.linspace(180.0, 290.0, 21))


def worked(task: passes.Pass, attempts: int) -> tuple[Motions, int]:
    """The motions of pseudoplastic points after a pass, in portions of so many attempts."""
    kernel, which = passes.pass_kernel(PSEUDOPLASTIC), np.arange(len(POINTS))
    motions, lanes, calls = motions_of(POINTS, LAW), passes.new_lanes(3), 0
    left = len(POINTS)
    motions.rtols[:], motions.counts[:, CYCLE] = 1e-4, 3
    while left > 0:
        previous = left
        left = kernel(motions, which, lanes, task, attempts)
        calls += 1
        assert 0 <= left <= previous
    assert kernel(motions, which, lanes, task, attempts) == 0
    return motions, calls


@pytest.mark.parametrize("mode", [passes.TRAVEL, passes.MEASURE, passes.VARY])
def test_a_pass_in_portions_gives_the_same_bits(mode: int) -> None:
    task = passes.Pass(mode, 0, 1_000_000)
    whole, calls = worked(task, 10**9)
    assert calls == 1
    assert np.all(whole.counts[:, OUTCOME] == Status.OK)
    for attempts in (1, 7, 1000):
        pieces, calls = worked(task, attempts)
        assert calls > 1
        for ours, theirs in zip(pieces, whole, strict=True):
            np.testing.assert_array_equal(ours, theirs, strict=True)


def test_a_motion_that_is_cut_into_half_periods_has_the_same_bits() -> None:
    whole, _ = worked(passes.Pass(passes.TRAVEL, 5, 1_000_000), 10**9)
    kernel, lanes = passes.pass_kernel(PSEUDOPLASTIC), passes.new_lanes(3)
    motions, which = motions_of(POINTS, LAW), np.arange(len(POINTS))
    motions.rtols[:], motions.counts[:, CYCLE] = 1e-4, 3
    for half in range(5):
        # In any company and order.
        for part in (which[half % 2 :: 2], which[1 - half % 2 :: 2][::-1]):
            task = passes.Pass(passes.TRAVEL, 1, 1_000_000)
            passes.take_through(kernel, motions, part, lanes, task)
    for ours, theirs in zip(motions, whole, strict=True):
        np.testing.assert_array_equal(ours, theirs, strict=True)


def test_points_that_have_failed_take_part_in_no_further_pass() -> None:
    points = rows("temperature", [200.0, 210.0, 220.0])
    motions = motions_of(points, LAW)
    motions.counts[1, OUTCOME] = Status.DIVERGED
    motions.counts[:, CYCLE] = 2
    before = motions.states[1].copy()
    passes.work_through(motions, passes.TRAVEL, 1e-4, 10**6, LAW)
    assert motions.counts[:, OUTCOME].tolist() == [Status.OK, Status.DIVERGED, Status.OK]
    np.testing.assert_array_equal(motions.states[1], before)
    assert np.all(motions.counts[[0, 2], ATTEMPTED] > 0)
    assert motions.counts[1, ATTEMPTED] == 0
