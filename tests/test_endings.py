"""Every status, reached as in a sweep: through `compute_orbits`, with either method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.points import orbits, refuse_nothing, row

from stickslip import Parameters, Status
from stickslip.compiled.cache import source_hash
from stickslip.dispatch.task import Task, compute_block
from stickslip.kernels.adaptive import driver as adaptive
from stickslip.kernels.euler_cromer import driver as euler_cromer
from stickslip.options import METHODS, Options
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS, RESULTS

VISCOUS = {"elastic_coefficient": 0.0}
COARSE = {"method": "euler-cromer", "dt": 2e-5}

# A solid film under fixed steps: a light block under a small film, few and short periods.
SOLID = {
    "angular_frequency": 2e4,
    "drive_amplitude": 1e-11,
    "contact_area": 6e-13,
    "block_mass": 1e-5,
    "spring_stiffness": 6e4,
    "initial_order_parameter": 0.6,
}
SHORT = {"method": "euler-cromer", "dt": 5e-9, "stationary_rtol": 1e-4}


def assert_nothing_but(found: np.ndarray, status: Status) -> None:
    named = dict(zip(RESULT_COLUMNS, found.tolist(), strict=True))
    assert Status(int(named.pop("status"))) is status
    assert named.pop("periods_integrated") >= -1
    for name, value in named.items():
        np.testing.assert_equal(value, RESULTS[name].missing, err_msg=name)


# --- budgets, refusals, overflows -----------------------------------------------------------------

ENDINGS: list[tuple[dict[str, float], dict[str, Any], Status]] = [
    ({}, {"max_periods": 1}, Status.NOT_STATIONARY),
    ({"rheological_index": 2 / 3}, {"max_periods": 3}, Status.NOT_STATIONARY),
    ({}, {"max_error": 1e-15}, Status.INACCURATE),
    (VISCOUS, {**COARSE, "max_error": 1e-9}, Status.INACCURATE),
    ({}, {"max_steps": 1}, Status.STEP_LIMIT),
    ({}, {"max_steps": 2000}, Status.STEP_LIMIT),
    ({"initial_velocity": 1e200}, {}, Status.DIVERGED),
    ({"initial_displacement": 1e300}, {}, Status.DIVERGED),
    ({}, {"method": "euler-cromer", "dt": 1e-6}, Status.REFUSED),
    ({"initial_velocity": 1e200}, {"method": "euler-cromer"}, Status.REFUSED),
    (VISCOUS, {**COARSE, "max_periods": 1}, Status.NOT_STATIONARY),
    (VISCOUS, {**COARSE, "max_steps": 99}, Status.STEP_LIMIT),
]


@pytest.mark.parametrize(("changes", "options", "status"), ENDINGS, ids=str)
def test_every_way_to_end(
    changes: dict[str, float], options: dict[str, Any], status: Status
) -> None:
    assert_nothing_but(orbits(row(**changes), **options).row[0], status)


@pytest.mark.parametrize("options", [{}, SHORT], ids=["adaptive", "euler-cromer"])
def test_a_good_orbit_is_ok(options: dict[str, Any]) -> None:
    found = orbits(row(**SOLID), **options)
    assert found.status == Status.OK
    assert found.elastic_stress_amplitude > 1e6
    missing = [RESULT_COLUMNS[i] for i in np.flatnonzero(~np.isfinite(found.row[0]))]
    assert missing == ["lyapunov_exponent"]
    assert np.all(np.isfinite(found.final))


def test_a_fixed_step_that_overflows_has_diverged(monkeypatch: pytest.MonkeyPatch) -> None:
    # Past the refusal, which would keep it from being tried.
    monkeypatch.setattr(euler_cromer, "largest_step", refuse_nothing)
    found = orbits(row(angular_frequency=2e3), **COARSE)
    assert_nothing_but(found.row[0], Status.DIVERGED)


# --- invariants -----------------------------------------------------------------------------------


def test_orbits_of_an_unstable_step_break_the_power_balance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Past the refusal: 8 times too much force and no NaN.
    monkeypatch.setattr(euler_cromer, "largest_step", refuse_nothing)
    options = {**COARSE, "dt": 2.6e-5, "stationary_rtol": 1e-2}
    found = orbits(row(rheological_index=0.0), **options)
    assert_nothing_but(found.row[0], Status.INVARIANT_VIOLATED)


def colder(points: np.ndarray) -> np.ndarray:
    """Films that become more solid than the ones they are judged as: phi_plus is 2 % larger."""
    other = points.copy()
    other[:, Parameters._fields.index("temperature")] -= 20.0
    return other


def adaptive_of_colder_films(monkeypatch: pytest.MonkeyPatch) -> None:
    motions_of = adaptive.motions_of
    monkeypatch.setattr(
        adaptive, "motions_of", lambda points, *others: motions_of(colder(points), *others)
    )


def euler_cromer_of_colder_films(monkeypatch: pytest.MonkeyPatch) -> None:
    march = euler_cromer.March
    monkeypatch.setattr(
        euler_cromer, "March", lambda points, *others: march(colder(points), *others)
    )


@pytest.mark.parametrize(
    ("break_it", "options"),
    [(adaptive_of_colder_films, {}), (euler_cromer_of_colder_films, SHORT)],
    ids=["adaptive", "euler-cromer"],
)
def test_an_order_parameter_beyond_its_bound_is_not_believed(
    break_it: Callable[[pytest.MonkeyPatch], None],
    options: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert orbits(row(**SOLID), **options).status == Status.OK
    break_it(monkeypatch)
    found = orbits(row(**SOLID), **options)
    assert_nothing_but(found.row[0], Status.INVARIANT_VIOLATED)


# --- exceptions -----------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_an_exception_fails_the_point_and_not_its_neighbours(
    method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = np.array([row(**SOLID), row(**SOLID, temperature=210.0), row(**SOLID)])
    options = Options(**SHORT | {"method": method})
    expected, _ = compute_orbits(points, options)
    kernels = METHODS[method].kernels
    compute = kernels.orbits

    def broken(points: np.ndarray, *others: Any) -> None:
        if np.any(points == 210.0):
            raise ZeroDivisionError
        compute(points, *others)

    monkeypatch.setattr(kernels, "orbits", broken)
    with pytest.raises(ZeroDivisionError):
        compute_orbits(points, options)
    block = compute_block(Task(np.arange(3), points, options, source_hash()))
    assert_nothing_but(block.results[1], Status.FAILED)
    np.testing.assert_array_equal(block.results[[0, 2]], expected[[0, 2]])
    assert "ZeroDivisionError" in block.messages[0]


def test_every_status_is_provoked_here() -> None:
    provoked = {status for _, _, status in ENDINGS}
    provoked |= {Status.OK, Status.INVARIANT_VIOLATED, Status.FAILED}
    provoked |= {Status.APERIODIC}  # by claims/test_aperiodic.py
    provoked |= {Status.UNSTABLE}  # by claims/test_weak_coupling.py
    provoked |= {Status.INTERPOLATED}  # by engine/test_refine.py
    assert provoked == set(Status) - {Status.PENDING}  # which means that nothing was computed
