"""Points from period to period, by any march: starts, budgets, endings."""

from __future__ import annotations

import numpy as np
from support.points import row

from stickslip.kernels.plain_iteration.motions import Motions
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT
from stickslip.options import Options, Physics
from stickslip.parameters import Parameters
from stickslip.status import Status

STEPS = 1000
POINTS = np.array([row()] * 3)
DT = 2.0 * np.pi / Parameters().angular_frequency / STEPS * (1.0 + 1e-9)
OWN = np.full((3, 4), np.nan)


class Standing:
    """A march that leads nowhere: the last point diverges, and steps are limited."""

    def __init__(
        self, _points: np.ndarray, steps: np.ndarray, states: np.ndarray, _physics: Physics
    ) -> None:
        self.steps, self.begun, self.told = steps, states, []

    def states(self) -> np.ndarray:
        return self.begun

    def period(self, which: np.ndarray, limits: np.ndarray, *, measured: bool) -> np.ndarray:
        self.told.append((which.tolist(), limits.tolist(), measured))
        outcome = np.where(limits < self.steps[which], STEP_LIMIT, OK)
        return np.where(which == 2, DIVERGED, outcome)


def motions(given: np.ndarray = OWN) -> Motions:
    return Motions(Standing, POINTS, given, Options(dt=DT, max_steps=2 * STEPS + 1))


def test_a_step_divides_the_period_evenly_and_a_budget_covers_whole_periods() -> None:
    ours, pending = motions(), np.arange(3)
    for measured in (False, True, False):
        pending = ours.next_period(pending, measured=measured)
    assert ours.march.steps.tolist() == [STEPS] * 3
    assert ours.march.told == [
        ([0, 1, 2], [2001] * 3, False),
        ([0, 1], [1001] * 2, True),
        ([0, 1], [1] * 2, False),
    ]
    assert pending.tolist() == []


def test_what_fails_keeps_its_status_and_its_number_of_periods() -> None:
    ours = motions()
    assert ours.next_period(np.arange(3), measured=False).tolist() == [0, 1]
    assert ours.status.tolist() == [Status.NOT_STATIONARY, Status.NOT_STATIONARY, DIVERGED]
    assert ours.next_period(np.array([1]), measured=False).tolist() == [1]
    assert ours.next_period(np.array([1]), measured=False).tolist() == []
    assert ours.status.tolist() == [Status.NOT_STATIONARY, STEP_LIMIT, DIVERGED]
    assert ours.periods.tolist() == [1, 3, 1]


def test_points_start_by_themselves_or_where_they_are_told() -> None:
    given = OWN.copy()
    given[1] = 1e-7, 2e-6, np.log(0.5), 1e-6
    begun = motions(given).march.states()
    np.testing.assert_allclose(begun[1], [1e-7, 2e-6, 0.5], rtol=1e-15)
    np.testing.assert_array_equal(begun[0], begun[2])
    assert begun[0, :2].tolist() == [0.0, 0.0]
