"""Euler-Cromer in lanes against the scalar drive: the same numbers, alone and in company."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba.core import config as numba_config
from support.points import row
from test_symmetries import SYMMETRIES, Symmetry, expected, transformed

from stickslip import Parameters, Status, kernels
from stickslip.compiled.decorators import jit
from stickslip.compiled.elementary import reciprocal
from stickslip.kernels.euler_cromer import march
from stickslip.kernels.euler_cromer.layout import write_steps
from stickslip.kernels.euler_cromer.march import FixedLanes, general_march
from stickslip.kernels.euler_cromer.scaling import step_parameters, step_units
from stickslip.kernels.euler_cromer.search import fixed_lane_orbits
from stickslip.kernels.observers import measuring
from stickslip.kernels.problem import fixed_period
from stickslip.kernels.rows import parameters_of
from stickslip.measure import accumulate
from stickslip.model import noise
from stickslip.numerics.euler_cromer_lanes import PENDING, STEPS_BETWEEN_CHECKS
from stickslip.options import Options

# A short and fast drive: few steps of a stable size make a period of the solid film.
FAST = {
    "angular_frequency": 2e3,
    "drive_amplitude": 8e-9,
    "initial_order_parameter": 0.6,
    "temperature": 250.0,
    "initial_displacement": 2e-10,
    "initial_velocity": 2e-6,
}
FAST_DT = 5e-9
GAMMAS = (-2 / 3, 0.0, 2 / 3, -0.5, 0.4)
LIQUID = {"temperature": 320.0, "initial_order_parameter": 0.3}
STICK_SLIP = {"drive_amplitude": 1.5e-8, "temperature": 150.0}
SCENES: dict[str, dict[str, float]] = {
    **{f"gamma={gamma:.2f}": {"rheological_index": gamma} for gamma in GAMMAS},
    **{f"gamma={gamma:.2f} quiet": {"rheological_index": gamma, "noise_intensity": 0.0}
       for gamma in GAMMAS},
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
}  # fmt: skip


def scene(**changes: float) -> Parameters:
    return Parameters(**{**FAST, **changes})


@jit
def scalar_period(point, settings, y, record):
    accumulate.start(record)
    return fixed_period(
        parameters_of(point), settings, y, 0.0, settings.max_steps, measuring(record)
    )


def by_scalar(p: Parameters, dt: float) -> tuple[np.ndarray, np.ndarray, int]:
    """State (x, v, phi) and record after a period, and the status."""
    record = np.empty(accumulate.LENGTH)
    settings = Options(method="euler-cromer", dt=dt).settings()
    y, _, _, status = scalar_period(np.array(p), settings, start_of(p), record)
    return np.array(y), record, status


def start_of(p: Parameters) -> tuple[float, float, float]:
    state = np.empty(3)
    kernels.starting_log_state(np.array(p), state)
    return float(state[0]), float(state[1]), float(np.exp(state[2]))


def lanes_of(points: list[Parameters], dt: float | np.ndarray) -> FixedLanes:
    array = np.array(points)
    steps = np.empty(len(points), np.int64)
    for i, step in enumerate(np.broadcast_to(dt, len(points)).tolist()):
        write_steps(array[i : i + 1], step, steps[i : i + 1])
    return FixedLanes(array, steps, np.array([start_of(p) for p in points]))


def period(
    points: list[Parameters], dt: float | np.ndarray, budget: int | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States and records after a measured period, and the statuses."""
    lanes = lanes_of(points, dt)
    lanes.start(np.arange(len(points)))
    while np.any(lanes.tasks.status == PENDING):
        lanes.march(measured=True, budget=budget)
    return lanes.states(), lanes.records()[:, : accumulate.SLOTS], lanes.tasks.status


def assert_close(
    p: Parameters,
    found: tuple[np.ndarray, np.ndarray],
    exact: tuple[np.ndarray, np.ndarray],
    rtol: float = 1e-12,
) -> None:
    """Agreement to `rtol` of the sizes that tolerances refer to."""
    X_m = abs(p.drive_amplitude)
    sizes = np.array([X_m, X_m * p.angular_frequency])
    np.testing.assert_array_less(np.abs(found[0] - exact[0])[:2] / sizes, rtol)
    np.testing.assert_allclose(found[0][2], exact[0][2], rtol=rtol, atol=1e-300)
    record, other = found[1], exact[1]
    stress = np.max(np.abs(other[[accumulate.STRESS_MAX, accumulate.STRESS_MINUS_MIN]]))
    force = np.max(np.abs(other[[accumulate.FORCE_MAX, accumulate.FORCE_MINUS_MIN]]))
    work = other[accumulate.ABSOLUTE_WORK]
    scales = np.array([stress, stress, force, force, work, work, work, other[accumulate.PHI_MAX]])
    np.testing.assert_array_less(
        np.abs(record[:8] - other[:8]), rtol * np.where(scales > 0, scales, 1.0)
    )
    np.testing.assert_array_equal(record[8:], other[8 : accumulate.SLOTS])


