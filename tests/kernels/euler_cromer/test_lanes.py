"""Euler-Cromer in lanes, alone or with others, gives the numbers of the scalar integrator."""

from __future__ import annotations

import numpy as np
import pytest
from support.marches import FAST_DT, fast, march_of, period
from support.marks import marked, one_then
from support.scalar_twins import euler_cromer_period
from support.symmetries import SYMMETRIES, Symmetry, transformed

from stickslip import Parameters, Status
from stickslip.measure.accumulate import (
    FIRST_PHASE,
    FORCE,
    HIGHEST,
    IMPULSE,
    LAST_PHASE,
    MELTINGS,
    PHI_MAX,
    RECORD_TABLE,
    SIZE,
    SQUARE,
    STRESS,
    STRESS_MAX,
    STRESS_MIN,
    WORK,
    slots_of,
)

GAMMAS = (-2 / 3, -0.5)
OTHER_GAMMAS = (0.0, 2 / 3, 0.4)
LIQUID = {"temperature": 320.0, "initial_order_parameter": 0.3}
STICK_SLIP = {"drive_amplitude": 1.5e-8, "temperature": 150.0}


def fluids(gammas: tuple[float, ...]) -> dict[str, dict[str, float]]:
    """Return points of these rheological indices, with and without noise."""
    noisy = {f"gamma={gamma:.2f}": {"rheological_index": gamma} for gamma in gammas}
    return noisy | {f"{name} quiet": p | {"noise_intensity": 0.0} for name, p in noisy.items()}


FLUIDS = fluids((*GAMMAS, *OTHER_GAMMAS))
# The suite compiles three kernels, `make stress` the kernels of all fluids.
COMPILED = ("gamma=-0.67", "gamma=-0.67 quiet", "gamma=-0.50")
POINTS: dict[str, dict[str, float]] = {
    **{name: FLUIDS[name] for name in COMPILED},
    "liquid": LIQUID,
    "solidifying": {"temperature": 150.0, "initial_order_parameter": 0.0},
    "melting": STICK_SLIP,
    "strong noise": {"noise_intensity": 1.0, "temperature": 289.0},
    "no elasticity": {"elastic_coefficient": 0.0},
    "no viscosity": {"viscosity_coefficient": 0.0},
    "no springs": {"spring_stiffness": 0.0},
    "second order": {"cubic_coefficient": 0.0},
    "second order, liquid": {"cubic_coefficient": 0.0, **LIQUID},
    "mirrored": {"drive_amplitude": -8e-9},
}
SETS = one_then("stress", [POINTS, FLUIDS])
SET_NAMES = ["suite", "every fluid"]


def assert_close(
    p: Parameters,
    found: tuple[np.ndarray, np.ndarray],
    exact: tuple[np.ndarray, np.ndarray],
    rtol: float = 1e-12,
) -> None:
    """Assert agreement to `rtol` of the scales that tolerances refer to."""
    X_m = abs(p.drive_amplitude)
    sizes = np.array([X_m, X_m * p.angular_frequency])
    np.testing.assert_array_less(np.abs(found[0] - exact[0])[:2] / sizes, rtol)
    np.testing.assert_allclose(found[0][2], exact[0][2], rtol=rtol, atol=1e-300)
    record, other = found[1], exact[1]
    units = np.array([slot.unit for slot in RECORD_TABLE])
    size_of = {unit: max(np.abs(other[units == unit])) for unit in (STRESS, FORCE, WORK, IMPULSE)}
    for unit, size in size_of.items():
        apart = np.abs(record - other)[units == unit]
        np.testing.assert_array_less(apart, rtol * (size if size > 0 else 1.0))
    np.testing.assert_allclose(record[PHI_MAX], other[PHI_MAX], rtol=rtol)
    counted = ~np.isin(units, list(size_of))
    np.testing.assert_allclose(record[counted], other[counted], rtol=100 * rtol)


@pytest.mark.parametrize("points", SETS, ids=SET_NAMES)
def test_a_period_agrees_with_the_scalar_drive(points: dict[str, dict[str, float]]) -> None:
    for changes in points.values():
        p = fast(**changes)
        states, records, statuses = period([p], FAST_DT)
        state, record, status = euler_cromer_period(p, FAST_DT)
        assert statuses[0] == status == Status.OK, changes
        assert_close(p, (states[0], records[0]), (state, record))


