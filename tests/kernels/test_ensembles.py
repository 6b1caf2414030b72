"""The statistics of the ensembles of a stochastic film, and what does not change them."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.marks import one_then
from support.points import MISSED_STICKS, orbits, row

from stickslip import Status
from stickslip.kernels import ensembles
from stickslip.measure.window import error_of_mean
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS

FEW: dict[str, Any] = {
    "noise": "stochastic", "realizations": 5, "window": 20, "rtol": 1e-4,
}  # fmt: skip
POINTS = np.array(
    [row(**MISSED_STICKS), row(**MISSED_STICKS, temperature=210.0), row(**MISSED_STICKS)]
)


def ensemble(points: np.ndarray, **options: Any) -> SimpleNamespace:
    return orbits(np.atleast_2d(points), **FEW | options)


# --- statistics ---


def test_the_row_of_an_ensemble() -> None:
    found, typical = ensemble(POINTS[0]), orbits(POINTS[:1], rtol=1e-4)
    assert found.status == Status.OK
    assert found.regime == typical.regime == Regime.STICK_SLIP_SYMMETRIC
    assert found.orbit_periods == 0
    assert found.periods_integrated == typical.periods_integrated + 5 * (5 + 20)
    assert 0 < found.melting_count < 2 * 5 * 20  # twice a period, except for missed sticks
    assert found.elastic_stress_amplitude_spread > 0.05 * found.elastic_stress_amplitude
    assert found.floquet_multiplier == typical.floquet_multiplier
    assert found.elastic_stress_max >= found.elastic_stress_amplitude
    dissipated = found.dissipated_energy / typical.dissipated_energy
    assert 0.5 < dissipated < 1.0  # a period without meltings dissipates less
    np.testing.assert_array_equal(found.final, typical.final)


def test_an_error_is_three_standard_errors_plus_the_error_of_the_typical_path() -> None:
    many = ensemble(POINTS[0], realizations=64)
    typical = orbits(POINTS[:1], rtol=1e-4)
    spread = many.elastic_stress_amplitude_spread / many.elastic_stress_amplitude
    independent = 3.0 * spread / np.sqrt(64 * 20)
    assert many.amplitude_error > typical.amplitude_error
    assert 0.7 * independent < many.amplitude_error < 2.0 * independent
    few = ensemble(POINTS[0], realizations=16)
    difference = abs(few.elastic_stress_amplitude / many.elastic_stress_amplitude - 1.0)
    assert difference < few.amplitude_error + many.amplitude_error
    assert many.dissipated_energy_error > typical.dissipated_energy_error
    difference = abs(few.dissipated_energy - many.dissipated_energy)
    assert difference < few.dissipated_energy_error + many.dissipated_energy_error
    assert many.dissipated_energy_error < few.dissipated_energy_error


@pytest.mark.parametrize(("paths", "periods"), [(1, 32), (3, 20), (64, 32)])
def test_the_error_of_independent_numbers(paths: int, periods: int) -> None:
    draws = np.random.default_rng(1).normal(size=(400, paths, periods))
    errors = np.array([error_of_mean(values) for values in draws])
    assert np.mean(np.abs(draws.mean(axis=(1, 2))) <= errors) > 0.98
    # With few batches Student's distribution makes the error larger, with six of them twice.
    assert 0.9 < np.median(errors) * np.sqrt(paths * periods) / 3.0 < 2.2


def test_the_error_of_paths_that_never_meet() -> None:
    values = np.tile(np.arange(64.0)[:, None], 40)  # each path stays at another value
    spread = np.std(values[:, 0], ddof=1)
    assert error_of_mean(values) > 0.9 * 3.0 * spread / np.sqrt(64 * 2)


# --- irrelevant changes ---


def test_the_number_of_paths_at_a_time_makes_no_difference(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    together = ensemble(POINTS).row
    monkeypatch.setattr(ensembles, "PATHS_AT_A_TIME", 5)
    np.testing.assert_array_equal(ensemble(POINTS).row, together)


@pytest.mark.parametrize("strain", one_then("stress", ["adiabatic", "relaxing"]))
def test_the_mirror_image_is_exact_bit_for_bit(strain: str) -> None:
    names = ("drive_amplitude", "initial_displacement", "initial_velocity")
    twin = MISSED_STICKS | {"initial_displacement": 1e-8, "initial_velocity": -2e-6}
    image = twin | {name: -twin[name] for name in names}
    ours, other = (ensemble(row(**changes), strain=strain) for changes in (twin, image))
    assert ours.status == Status.OK
    for name in RESULT_COLUMNS:
        left = getattr(other, name)
        if name.endswith(("_max", "_min")):
            turned = name[:-3] + ("min" if name.endswith("max") else "max")
            left = -getattr(other, turned)
        np.testing.assert_array_equal(getattr(ours, name), left, err_msg=name)


# --- endings ---


def test_a_point_without_a_typical_path_has_no_ensemble() -> None:
    found = ensemble(POINTS[0], max_periods=1)
    assert found.status == Status.NOT_STATIONARY
    assert np.isnan(found.elastic_stress_amplitude)


def test_pending_points_stay_pending() -> None:
    options = Options(**FEW)
    results, _ = compute_orbits(POINTS, options, patience=1)
    assert np.all(results[:, RESULT_COLUMNS.index("status")] == Status.PENDING)


def test_one_failed_path_fails_the_point(monkeypatch: pytest.MonkeyPatch) -> None:
    from stickslip.kernels.adaptive.march import StochasticWalk

    def failing(walk: StochasticWalk) -> np.ndarray:
        outcomes = np.zeros(len(walk.points), np.int64)
        outcomes[3] = Status.STEP_LIMIT
        return outcomes

    monkeypatch.setattr(StochasticWalk, "outcomes", failing)
    found = ensemble(POINTS[:2])
    assert found.status.tolist() == [Status.STEP_LIMIT, Status.OK]
    assert np.isnan(found.friction_force_amplitude[0])


def test_no_noise_leaves_the_deterministic_film() -> None:
    silent = row(**MISSED_STICKS | {"noise_intensity": 0.0})
    found, exact = ensemble(silent, rtol=1e-6), orbits(silent, noise="none")
    assert found.status == exact.status == Status.OK
    stress = exact.elastic_stress_amplitude
    assert found.elastic_stress_amplitude == pytest.approx(stress, rel=1e-5)
    assert found.elastic_stress_amplitude_spread < 1e-5 * stress


def test_strong_noise_may_lift_the_order_parameter_above_its_bound() -> None:
    found = ensemble(row(**MISSED_STICKS | {"noise_intensity": 1e-2}))
    assert found.status == Status.OK
