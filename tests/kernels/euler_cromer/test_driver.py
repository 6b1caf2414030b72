"""The paper's method is of first order, refuses unstable steps and agrees with the adaptive one."""

from __future__ import annotations

import numpy as np
import pytest
from support.marks import marked
from support.points import error_scales, orbits, refuse_nothing, row
from support.scalar_twins import cyclic_meltings, euler_cromer_period

from stickslip import Parameters, Status, stability
from stickslip.kernels.euler_cromer import driver
from stickslip.kernels.orbits import settling
from stickslip.measure.accumulate import (
    ABSOLUTE_WORK,
    BLOCK_WORK,
    FORCE_MAX,
    LOSS,
    STRESS_MAX,
)
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS

PERIODS = RESULT_COLUMNS.index("periods_integrated")


@pytest.mark.parametrize("changes", [{}, {"angular_frequency": 38.0}, {"temperature": 300.0}])
def test_refusal_begins_at_the_largest_stable_step(changes: dict[str, float]) -> None:
    limit = float(stability.largest_stable_step(row(**changes))[0])
    options = {"method": "euler-cromer", "max_steps": 1}
    assert orbits(row(**changes), dt=limit, **options).status == Status.STEP_LIMIT
    assert orbits(row(**changes), dt=limit * (1 + 1e-12), **options).status == Status.REFUSED


# Points with a long largest stable step: liquid or slow films, and films without elasticity.
STABLE = [
    ({"elastic_coefficient": 0.0}, 2e-5),
    ({"elastic_coefficient": 0.0, "rheological_index": -0.5}, 2e-5),
    ({"temperature": 300.0}, 7e-7),
]
STABLE_AT_GAMMA_0 = [
    ({"temperature": 300.0, "rheological_index": 0.0, "viscosity_coefficient": 1e4}, 7e-7),
    ({"temperature": 250.0, "rheological_index": 0.0, "viscosity_coefficient": 1e4,
      "kinetic_coefficient": 1.0}, 2e-6),
]  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "dt"), [*STABLE, *marked("stress", STABLE_AT_GAMMA_0)], ids=str
)
def test_orbits_agree_with_the_adaptive_ones_within_the_stated_error(
    changes: dict[str, float], dt: float
) -> None:
    point = row(**changes)
    fixed = orbits(point, method="euler-cromer", dt=dt)
    exact = orbits(point, rtol=1e-9, stationary_rtol=1e-9)
    assert (fixed.status, exact.status) == (Status.OK, Status.OK)
    stress_scale, force_scale = error_scales(point)
    true = max(
        *abs(fixed.elastic_stress_amplitude - exact.elastic_stress_amplitude) / stress_scale,
        *abs(fixed.friction_force_amplitude - exact.friction_force_amplitude)
        / np.maximum(exact.friction_force_amplitude, force_scale),
    )
    # 1e-6 allows for the distance to the limit that `stationary_rtol` leaves both.
    assert true <= fixed.amplitude_error[0] + 1e-6
    assert fixed.amplitude_error[0] < 1e-4
    lost = abs(fixed.dissipated_energy - exact.dissipated_energy)
    assert lost <= fixed.dissipated_energy_error + 1e-6 * exact.dissipated_energy
    assert fixed.dissipated_energy_error < 1e-3 * exact.dissipated_energy
    assert fixed.power_balance_error[0] < 1e-4
    assert fixed.melting_count == exact.melting_count
    assert fixed.orbit_periods == exact.orbit_periods == 1


def test_the_stated_error_falls_in_proportion_to_the_step() -> None:
    errors = [
        orbits(row(elastic_coefficient=0.0), method="euler-cromer", dt=dt).amplitude_error[0]
        for dt in (4e-5, 2e-5, 1e-5)
    ]
    np.testing.assert_allclose(np.array(errors[:-1]) / errors[1:], 2.0, rtol=0.1)


ORBITS: list[dict[str, float]] = [
    {"elastic_coefficient": 0.0},
    {"elastic_coefficient": 0.0, "rheological_index": -0.5},
    {"elastic_coefficient": 0.0, "spring_stiffness": 2500.0, "drive_amplitude": -0.8e-6},
    {"elastic_coefficient": 0.0, "angular_frequency": 17.0, "noise_intensity": 0.0,
     "initial_order_parameter": 0.1},
]  # fmt: skip


COARSE = {"method": "euler-cromer", "dt": 2e-5}