def test_the_points_have_all_phases_and_meltings() -> None:
    records = period([fast(**changes) for changes in POINTS.values()], FAST_DT)[1]
    assert set(records[:, FIRST_PHASE]) == {1.0, 2.0}
    assert set(records[:, LAST_PHASE]) == {1.0, 2.0}
    assert records[:, MELTINGS].max() >= 1
    solid = records[list(POINTS).index("melting")]
    assert np.abs(solid[[STRESS_MAX, STRESS_MIN]]).max() > 1e6


@pytest.mark.stress
def test_a_stick_slip_period_at_a_fine_step_agrees_with_the_scalar_drive() -> None:
    p = Parameters(angular_frequency=38.0, initial_order_parameter=0.6)
    states, records, _ = period([p], 1e-8)
    state, record, _ = euler_cromer_period(p, 1e-8)
    assert record[MELTINGS] >= 1
    # The work is a sum of 16 million terms, whose roundings add up.
    assert_close(p, (states[0], records[0]), (state, record), rtol=1e-10)


@pytest.mark.stress
@pytest.mark.parametrize("of", SETS, ids=SET_NAMES)
def test_travelling_and_measuring_end_in_the_same_state(of: dict[str, dict[str, float]]) -> None:
    points = [fast(**changes) for changes in of.values()]
    march = march_of(points, FAST_DT)
    march.start(np.arange(len(points)))
    march.march(measured=False)
    np.testing.assert_allclose(march.states(), period(points, FAST_DT)[0], rtol=1e-9)


# --- neighbours ----------------------------------------------------------------------------------


def varied(count: int) -> tuple[list[Parameters], np.ndarray]:
    """Return points of all fluids with various periods and steps."""
    rng = np.random.default_rng(3)
    points = [
        fast(
            temperature=rng.uniform(200.0, 300.0),
            rheological_index=GAMMAS[i % len(GAMMAS)],
            angular_frequency=omega,
            drive_amplitude=1.6e-5 / omega,
            noise_intensity=0.0 if i % 4 == 0 else 1e-18,
        )
        for i, omega in enumerate(rng.uniform(2e4, 2e5, count).tolist())
    ]
    return points, rng.uniform(0.5 * FAST_DT, FAST_DT, count)


def test_a_point_does_not_depend_on_the_other_lanes() -> None:
    points, steps = varied(150)
    together = period(points, steps)
    order = np.random.default_rng(5).permutation(len(points))
    shuffled = period([points[i] for i in order], steps[order])
    for ours, theirs in zip(together, shuffled, strict=True):
        np.testing.assert_array_equal(theirs, ours[order])
    for i in (0, 71, 149):
        alone = period([points[i]], steps[i])
        for ours, theirs in zip(together, alone, strict=True):
            np.testing.assert_array_equal(theirs[0], ours[i])


# --- symmetries ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SYMMETRIES)
def test_symmetries_hold_bit_for_bit(name: str) -> None:
    symmetry = SYMMETRIES[name]
    points = [fast(**changes) for changes in POINTS.values()]
    states, records, _ = period(points, FAST_DT)
    other, other_records, _ = period([transformed(p, symmetry) for p in points], FAST_DT)
    motion = symmetry.motion
    np.testing.assert_array_equal(other, states * [motion, motion, 1.0])
    np.testing.assert_array_equal(other_records, transformed_records(records, symmetry))


def transformed_records(records: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    work = symmetry.force * symmetry.motion
    force = symmetry.force
    factor_of = {STRESS: symmetry.stress, FORCE: force, WORK: work}
    factor_of |= {IMPULSE: force, SIZE: abs(force), SQUARE: force * force}
    factors = [factor_of.get(slot.unit, 1.0) for slot in RECORD_TABLE]
    found = records * factors
    for slot in slots_of(HIGHEST):
        if factors[slot] < 0:
            found[:, [slot, slot + 1]] = found[:, [slot + 1, slot]]
    return found


# --- order ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", [GAMMAS[0], *marked("stress", [*GAMMAS[1:], *OTHER_GAMMAS])])
def test_errors_fall_in_proportion_to_the_step(gamma: float) -> None:
    p = fast(rheological_index=gamma, initial_displacement=4e-9)
    steps = FAST_DT * np.array([1.0, 0.5, 0.25, 0.125, 1 / 64])
    states = period([p] * len(steps), steps)[0][:, 0]
    errors = np.abs(states[:-1] - states[-1]) / (1.0 - steps[-1] / steps[:-1])
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps[:-1]))
    np.testing.assert_allclose(slopes, 1.0, atol=0.2)
