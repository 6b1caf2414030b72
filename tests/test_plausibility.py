"""Suspicious results: the thresholds, and that good orbits are not suspicious."""

from __future__ import annotations

import numpy as np
import pytest
from support.points import orbits, row, rows

from stickslip import Parameters, Status
from stickslip.orbit import failed_row
from stickslip.plausibility import (
    SUSPICIOUS_BALANCE,
    SUSPICIOUS_STRESS,
    suspicious_balance,
    suspicious_stress,
)
from stickslip.stability import static_strength
from stickslip.variables import RESULT_COLUMNS


def result(**columns: float) -> np.ndarray:
    """A result row with some columns."""
    found = np.zeros(len(RESULT_COLUMNS))
    for name, value in columns.items():
        found[RESULT_COLUMNS.index(name)] = value
    return found


def stress(high: float, low: float) -> np.ndarray:
    return result(elastic_stress_max=high, elastic_stress_min=low)


# --- the power balance ----------------------------------------------------------------------------


def test_a_power_balance_is_suspicious_above_its_limit() -> None:
    errors = [0.0, SUSPICIOUS_BALANCE, 1.01 * SUSPICIOUS_BALANCE, 9e-3]
    results = np.array(
        [result(power_balance_error=error, amplitude_error=5e-3) for error in errors]
    )
    assert suspicious_balance(results).tolist() == [False, False, True, True]


def test_a_power_balance_is_not_suspicious_where_the_amplitudes_are_known() -> None:
    results = result(power_balance_error=9e-3, amplitude_error=1e-4)[None]
    assert suspicious_balance(results).tolist() == [False]


# --- the stress -----------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("temperature", [150.0, 200.0, 229.0, 285.0])
def test_a_stress_is_suspicious_a_tenth_above_the_static_maximum(
    temperature: float, sign: float
) -> None:
    points = rows("temperature", [temperature] * 3)
    strength = static_strength(points)[0]
    parts = sign * SUSPICIOUS_STRESS * strength * np.array([0.5, 0.999, 1.001])
    results = np.array([stress(max(s, 0.0), min(s, 0.0)) for s in parts.tolist()])
    assert suspicious_stress(points, results).tolist() == [False, False, True]


def test_the_quick_test_of_the_stress_does_not_decide() -> None:
    # Few strains, which clear most points, underestimate the strength by up to a percent.
    points = rows("temperature", np.linspace(150.0, 289.0, 500))
    strength, quick = static_strength(points), static_strength(points, 12)
    assert np.min(quick / strength) < 0.996
    results = np.array([stress(0.998 * SUSPICIOUS_STRESS * s, 0.0) for s in strength.tolist()])
    assert not suspicious_stress(points, results).any()


def test_small_stresses_are_not_compared() -> None:
    # A film that is liquid at rest has no strength; 1 % of the springs over A is small.
    point = row(temperature=320.0)[None]
    assert static_strength(point)[0] == 0.0
    small = 0.01 * 2 * 3000.0 * 0.8e-6 / 0.6e-9
    for factor, suspicious in ((0.9, False), (1.0, False), (1.2, True)):
        found = suspicious_stress(point, stress(factor * small, 0.0)[None])
        assert found.tolist() == [suspicious]
    mirrored = row(temperature=320.0, drive_amplitude=-0.8e-6)[None]
    assert not suspicious_stress(mirrored, stress(0.9 * small, 0.0)[None])[0]


def test_points_without_a_result_are_not_suspicious() -> None:
    points = rows("temperature", [200.0, 300.0])
    results = np.array([failed_row(), failed_row(Status.STEP_LIMIT)])
    assert not suspicious_balance(results).any()
    assert not suspicious_stress(points, results).any()


def test_no_points_are_not_suspicious() -> None:
    points, results = np.empty((0, len(Parameters._fields))), np.empty((0, len(RESULT_COLUMNS)))
    assert suspicious_balance(results).shape == suspicious_stress(points, results).shape == (0,)


def test_the_orbits_of_the_paper_are_not_suspicious() -> None:
    points = rows("temperature", np.linspace(160.0, 300.0, 8))
    found = orbits(points)
    assert not suspicious_balance(found.row).any()
    assert not suspicious_stress(points, found.row).any()
