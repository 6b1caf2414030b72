"""From a record to a result row: counts, invariants, and rejected orbits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.records import SI, record_of

from stickslip import Parameters, Status
from stickslip.measure.accumulate import (
    MELTED,
    RECORD,
    SOLID,
    UNSEEN,
)
from stickslip.measure.results import (
    STATUS,
    Measured,
    full_force,
    write_failure,
    write_result,
    write_whole_orbit,
)
from stickslip.measure.window import amplitudes_of
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS, RESULTS

P = Parameters()
FROM_WORK = 6e-9 / (math.pi * 0.8e-6)
"""The force out of phase [N] for a work of 6e-9 J in a period."""
LIMIT = 1e-2
"""The largest power balance error of an accepted orbit."""
BEGIN, END = (1e-7, 2e-6), (3e-7, -1e-6)
GAINED = 0.5 * 0.4 * (END[1] ** 2 - BEGIN[1] ** 2) + 3000.0 * (END[0] ** 2 - BEGIN[0] ** 2)
"""The energy [J] that the block gains between these states."""


def result_of(
    p: Parameters = P,
    cycle: int = 2,
    begin: tuple[float, float] = (0.0, 0.0),
    end: tuple[float, float] = (0.0, 0.0),
    error: float = 1e-7,
    uncertain: float = 1e-3,
    symmetric: bool = False,
    exponent: float = math.nan,
    status: Status = Status.OK,
    **slots: float,
) -> dict[str, float]:
    """The result row of a record of `cycle` half periods, by name.

    `uncertain` is the relative error of its integrals.
    """
    row, whole = np.full(len(RESULT_COLUMNS), 77.0), np.empty(RECORD)
    write_whole_orbit(record_of(**slots), SI, cycle, whole)
    uncertainties = np.where(whole != 0.0, uncertain, 0.0) * whole
    measured = Measured(
        records=whole[None], uncertainties=uncertainties[None], cycles=np.array([cycle]),
        begins=np.array([begin]), ends=np.array([end]), symmetric=np.array([symmetric]),
        amplitudes=amplitudes_of(whole[None]), errors=np.array([error]),
        spreads=np.array([[3e4, 2e-5]]), multipliers=np.array([0.25]),
        exponents=np.array([exponent]), periods=np.array([9]), statuses=np.array([int(status)]),
    )  # fmt: skip
    write_result(p, measured, 0, row)
    return dict(zip(RESULT_COLUMNS, row.tolist(), strict=True))


def assert_rejected(found: dict[str, float], status: Status) -> None:
    found = dict(found)
    assert (found.pop("status"), found.pop("periods_integrated")) == (status, 9)
    for name, value in found.items():
        np.testing.assert_equal(value, RESULTS[name].missing, err_msg=name)


# --- the row --------------------------------------------------------------------------------------


def test_a_row_has_each_measurement_under_its_name() -> None:
    found = result_of()
    expected: dict[str, Any] = {
        "elastic_stress_amplitude": 2e6,
        "friction_force_amplitude": 1.5e-3,
        "elastic_stress_max": 3e6,
        "elastic_stress_min": -1e6,
        "friction_force_max": 2e-3,
        "friction_force_min": -1e-3,
        "dissipated_energy": 6e-9,
        "dissipated_energy_error": 6e-12,
        "amplitude_error": 1e-7,
        "power_balance_error": 0.0,
        "orbit_periods": 1,
        "melting_count": 0,
        "solid_transition_count": 0,
        "asymmetry": 0.5,
        "periods_integrated": 9,
        "solid_fraction": 0.0,
        "regime": Regime.LIQUID,
        "floquet_multiplier": 0.25,
        "lyapunov_exponent": math.nan,
        "elastic_stress_amplitude_spread": 3e4,
        "friction_force_amplitude_spread": 2e-5,
        "friction_force_in_phase": 2e-4,
        "friction_force_in_phase_error": 2e-7,
        "friction_force_out_of_phase": FROM_WORK,
        "friction_force_out_of_phase_error": 1e-3 * FROM_WORK,
        "friction_force_rms": 1e-3,
        "friction_force_mean_abs": 8e-4,
        "status": Status.OK,
    }
    assert set(found) == set(expected)
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-15, nan_ok=True), name


@pytest.mark.parametrize("cycle", [1, 2, 3, 4])
def test_observables_are_means_over_the_whole_orbit(cycle: int) -> None:
    sums = {
        "MOTION_IN_PHASE": 2e-4, "MOTION_OUT_OF_PHASE": 1e-3, "SQUARED_FORCE": 2e-6,
        "FORCE_SIZE": 1.6e-3, "IN_PHASE": 77.0, "OUT_OF_PHASE": 77.0,
    }  # fmt: skip
    part = {name: 0.5 * cycle * value for name, value in sums.items()}
    found = result_of(Parameters(third_harmonic=0.1), cycle=cycle, **part)
    first = RESULT_COLUMNS.index("friction_force_in_phase")
    means = list(found.values())[first : first + 6]
    assert means == pytest.approx([2e-4, 2e-7, 1e-3, 1e-6, 1e-3, 8e-4], rel=1e-15)


@pytest.mark.parametrize("cycle", [1, 2, 3, 4])
def test_under_a_cosine_the_force_out_of_phase_follows_from_the_work(cycle: int) -> None:
    found = result_of(cycle=cycle, LOSS=0.5 * cycle * 6e-9, MOTION_OUT_OF_PHASE=77.0)
    assert found["friction_force_out_of_phase"] == pytest.approx(FROM_WORK, rel=1e-15)
    assert found["friction_force_out_of_phase_error"] == pytest.approx(1e-3 * FROM_WORK, rel=1e-15)


def test_harmonics_of_a_window_come_from_the_force() -> None:
    motion = {"MOTION_IN_PHASE": 77.0, "MOTION_OUT_OF_PHASE": 77.0}
    found = result_of(Parameters(third_harmonic=0.1), status=Status.APERIODIC, **motion)
    assert found["friction_force_in_phase"] == pytest.approx(2e-4, rel=1e-15)
    assert found["friction_force_out_of_phase"] == pytest.approx(1e-3, rel=1e-15)


def test_harmonics_change_sign_with_the_drive() -> None:
    found = result_of(Parameters(drive_amplitude=-0.8e-6, third_harmonic=0.1))
    assert found["friction_force_in_phase"] == pytest.approx(-2e-4, rel=1e-15)
    assert found["friction_force_in_phase_error"] == pytest.approx(2e-7, rel=1e-15)
    assert found["friction_force_out_of_phase"] == pytest.approx(-1e-3, rel=1e-15)
    assert found["friction_force_mean_abs"] == pytest.approx(8e-4, rel=1e-15)
    cosine = result_of(Parameters(drive_amplitude=-0.8e-6))
    assert cosine["friction_force_out_of_phase"] == pytest.approx(FROM_WORK, rel=1e-15)


@pytest.mark.parametrize(("cycle", "energy"), [(1, 12e-9), (2, 6e-9), (3, 4e-9), (4, 3e-9)])
def test_the_dissipated_energy_is_per_drive_period(cycle: int, energy: float) -> None:
    found = result_of(cycle=cycle)
    assert found["dissipated_energy"] == pytest.approx(energy, rel=1e-15)
    assert found["dissipated_energy_error"] == pytest.approx(1e-3 * energy, rel=1e-15)


def test_energy_that_the_block_gains_is_work_in_a_window_and_no_loss_of_a_closed_orbit() -> None:
    motion: dict[str, Any] = {"cycle": 400, "begin": BEGIN, "end": END, "BLOCK_WORK": GAINED}
    window = result_of(**motion, status=Status.APERIODIC, exponent=0.1)
    assert window["dissipated_energy"] == pytest.approx((6e-9 + GAINED) / 200, rel=1e-14)
    assert result_of(**motion)["dissipated_energy"] == pytest.approx(6e-9 / 200, rel=1e-15)


@pytest.mark.parametrize("uncertain", [math.nan, math.inf])
def test_unknown_errors_of_integrals_are_upper_bounds(uncertain: float) -> None:
    found = result_of(uncertain=uncertain)
    assert found["status"] == Status.OK
    assert found["dissipated_energy_error"] == pytest.approx(6e-9 + 1e-8, rel=1e-15)
    assert found["friction_force_in_phase_error"] == pytest.approx(2e-4 + 1.6e-3, rel=1e-15)


@pytest.mark.parametrize(
    ("orbit", "regime"),
    [
        ({}, Regime.LIQUID),
        ({"SOLID_TIME": 2.0, "FIRST_PHASE": SOLID, "LAST_PHASE": SOLID}, Regime.LOCKED),
        ({"SOLID_TIME": 1.0, "MELTINGS": 2.0, "symmetric": True}, Regime.STICK_SLIP_SYMMETRIC),
        ({"SOLID_TIME": 1.0, "MELTINGS": 2.0}, Regime.STICK_SLIP_ASYMMETRIC),
        ({"cycle": 4, "SOLID_TIME": 1.0, "MELTINGS": 2.0}, Regime.SUBHARMONIC),
        ({"cycle": 4}, Regime.SUBHARMONIC),
        ({"cycle": 400, "status": Status.APERIODIC, "exponent": 0.1}, Regime.APERIODIC),
    ],
    ids=str,
)
def test_the_regime_is_the_first_that_applies(orbit: dict[str, Any], regime: Regime) -> None:
    assert result_of(**orbit)["regime"] == regime


def test_an_aperiodic_orbit_closes_after_no_period() -> None:
    found = result_of(cycle=400, status=Status.APERIODIC, exponent=0.1)
    assert (found["status"], found["orbit_periods"]) == (Status.APERIODIC, 0)
    assert found["lyapunov_exponent"] == 0.1


@pytest.mark.parametrize(("cycle", "passes"), [(1, 2), (2, 1), (4, 1)])
def test_the_solid_fraction_is_a_share_of_the_whole_orbit(cycle: int, passes: int) -> None:
    # Times are in half periods: of a mirrored cycle both halves count.
    found = result_of(cycle=cycle, SOLID_TIME=0.3 * cycle, MELTINGS=1.0)
    assert found["solid_fraction"] == pytest.approx(0.3, rel=1e-15)
    assert found["melting_count"] == passes


def test_before_the_first_known_phase_the_film_has_the_last_one() -> None:
    seen = {"SOLID_TIME": 0.5, "UNSEEN_TIME": 0.25, "MELTINGS": 1.0}
    assert result_of(**seen, LAST_PHASE=SOLID)["solid_fraction"] == 0.375
    assert result_of(**seen, LAST_PHASE=MELTED)["solid_fraction"] == 0.25


@pytest.mark.parametrize(("temperature", "fraction"), [(289.0, 1.0), (291.0, 0.0)])
def test_without_a_cubic_term_the_film_is_liquid_above_the_critical_temperature(
    temperature: float, fraction: float
) -> None:
    p = Parameters(cubic_coefficient=0.0, temperature=temperature)
    found = result_of(p, SOLID_TIME=2.0, FIRST_PHASE=SOLID, LAST_PHASE=SOLID, PHI_MAX=0.0)
    assert found["solid_fraction"] == fraction
    assert found["regime"] == (Regime.LOCKED if fraction else Regime.LIQUID)


@pytest.mark.parametrize(("cycle", "periods"), [(1, 1), (2, 1), (3, 3), (4, 2), (10, 5), (16, 8)])
def test_an_orbit_of_an_odd_number_of_half_periods_closes_after_as_many_periods(
    cycle: int, periods: int
) -> None:
    assert result_of(cycle=cycle)["orbit_periods"] == periods


@pytest.mark.parametrize(
    ("meltings", "first", "last", "count"),
    [
        (0, UNSEEN, UNSEEN, 0),
        (2, SOLID, SOLID, 2),
        (2, MELTED, MELTED, 2),
        (2, SOLID, MELTED, 2),
        (2, MELTED, SOLID, 3),  # it melts across the end of the orbit
        (0, MELTED, SOLID, 1),
    ],
)
def test_meltings_are_counted_cyclically(
    meltings: int, first: float, last: float, count: int
) -> None:
    phases = {"MELTINGS": meltings, "FIRST_PHASE": first, "LAST_PHASE": last}
    assert result_of(cycle=2, **phases)["melting_count"] == count
    assert result_of(cycle=3, **phases)["melting_count"] == 2 * count  # ... in the mirror image too


@pytest.mark.parametrize(("height", "asymmetry"), [(0.999, 0.0), (1.0, 1.0)])
def test_asymmetry_needs_a_range_of_at_least_a_pascal(height: float, asymmetry: float) -> None:
    assert result_of(STRESS_MAX=height, STRESS_MIN=0.0)["asymmetry"] == asymmetry


# --- the power balance ----------------------------------------------------------------------------


def test_the_power_balance_includes_the_gained_energy() -> None:
    for miss in (3e-12, -3e-12):
        found = result_of(begin=BEGIN, end=END, BLOCK_WORK=GAINED + miss, ABSOLUTE_WORK=1e-8)
        assert found["power_balance_error"] == pytest.approx(3e-4, rel=1e-6)


def test_a_power_balance_that_is_off_by_more_than_the_limit_is_rejected() -> None:
    work = 1e-8  # above the floor, so that the limit is a part of it
    assert result_of(BLOCK_WORK=0.999 * LIMIT * work)["status"] == Status.OK
    for miss in (1.001 * LIMIT * work, -1.001 * LIMIT * work):
        assert_rejected(result_of(BLOCK_WORK=miss), Status.INVARIANT_VIOLATED)


@pytest.mark.parametrize("cycle", [1, 2])
def test_both_halves_of_an_odd_cycle_have_the_balance_of_the_measured_one(cycle: int) -> None:
    # Half a period gains energy here, and the mirror image as much again.
    begin, end = (1e-7, 0.0), (3e-7, 0.0)
    gained = 3000.0 * (end[0] ** 2 - begin[0] ** 2)
    found = result_of(cycle=cycle, begin=begin, end=end, BLOCK_WORK=gained + 1e-12)
    assert found["power_balance_error"] == pytest.approx(1e-4, rel=1e-6)


@pytest.mark.parametrize("cycle", [1, 2, 6])
@pytest.mark.parametrize("changes", [{}, {"drive_amplitude": -0.8e-6}, {"spring_stiffness": 50.0}])
def test_a_vanishing_force_is_compared_with_a_hundredth_of_the_full_force(
    changes: dict[str, float], cycle: int
) -> None:
    # The floor for all methods is the work of 1 % of the full force over the way of the drive.
    p = Parameters(**changes)
    floor = 0.01 * full_force(p) * (2 * 0.8e-6 * cycle)
    small = {"ABSOLUTE_WORK": 1e-3 * floor}
    kept = result_of(p, cycle=cycle, BLOCK_WORK=0.999 * LIMIT * floor, **small)
    assert kept["status"] == Status.OK
    assert kept["power_balance_error"] == pytest.approx(0.999 * LIMIT / 1e-3)
    broken = result_of(p, cycle=cycle, BLOCK_WORK=1.001 * LIMIT * floor, **small)
    assert_rejected(broken, Status.INVARIANT_VIOLATED)


def test_an_orbit_without_any_work_balances() -> None:
    assert result_of(ABSOLUTE_WORK=0.0)["power_balance_error"] == 0.0
    assert result_of(ABSOLUTE_WORK=0.0)["status"] == Status.OK


# --- the bound of the order parameter -------------------------------------------------------------

BOUND = 0.603782
"""phi_plus at 200 K and no strain."""

BOUNDS = [
    ({}, BOUND),
    ({"temperature": 400.0}, 230.0 / 1700.0),  # liquid only: b/2c
    ({"initial_order_parameter": 0.9}, 0.9),  # a start above the bound
    ({"initial_order_parameter": 0.1}, BOUND),
]


@pytest.mark.parametrize(("changes", "bound"), BOUNDS, ids=str)
def test_an_order_parameter_beyond_its_bound_is_rejected(
    changes: dict[str, float], bound: float
) -> None:
    p = Parameters(**changes)
    assert result_of(p, PHI_MAX=1.0009 * bound)["status"] == Status.OK
    assert_rejected(result_of(p, PHI_MAX=1.0011 * bound), Status.INVARIANT_VIOLATED)


# --- numbers that are not finite ------------------------------------------------------------------


@pytest.mark.parametrize("value", [math.inf, -math.inf])  # no NaN is ever the larger or the smaller
@pytest.mark.parametrize("slot", ["STRESS_MAX", "STRESS_MIN", "FORCE_MAX", "FORCE_MIN"])
def test_an_amplitude_that_is_not_finite_has_diverged(slot: str, value: float) -> None:
    assert_rejected(result_of(**{slot: value}), Status.DIVERGED)


@pytest.mark.parametrize("name", ["STRESS", "FORCE"])
@pytest.mark.parametrize("cycle", [1, 2])
def test_an_orbit_without_a_finite_value_has_diverged(name: str, cycle: int) -> None:
    nothing = {f"{name}_MAX": -math.inf, f"{name}_MIN": math.inf}
    assert_rejected(result_of(cycle=cycle, **nothing), Status.DIVERGED)


def test_an_error_that_is_not_finite_has_diverged() -> None:
    assert_rejected(result_of(error=math.nan), Status.DIVERGED)


@pytest.mark.parametrize("slot", ["BLOCK_WORK", "PHI_MAX"])
def test_an_invariant_that_is_not_a_number_is_violated(slot: str) -> None:
    assert_rejected(result_of(**{slot: math.nan}), Status.INVARIANT_VIOLATED)


def test_a_failure_has_only_its_status_and_periods() -> None:
    row = np.full(len(RESULT_COLUMNS), 77.0)
    write_failure(row, 9, int(Status.STEP_LIMIT))
    assert row[STATUS] == Status.STEP_LIMIT
    assert_rejected(dict(zip(RESULT_COLUMNS, row.tolist(), strict=True)), Status.STEP_LIMIT)
