"""Orbits: their values, all statuses, and that points do not affect each other."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import fields

import numpy as np
import pytest
from support.points import orbits, row, rows

from stickslip import NoiseError, OptionError, Options, Parameters, Status, simulate
from stickslip.kernels.adaptive.passes import pass_kernel
from stickslip.kernels.adaptive.rows import row_kernels
from stickslip.kernels.families import Family
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.parameter_rows import final_columns
from stickslip.numerics.spectrum import spectral_radii
from stickslip.options import DEFAULTS, METHODS
from stickslip.orbit import Orbit, compute_orbits, failed_row, prepared_points, stationary_orbit
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS, RESULTS

COUNTS = {"orbit_periods", "melting_count", "solid_transition_count", "periods_integrated"}

VISCOUS = {"elastic_coefficient": 0.0}
"""Without elasticity the film allows fixed steps of 4e-5 s, and orbits take milliseconds."""


# --- values ---------------------------------------------------------------------------------------


def test_an_orbit_holds_the_result_columns_by_name() -> None:
    orbit = stationary_orbit(Parameters(temperature=250.0))
    found = orbits(row(temperature=250.0))
    assert type(orbit) is Orbit
    assert orbit._fields == (*RESULT_COLUMNS, "state")
    for name in RESULT_COLUMNS:
        np.testing.assert_equal(getattr(orbit, name), getattr(found, name)[0])
    assert orbit.state == tuple(found.final[0, :3])


def test_counts_are_integers_and_the_status_is_a_status() -> None:
    orbit = stationary_orbit()
    for name in set(RESULT_COLUMNS) - {"status", "regime"}:
        assert type(getattr(orbit, name)) is (int if name in COUNTS else float)
    assert orbit.status is Status.OK
    assert orbit.regime is Regime.STICK_SLIP_SYMMETRIC


def test_an_orbit_is_equal_to_its_pickle() -> None:
    """Even if some of its numbers are NaN."""
    for orbit in (stationary_orbit(), stationary_orbit(max_periods=1)):
        again = pickle.loads(pickle.dumps(orbit))
        assert again == orbit
        assert (again != orbit) is False
        assert hash(again) == hash(orbit)
        assert again != orbit._replace(asymmetry=0.5)
        assert again != tuple(orbit)


def test_the_paper_is_the_default() -> None:
    orbit = stationary_orbit()
    np.testing.assert_equal(orbit._asdict(), stationary_orbit(Parameters())._asdict())
    assert orbit.elastic_stress_amplitude == pytest.approx(4.3047779e6, rel=1e-6)
    assert orbit.friction_force_amplitude == pytest.approx(2.8121364e-3, rel=1e-6)


@pytest.mark.parametrize(
    "changes",
    [{"rheological_index": 0.0}, {"rheological_index": 2 / 3}, {"spring_stiffness": 500.0}],
    ids=str,
)
def test_the_state_is_within_the_tolerance_of_the_limit(changes: dict[str, float]) -> None:
    # Plain iteration of offsets that take 10 to 300 periods for one e-fold: a small step from one
    # period to the next is not a small distance to the limit.
    scale = [0.8e-6, 0.8e-6 * 10]
    near = orbits(row(**changes), rtol=1e-8, stationary_rtol=1e-4, accelerate=False)
    limit = orbits(row(**changes), rtol=1e-8, stationary_rtol=1e-8)
    distance = np.max(np.abs((near.final - limit.final)[0, :2] / scale))
    assert (near.status, limit.status) == (Status.OK, Status.OK)
    assert distance < 1.2e-4
    assert near.periods_integrated < 1000


def test_a_tighter_tolerance_states_a_smaller_error() -> None:
    errors = [stationary_orbit(rtol=rtol).amplitude_error for rtol in (1e-4, 1e-6, 1e-8)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


# --- many points ----------------------------------------------------------------------------------


def test_points_are_not_modified() -> None:
    points = np.array([row(initial_velocity=1e200), row(initial_order_parameter=0.6)])
    before = points.copy()
    compute_orbits(points, Options(max_periods=1))
    prepared_points(points[1:], "none")
    np.testing.assert_array_equal(points, before)


def test_one_compiled_version_serves_all() -> None:
    compute_orbits(row(), Options(max_periods=1))
    compute_orbits(rows("temperature", [200, 210]), Options(rtol=np.float32(1e-3), max_steps=5))
    compute_orbits(row(), Options())
    compute_orbits(rows("temperature", [200, 210]), Options())
    law = DEFAULTS.physics
    own = conversion_of(law)
    kernels = pass_kernel(Family(law, -2 / 3)), own.reduce_points.kernel, own.restore_states.kernel
    for kernel in (*kernels, *row_kernels(law), spectral_radii):
        assert len(kernel.signatures) == 1


def test_no_points_give_no_results() -> None:
    results, finals = compute_orbits(np.empty((0, len(Parameters._fields))), Options())
    assert results.shape == (0, len(RESULT_COLUMNS))
    assert finals.shape == (0, len(final_columns(DEFAULTS.physics)))


# --- budgets, refusals, noise ---------------------------------------------------------------------


def just_enough(most: int, is_enough: Callable[[int], bool]) -> tuple[int, int]:
    """The largest number up to `most` that is not enough, and the next one, which is."""
    low, high = 1, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if is_enough(middle) else (middle, high)
    return low, high


def test_a_step_budget_that_is_just_enough() -> None:
    # The budget covers the search and the measurement; one step less is a step too few.
    low, high = just_enough(
        1_000_000, lambda steps: orbits(row(), max_steps=steps).status[0] == Status.OK
    )
    short, enough = orbits(row(), max_steps=low), orbits(row(), max_steps=high)
    assert (short.status, enough.status) == (Status.STEP_LIMIT, Status.OK)
    np.testing.assert_array_equal(enough.row, orbits(row()).row)
    assert 5_000 < high < 200_000  # an effort budget: 2e4 when this was written


def test_periods_integrated_count_search_and_measurement() -> None:
    # The half periods of the search and of one measured cycle, rounded up to periods.
    for changes in ({}, {"angular_frequency": 38.0}, {"rheological_index": 2 / 3}):
        found = orbits(row(**changes))
        n, cycle = int(found.periods_integrated[0]), int(found.orbit_periods[0])
        enough = next(m for m in range(1, n + 1) if orbits_within(m, **changes) == Status.OK)
        assert orbits_within(enough - 1, **changes) == Status.NOT_STATIONARY
        assert enough <= n <= enough + cycle
    assert orbits(row(), max_periods=3).periods_integrated == 3


def orbits_within(max_periods: int, **changes: float) -> int:
    return int(orbits(row(**changes), max_periods=max_periods).status[0])


@pytest.mark.parametrize("status", [Status.REFUSED, Status.FAILED])
def test_the_row_of_a_point_that_was_not_computed_has_missing_values(status: Status) -> None:
    found = dict(zip(RESULT_COLUMNS, failed_row(status).tolist(), strict=True))
    assert found.pop("status") == status
    for name, value in found.items():
        np.testing.assert_equal(value, RESULTS[name].missing)
    assert failed_row()[RESULT_COLUMNS.index("status")] == Status.FAILED


def test_only_the_unstable_points_of_a_batch_are_refused() -> None:
    points = np.array([row(), row(**VISCOUS), row(block_mass=1e-3)])
    found = orbits(points, method="euler-cromer", dt=2e-5)
    assert found.status.tolist() == [Status.REFUSED, Status.OK, Status.REFUSED]
    alone = orbits(points[1], method="euler-cromer", dt=2e-5)
    np.testing.assert_array_equal(found.row[1], alone.row[0])


@pytest.mark.parametrize("method", METHODS)
def test_a_film_that_could_never_solidify_is_an_error(method: str) -> None:
    for scene, noise in (({}, "none"), ({"noise_intensity": 0.0}, "typical-path")):
        with pytest.raises(NoiseError, match="could never solidify"):
            orbits(row(**scene), method=method, noise=noise)
    with pytest.raises(NoiseError):
        stationary_orbit(noise="none")


def test_without_noise_a_melted_film_stays_liquid() -> None:
    # A model without noise has a finite, smooth and wrong result, the force of the liquid. The
    # logarithm of the order parameter falls forever, and is meaningless below a floor.
    scene = {"initial_order_parameter": 0.6}
    assert orbits(row(**scene), noise="none", max_periods=300).status == Status.OK
    last = simulate(Parameters(**scene), noise="none", periods=20).isel(
        elapsed_time=slice(-2000, None)
    )
    assert float(np.abs(last.elastic_stress).max()) < 1.0
    assert float(last.friction_force.max()) == pytest.approx(0.599e-3, rel=1e-3)


def test_without_noise_a_film_that_stays_solid_is_the_same() -> None:
    scene = {"initial_order_parameter": 0.6, "rheological_index": 0.0}
    without, zero = orbits(row(**scene), noise="none"), orbits(row(**scene, noise_intensity=0.0))
    assert without.status == Status.OK
    np.testing.assert_array_equal(zero.row, without.row)
    np.testing.assert_allclose(
        without.elastic_stress_amplitude, orbits(row(**scene)).elastic_stress_amplitude, rtol=1e-5
    )


def test_the_noise_intensity_shows_where_solidification_decides() -> None:
    found = orbits(rows("noise_intensity", [1e-12, 1e-18, 1e-24], angular_frequency=15.0))
    np.testing.assert_allclose(
        found.elastic_stress_amplitude, [3.10e6, 3.02e6, 2.94e6], rtol=0, atol=0.01e6
    )


# --- the two methods in one process ---------------------------------------------------------------


def test_methods_and_steps_have_different_results() -> None:
    coarse = {"method": "euler-cromer", "dt": 2e-5, "stationary_rtol": 1e-5}
    adaptive = orbits(row(**VISCOUS), stationary_rtol=1e-5)
    fixed, finer = orbits(row(**VISCOUS), **coarse), orbits(row(**VISCOUS), **coarse | {"dt": 1e-5})
    assert fixed.friction_force_amplitude != adaptive.friction_force_amplitude
    assert fixed.friction_force_amplitude != finer.friction_force_amplitude


@pytest.mark.parametrize(
    # rtol sets stationary_rtol as well, and a switch accepts anything.
    "name",
    sorted({field.name for field in fields(Options)} - {"stationary_rtol", "accelerate"}),
)
def test_every_option_reaches_the_orbit(name: str) -> None:
    with pytest.raises(OptionError, match=f"^{name} must be "):
        stationary_orbit(**{name: "nonsense"})


def test_the_step_budget_bounds_the_error_estimate_too() -> None:
    needed = stationary_orbit(rtol=1e-4)
    assert needed.status is Status.OK
    for budget in (300, 1000, 3000, 10_000):
        orbit = stationary_orbit(rtol=1e-4, max_steps=budget)
        assert orbit.status in (Status.OK, Status.STEP_LIMIT)
    low, _ = just_enough(
        10_000, lambda steps: stationary_orbit(rtol=1e-4, max_steps=steps).status is Status.OK
    )
    found = orbits(row(), rtol=1e-4, stationary_rtol=1e-4, max_steps=low)
    assert found.status == Status.STEP_LIMIT
    # The search had succeeded, and the finer measurement ran out of steps.
    assert found.periods_integrated >= needed.periods_integrated - 1