@pytest.mark.parametrize("name", SCENES)
def test_a_period_is_that_of_the_scalar_drive(name: str) -> None:
    p = scene(**SCENES[name])
    states, records, statuses = period([p], FAST_DT)
    state, record, status = by_scalar(p, FAST_DT)
    assert statuses[0] == status == Status.OK
    assert_close(p, (states[0], records[0]), (state, record))


def test_the_scenes_see_all_there_is_to_be_measured() -> None:
    records = period([scene(**changes) for changes in SCENES.values()], FAST_DT)[1]
    assert set(records[:, accumulate.FIRST_PHASE]) == {1.0, 2.0}
    assert set(records[:, accumulate.LAST_PHASE]) == {1.0, 2.0}
    assert records[:, accumulate.MELTINGS].max() >= 1
    solid = records[list(SCENES).index("melting")]
    assert solid[[accumulate.STRESS_MAX, accumulate.STRESS_MINUS_MIN]].max() > 1e6


@pytest.mark.slow
def test_a_stick_slip_period_at_a_fine_step_is_that_of_the_scalar_drive() -> None:
    p = Parameters(angular_frequency=38.0, initial_order_parameter=0.6)
    states, records, _ = period([p], 1e-8)
    state, record, _ = by_scalar(p, 1e-8)
    assert record[accumulate.MELTINGS] >= 1
    # The work is a sum of 16 million terms, whose roundings add up.
    assert_close(p, (states[0], records[0]), (state, record), rtol=1e-10)


def test_travelling_and_measuring_lead_to_the_same_state() -> None:
    points = [scene(**changes) for changes in SCENES.values()]
    lanes = lanes_of(points, FAST_DT)
    lanes.start(np.arange(len(points)))
    lanes.march(measured=False)
    np.testing.assert_allclose(lanes.states(), period(points, FAST_DT)[0], rtol=1e-9)


# --- company -------------------------------------------------------------------------------------


def varied(count: int) -> tuple[list[Parameters], np.ndarray]:
    """Points of all fluids with periods and steps of their own."""
    rng = np.random.default_rng(3)
    points = [
        scene(
            temperature=rng.uniform(200.0, 300.0),
            rheological_index=GAMMAS[i % len(GAMMAS)],
            angular_frequency=omega,
            drive_amplitude=1.6e-5 / omega,
            noise_intensity=[1e-18, 0.0][i % 2],
        )
        for i, omega in enumerate(rng.uniform(2e4, 2e5, count).tolist())
    ]
    return points, rng.uniform(0.5 * FAST_DT, FAST_DT, count)


def test_a_point_does_not_know_who_shares_the_lanes() -> None:
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


def test_where_a_budget_ends_makes_no_difference() -> None:
    points, steps = varied(30)
    for ours, theirs in zip(period(points, steps), period(points, steps, 1000), strict=True):
        np.testing.assert_array_equal(theirs, ours)


def test_a_point_that_diverges_is_noticed_and_leaves_the_others_alone() -> None:
    points, steps = varied(30)
    steps[13] = 5e-5  # far beyond the largest stable one
    bad = points[13]._replace(angular_frequency=10.0)
    lanes = lanes_of([*points[:13], bad, *points[14:]], steps)
    lanes.start(np.arange(30))
    lanes.march(measured=True)
    others = np.delete(np.arange(30), 13)
    alone = period([points[i] for i in others], steps[others])
    assert lanes.tasks.status[13] == Status.DIVERGED
    assert lanes.tasks.done[13] <= STEPS_BETWEEN_CHECKS
    np.testing.assert_array_equal(lanes.tasks.status[others], Status.OK)
    np.testing.assert_array_equal(lanes.states()[others], alone[0])
    np.testing.assert_array_equal(lanes.records()[others, : accumulate.SLOTS], alone[1])


# --- symmetries ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SYMMETRIES)
def test_symmetries_hold_bit_for_bit(name: str) -> None:
    symmetry = SYMMETRIES[name]
    points = [scene(**changes) for changes in SCENES.values()]
    states, records, _ = period(points, FAST_DT)
    other, other_records, _ = period([transformed(p, symmetry) for p in points], FAST_DT)
    motion = symmetry.motion
    np.testing.assert_array_equal(other, states * [motion, motion, 1.0])
    np.testing.assert_array_equal(other_records, transformed_records(records, symmetry))


