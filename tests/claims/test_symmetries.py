"""The exact symmetries of the model, bit for bit: start, closure, search and measurement included.

Powers of two scale floating-point numbers without rounding, and no operation on the way, from
the yardsticks of the step control to the acceleration, may know an absolute size.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip import Parameters, Status, kernels
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS


class Symmetry(NamedTuple):
    """Factors of parameters, and what becomes of stress and force, and of x and v."""

    factors: dict[str, float]
    stress: float
    force: float
    motion: float


SYMMETRIES = {
    "mirror": Symmetry(
        {"drive_amplitude": -1.0, "initial_displacement": -1.0, "initial_velocity": -1.0},
        stress=-1.0,
        force=-1.0,
        motion=-1.0,
    ),
    "length": Symmetry(
        {
            "drive_amplitude": 2.0,
            "initial_displacement": 2.0,
            "initial_velocity": 2.0,
            "film_thickness": 2.0,
            "contact_area": 2.0,
        },
        stress=1.0,
        force=2.0,
        motion=2.0,
    ),
    "mass": Symmetry(
        {"block_mass": 2.0, "spring_stiffness": 2.0, "contact_area": 2.0},
        stress=1.0,
        force=2.0,
        motion=1.0,
    ),
    "stress": Symmetry(
        {
            "thermal_coefficient": 2.0,
            "elastic_coefficient": 2.0,
            "cubic_coefficient": 2.0,
            "quartic_coefficient": 2.0,
            "viscosity_coefficient": 2.0,
            "contact_area": 0.5,
            "kinetic_coefficient": 0.5,
        },
        stress=2.0,
        force=1.0,
        motion=1.0,
    ),
}

SCENES: dict[str, dict[str, float]] = {
    "fig3": {},
    "power": {"rheological_index": -0.5},
    "newtonian": {"rheological_index": 0.0},
    "dilatant": {"rheological_index": 2 / 3},
    "dilatant power": {"rheological_index": 0.5},
    "asymmetric": {"angular_frequency": 38.0},
    "symmetric": {"angular_frequency": 38.0, "initial_order_parameter": 0.6},
    "moving start": {"initial_displacement": 3e-7, "initial_velocity": -2e-6},
    "near melting": {"temperature": 285.0},
    "second order": {"cubic_coefficient": 0.0},
    "subharmonic": {
        "temperature": 172.92,
        "viscosity_coefficient": 22891.7,
        "spring_stiffness": 5491.4,
        "angular_frequency": 55.225,
    },
}


def transformed(p: Parameters, symmetry: Symmetry) -> Parameters:
    return p._replace(
        **{name: factor * getattr(p, name) for name, factor in symmetry.factors.items()}
    )


def expected(row: np.ndarray, symmetry: Symmetry) -> np.ndarray:
    """The result row of the transformed point."""
    named = dict(zip(RESULT_COLUMNS, row.tolist(), strict=True))
    for name, factor in (("elastic_stress", symmetry.stress), ("friction_force", symmetry.force)):
        high, low = factor * named[f"{name}_max"], factor * named[f"{name}_min"]
        named[f"{name}_max"], named[f"{name}_min"] = (high, low) if factor > 0 else (low, high)
        named[f"{name}_amplitude"] *= abs(factor)
    return np.array(list(named.values()))


def assert_symmetric(p: Parameters, symmetry: Symmetry, options: Options) -> int:
    points = np.array([p, transformed(p, symmetry)])
    (row, other), (final, other_final) = compute_orbits(points, options)
    np.testing.assert_array_equal(other, expected(row, symmetry), strict=True)
    motion = symmetry.motion
    np.testing.assert_array_equal(other_final, final * [motion, motion, 1.0, 1.0], strict=True)
    return int(row[-1])


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", SYMMETRIES)
def test_orbits(name: str, scene: str) -> None:
    status = assert_symmetric(Parameters(**SCENES[scene]), SYMMETRIES[name], Options())
    assert status == Status.OK


@pytest.mark.parametrize("scene", ["fig3", "newtonian", "asymmetric"])
@pytest.mark.parametrize("name", SYMMETRIES)
def test_orbits_by_plain_iteration_and_at_another_tolerance(name: str, scene: str) -> None:
    options = Options(rtol=1e-5, stationary_rtol=1e-4, accelerate=False)
    status = assert_symmetric(Parameters(**SCENES[scene]), SYMMETRIES[name], options)
    assert status == Status.OK


# Liquid above T_c0, and without elasticity: scenes whose largest stable step is long.
COARSE: dict[str, tuple[dict[str, float], float]] = {
    "liquid": (
        {"temperature": 300.0, "rheological_index": 0.0, "viscosity_coefficient": 1e4},
        7e-7,
    ),
    "viscous": ({"elastic_coefficient": 0.0}, 2e-5),
    "general power": ({"elastic_coefficient": 0.0, "rheological_index": -0.5}, 2e-5),
}


@pytest.mark.parametrize("scene", COARSE)
@pytest.mark.parametrize("name", SYMMETRIES)
def test_orbits_by_euler_cromer(name: str, scene: str) -> None:
    changes, dt = COARSE[scene]
    options = Options(method="euler-cromer", dt=dt, stationary_rtol=1e-4, max_periods=30)
    assert_symmetric(Parameters(**changes), SYMMETRIES[name], options)


@pytest.mark.parametrize("method", ["adaptive", "euler-cromer"])
@pytest.mark.parametrize("name", SYMMETRIES)
def test_trajectories(name: str, method: str) -> None:
    # A short and fast drive: few fixed steps of a stable size make a period of the solid film.
    symmetry = SYMMETRIES[name]
    p = Parameters(
        angular_frequency=2e3, drive_amplitude=8e-9, initial_order_parameter=0.6, temperature=250.0
    )
    fixed = method == "euler-cromer"
    door = kernels.fixed_trajectory if fixed else kernels.adaptive_trajectory
    options = Options(method="euler-cromer" if fixed else "adaptive", dt=5e-9).settings()
    sampled = []
    for point in (p, transformed(p, symmetry)):
        start, samples = np.empty(3), np.empty((17, 3))
        kernels.starting_log_state(np.array(point), start)
        assert door(np.array(point), options, start, 8, samples) == Status.OK
        sampled.append(samples)
    ours, other = sampled
    motion = symmetry.motion
    np.testing.assert_array_equal(other, ours * [motion, motion, 1.0], strict=True)
    assert np.ptp(ours[:, 2]) > 1e-4  # the film takes part


@settings(max_examples=20)
@given(
    name=st.sampled_from(sorted(SYMMETRIES)),
    temperature=st.floats(150.0, 310.0),
    viscosity_coefficient=st.floats(1e4, 2e5),
    spring_stiffness=st.floats(1000.0, 1e4),
    rheological_index=st.floats(-0.9, 0.5),
    angular_frequency=st.floats(5.0, 60.0),
    initial_displacement=st.floats(-1e-6, 1e-6),
    initial_order_parameter=st.floats(0.0, 1.0),
)
def test_orbits_of_any_parameters(name: str, **changes: float) -> None:
    options = Options(rtol=1e-5, stationary_rtol=1e-4, max_steps=300_000)
    assert_symmetric(Parameters(**changes), SYMMETRIES[name], options)