def test_orbits_agree_with_plain_iteration_by_the_scalar_drive() -> None:
    points = [Parameters(**changes) for changes in ORBITS]
    found = orbits(np.array(points), **COARSE, stationary_rtol=1e-5, max_periods=300)
    assert np.all(found.status == Status.OK)
    for i, p in enumerate(points):
        cycle = int(found.orbit_periods[i])
        before = int(found.periods_integrated[i]) - cycle
        begin, _, _ = euler_cromer_period(p, 2e-5, before - 1, 1)
        np.testing.assert_allclose(found.final[i, :2], begin[:2], rtol=1e-8)
        np.testing.assert_allclose(np.exp(found.final[i, 2]), begin[2], rtol=1e-8)
        end, record, _ = euler_cromer_period(p, 2e-5, before, cycle)
        for slot, name in ((STRESS_MAX, "elastic_stress"), (FORCE_MAX, "friction_force")):
            high, low = getattr(found, f"{name}_max")[i], getattr(found, f"{name}_min")[i]
            np.testing.assert_allclose([high, low], record[slot : slot + 2], rtol=1e-10, atol=1e-9)
        energy = [
            0.5 * p.block_mass * v**2 + p.spring_stiffness * x**2 for x, v in (begin[:2], end[:2])
        ]
        miss = abs(record[BLOCK_WORK] - (energy[1] - energy[0])) / record[ABSOLUTE_WORK]
        assert found.power_balance_error[i] == pytest.approx(miss, abs=1e-8)
        work = record[LOSS] / cycle
        assert found.dissipated_energy[i] == pytest.approx(work, rel=1e-8)
        assert found.melting_count[i] == cyclic_meltings(record)


@pytest.mark.parametrize("budget", [10_000, 31_416, 100_000])
def test_a_step_budget_ends_a_search_where_it_runs_out(budget: int) -> None:
    # A period of 0.628 s takes 31416 steps of 2e-5 s.
    found = orbits(row(**ORBITS[0]), **COARSE, max_steps=budget)
    assert found.status == Status.STEP_LIMIT
    assert found.periods_integrated == budget // 31_416 + 1


def test_a_step_budget_covers_the_measurement() -> None:
    enough = orbits(row(**ORBITS[0]), **COARSE, stationary_rtol=1e-4)
    steps = 31_416 * int(enough.periods_integrated[0])
    same = orbits(row(**ORBITS[0]), **COARSE, stationary_rtol=1e-4, max_steps=steps)
    np.testing.assert_array_equal(same.row, enough.row)
    short = orbits(row(**ORBITS[0]), **COARSE, stationary_rtol=1e-4, max_steps=steps - 1)
    assert short.status == Status.STEP_LIMIT


def test_points_start_at_their_own_or_at_given_states() -> None:
    points, options = np.array([row(**ORBITS[0])] * 2), Options(**COARSE, stationary_rtol=1e-4)
    results, finals = compute_orbits(points, options)
    starts = np.array([np.full_like(finals[0], np.nan), finals[1]])
    again, _ = compute_orbits(points, options, starts)
    np.testing.assert_array_equal(again[0], results[0])
    fewer, more = again[1, PERIODS], results[1, PERIODS]
    assert 3 <= fewer < more  # it starts on its orbit
    np.testing.assert_allclose(again[1, :2], results[1, :2], rtol=1e-3)


def test_the_number_of_searches_at_a_time_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.array([Parameters(**changes) for changes in ORBITS])
    whole = compute_orbits(points, Options(**COARSE, stationary_rtol=1e-4))
    monkeypatch.setattr(settling, "AT_A_TIME", 3)
    parts = compute_orbits(points, Options(**COARSE, stationary_rtol=1e-4))
    for ours, theirs in zip(parts, whole, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_an_orbit_that_diverges_leaves_the_others_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    # Without the refusal the step is twice too long for the first point.
    points = np.array([row(angular_frequency=2e3), row(elastic_coefficient=0.0)])
    options = {**COARSE, "stationary_rtol": 1e-3}
    alone = orbits(points[1], **options)
    monkeypatch.setattr(driver, "largest_step", refuse_nothing)
    found = orbits(points, **options)
    assert found.status.tolist() == [Status.DIVERGED, Status.OK]
    np.testing.assert_array_equal(found.row[1], alone.row[0])


def test_an_order_parameter_that_underflows_is_that_of_a_liquid_film() -> None:
    """Without noise phi of a melted film falls to 0, whose logarithm the adaptive method takes."""
    melted = row(temperature=320.0, initial_order_parameter=0.5, angular_frequency=60.0)
    found = orbits(melted, method="euler-cromer", dt=1.75e-8, noise="none")
    assert found.status == Status.OK
    exact = orbits(melted, noise="none")
    np.testing.assert_allclose(
        found.friction_force_amplitude, exact.friction_force_amplitude, rtol=1e-6
    )