def transformed_records(records: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    found = records.copy()
    for slot, factor in (
        (accumulate.STRESS_MAX, symmetry.stress),
        (accumulate.FORCE_MAX, symmetry.force),
    ):
        pair = records[:, [slot, slot + 1]] * abs(factor)
        found[:, [slot, slot + 1]] = pair if factor > 0 else pair[:, ::-1]
    work = slice(accumulate.DRIVE_WORK, accumulate.BLOCK_WORK + 1)
    found[:, work] *= symmetry.force * symmetry.motion
    return found


# --- order ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", GAMMAS)
def test_errors_fall_in_proportion_to_the_step(gamma: float) -> None:
    p = scene(rheological_index=gamma, initial_displacement=4e-9)
    steps = FAST_DT * np.array([1.0, 0.5, 0.25, 0.125, 1 / 64])
    states = period([p] * len(steps), steps)[0][:, 0]
    errors = np.abs(states[:-1] - states[-1]) / (1.0 - steps[-1] / steps[:-1])
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps[:-1]))
    np.testing.assert_allclose(slopes, 1.0, atol=0.2)


# --- orbits --------------------------------------------------------------------------------------

ORBITS: list[dict[str, float]] = [
    {"elastic_coefficient": 0.0},
    {"elastic_coefficient": 0.0, "rheological_index": -0.5},
    {"elastic_coefficient": 0.0, "spring_stiffness": 2500.0, "drive_amplitude": -0.8e-6},
    {"elastic_coefficient": 0.0, "angular_frequency": 17.0, "noise_intensity": 0.0,
     "initial_order_parameter": 0.1},
]  # fmt: skip


def both_orbits(points: np.ndarray, **options: float) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    settings = Options(method="euler-cromer", **options).settings()
    found = []
    for door in (kernels.fixed_orbits, fixed_lane_orbits):
        results, finals = np.full((len(points), 13), np.nan), np.full((len(points), 4), np.nan)
        door(points, settings, results, finals)
        found.append((results, finals))
    return tuple(found)


def test_orbits_are_those_of_the_scalar_kernel() -> None:
    points = np.array([row(**changes) for changes in ORBITS])
    (scalar, scalar_finals), (found, finals) = both_orbits(
        points, dt=2e-5, stationary_rtol=1e-5, max_periods=300
    )
    assert np.all(scalar[:, -1] == Status.OK)
    np.testing.assert_array_equal(found[:, [8, 9, 11, 12]], scalar[:, [8, 9, 11, 12]])
    np.testing.assert_allclose(found[:, :6], scalar[:, :6], rtol=1e-10, atol=1e-9)
    # Errors are differences of nearly equal numbers, one of which has a tolerance of 1e-9.
    np.testing.assert_allclose(found[:, 6:8], scalar[:, 6:8], atol=1e-8)
    np.testing.assert_allclose(found[:, 10], scalar[:, 10], atol=1e-10)
    np.testing.assert_allclose(finals, scalar_finals, rtol=1e-8)


@pytest.mark.parametrize(
    ("options", "status"),
    [
        ({"max_periods": 1}, Status.NOT_STATIONARY),
        ({"max_steps": 10_000}, Status.STEP_LIMIT),
        ({"max_steps": 100_000}, Status.STEP_LIMIT),
    ],
    ids=str,
)
def test_failures_are_those_of_the_scalar_kernel(options: dict[str, int], status: Status) -> None:
    points = np.array([row(**changes) for changes in ORBITS])
    (scalar, scalar_finals), (found, finals) = both_orbits(points, dt=2e-5, **options)
    assert status in scalar[:, -1]
    np.testing.assert_array_equal(found[:, -2:], scalar[:, -2:])
    np.testing.assert_array_equal(np.isnan(found), np.isnan(scalar))
    np.testing.assert_allclose(finals, scalar_finals, rtol=1e-8)


def test_an_orbit_that_diverges_is_that_of_the_scalar_kernel() -> None:
    points = np.array([row(angular_frequency=2e3), row(elastic_coefficient=0.0)])
    (scalar, _), (found, _) = both_orbits(points, dt=2e-5, stationary_rtol=1e-3)
    assert scalar[:, -1].tolist() == [Status.DIVERGED, Status.OK]
    np.testing.assert_array_equal(found[:, -1], scalar[:, -1])
    np.testing.assert_array_equal(found[0], scalar[0])


