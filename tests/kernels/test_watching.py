"""Motions whose search found no cycle are watched, and then measured or searched again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.points import orbits, row

from stickslip import Status
from stickslip.kernels.families import Family
from stickslip.kernels.orbits import settling, watching
from stickslip.kernels.orbits.motions import OUTCOME, Motions
from stickslip.regime import Regime

SHORT: dict[str, Any] = {
    "method": "euler-cromer", "dt": 2e-5, "stationary_rtol": 1e-4, "window": 20,
}  # fmt: skip
POINT = row(elastic_coefficient=0.0)


@pytest.fixture
def wandering(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the search fail once, after the third period."""
    kernels, calls = settling.kernels_of, []

    def kernels_that_lose(family: Family) -> Any:
        start, judge = kernels(family)

        def lost(motions: Motions, rows: np.ndarray, *others: Any) -> tuple[int, int]:
            going, begun = judge(motions, rows, *others)
            calls.append(1)
            if len(calls) != 3:
                return going, begun
            motions.counts[rows, OUTCOME] = Status.APERIODIC
            return 0, 0

        return start, lost

    monkeypatch.setattr(settling, "kernels_of", kernels_that_lose)


def test_the_search_goes_on_if_neighbours_approach(wandering: None) -> None:
    found = orbits(POINT, **SHORT)
    assert found.status == Status.OK
    assert found.periods_integrated > 128
    # The orbit agrees with an undisturbed search; the measurement began nearer to it.
    exact = orbits(POINT, rtol=1e-9, stationary_rtol=1e-9)
    force, error = exact.friction_force_amplitude, found.amplitude_error + 1e-4
    assert abs(found.friction_force_amplitude / force - 1.0) <= error


def test_otherwise_the_motion_is_measured_over_the_window(
    wandering: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watching, "LEAST_GROWTH", -np.inf)
    found = orbits(POINT, **SHORT)
    assert (found.status, found.regime) == (Status.APERIODIC, Regime.APERIODIC)
    assert (found.orbit_periods, found.periods_integrated) == (0, 3 + 128)
    exact = orbits(POINT, rtol=1e-9, stationary_rtol=1e-9)
    # It had settled before the window began.
    assert found.friction_force_amplitude == pytest.approx(exact.friction_force_amplitude, rel=1e-3)
    assert found.friction_force_amplitude_spread < 1e-6 * exact.friction_force_amplitude
    assert found.lyapunov_exponent < 0.0
