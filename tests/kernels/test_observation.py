"""Motions that the search gives up for lost: watched, and either measured or searched on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.points import orbits, row

from stickslip import Status
from stickslip.kernels.orbits import watching
from stickslip.kernels.plain_iteration import judging
from stickslip.numerics.periodic import search
from stickslip.regime import Regime

SHORT: dict[str, Any] = {
    "method": "euler-cromer", "dt": 2e-5, "stationary_rtol": 1e-4, "window": 20,
}  # fmt: skip
POINT = row(elastic_coefficient=0.0)


@pytest.fixture
def wandering(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search loses the way after the third period, once."""
    judge, calls = judging.judge, []

    def lost(*arrays: Any) -> None:
        judge(*arrays)
        calls.append(1)
        if len(calls) == 3:
            arrays[-1][arrays[2]] = search.WANDERING

    monkeypatch.setattr(judging, "judge", lost)


def test_what_attracts_is_searched_on(wandering: None) -> None:
    found = orbits(POINT, **SHORT)
    assert found.status == Status.OK
    assert found.periods_integrated > 128
    # The orbit of a search that was not lost; this one began nearer to it.
    exact = orbits(POINT, rtol=1e-9, stationary_rtol=1e-9)
    force, error = exact.friction_force_amplitude, found.amplitude_error + 1e-4
    assert abs(found.friction_force_amplitude / force - 1.0) <= error


def test_what_does_not_is_measured_over_the_window(
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