@pytest.mark.parametrize("name", SYMMETRIES)
def test_symmetries_of_orbits_hold_bit_for_bit(name: str) -> None:
    symmetry = SYMMETRIES[name]
    p = Parameters(elastic_coefficient=0.0, initial_displacement=1e-7)
    points = np.array([p, transformed(p, symmetry)])
    settings = Options(method="euler-cromer", dt=2e-5, stationary_rtol=1e-4).settings()
    results, finals = np.empty((2, 13)), np.empty((2, 4))
    fixed_lane_orbits(points, settings, results, finals)
    assert results[0, -1] == Status.OK
    np.testing.assert_array_equal(results[1], expected(results[0], symmetry))
    np.testing.assert_array_equal(finals[1], finals[0] * [symmetry.motion, symmetry.motion, 1, 1])


# --- arithmetic ----------------------------------------------------------------------------------


@given(st.floats(1e-300, 1e300))
def test_a_reciprocal_is_exact_to_two_ulp(x: float) -> None:
    assert reciprocal(x) == pytest.approx(1.0 / x, rel=3e-16)


def test_a_kick_is_that_of_the_typical_path() -> None:
    # Above and below the noise of a single step.
    for phi in (1e-12, 1e-10, 1e-5, 0.3):
        p = scene(noise_intensity=1e-12)
        own, units = step_parameters(p, 1000), step_units(p, 1000)
        D_eff, dt = noise.effective_intensity(1e-12), 2 * np.pi / 2e3 / 1000
        kick = march._kick(phi / units.phi, own) * units.phi
        assert kick == pytest.approx(noise.typical_kick(phi, D_eff, dt), rel=1e-14)


# --- machine code --------------------------------------------------------------------------------

MARCHES = {**{f"{gamma:.2f}": march for gamma, march in march.SPECIAL_MARCHES.items()},
           "general": general_march}  # fmt: skip
_ARITHMETIC = re.compile(r"\bv(?:mul|add|sub|fn?m(?:add|sub)\d+)(pd|sd)\b")
_DIVISION = re.compile(r"\bv(?:div|sqrt)[ps]d\b")
LOOPS = 4  # with noise and without, travelling and measuring


def hot_loops(assembly: str) -> list[str]:
    """Innermost loops with 12 vector operations or more."""
    lines, labels, loops = assembly.splitlines(), {}, []
    for i, line in enumerate(lines):
        if label := re.match(r"(\.LBB\w+):", line):
            labels[label[1]] = i
        elif jump := re.match(r"\s+j\w+\s+(\.LBB\w+)", line):
            begin = labels.get(jump[1], i)
            body = "\n".join(lines[begin + 1 : i])
            vectors = _ARITHMETIC.findall(body).count("pd")
            if not re.search(r"^\.LBB", body, re.MULTILINE) and vectors >= 12:
                loops.append(body)
    return loops


def assembly_of(march) -> str:
    """A march compiled anew, not run: the code of a cached one cannot be looked at."""
    points, steps = varied(1)
    march(lanes_of(points, steps).tasks, np.arange(1), True, True, 1)
    (signature,) = march.signatures
    fresh = jit(march.py_func)
    fresh.compile(signature)
    return fresh.inspect_asm(signature)


def test_a_loop_with_a_division_or_scalar_code_would_be_seen() -> None:
    lines = [".LBB0_1:", *["vmulpd %zmm1"] * 30, "vdivpd %zmm2", "vmulsd %xmm1", "callq sin"]
    (loop,) = hot_loops("\n".join([*lines, "\tjne .LBB0_1"]))
    assert _DIVISION.search(loop)
    assert "sd" in _ARITHMETIC.findall(loop)
    assert "call" in loop


@pytest.mark.slow
@pytest.mark.parametrize("name", MARCHES)
def test_the_hot_loops_are_vectors_without_calls_and_divisions(name: str) -> None:
    if not {"+avx2", "+avx512f"} & set((numba_config.CPU_FEATURES or host_features()).split(",")):
        pytest.skip("this machine has no AVX2: its vectors are too short to tell")
    loops = hot_loops(assembly_of(MARCHES[name]))
    assert len(loops) >= LOOPS
    for loop in loops:
        assert set(_ARITHMETIC.findall(loop)) == {"pd"}
        assert "call" not in loop
        assert "ymm" in loop or "zmm" in loop
        # The logarithm of a general power divides.
        assert len(_DIVISION.findall(loop)) <= (2 if name == "general" else 0)


def host_features() -> str:
    from llvmlite import binding

    return binding.get_host_cpu_features().flatten()
