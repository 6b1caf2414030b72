"""The exact symmetries of the model hold bit for bit, from the start to the measurement.

Powers of two scale floating-point numbers without rounding, and no operation on the way, from the
scales of the step control to the acceleration, may contain an absolute size.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.marks import marked
from support.points import SUBHARMONIC, TWO_SOLIDS
from support.symmetries import SYMMETRIES, Symmetry, expected, transformed

from stickslip import Parameters, Status
from stickslip.kernels.trajectories import start_kernel, write_trajectory
from stickslip.measure.results import STATUS
from stickslip.options import DEFAULTS, METHODS, Options
from stickslip.orbit import compute_orbits

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
    "two solids": TWO_SOLIDS,
    "harmonics": {"temperature": 250.0, "third_harmonic": -0.4, "fifth_harmonic": 0.3},
    "subharmonic": SUBHARMONIC,
}


def assert_symmetric(p: Parameters, symmetry: Symmetry, options: Options) -> int:
    points = np.array([p, transformed(p, symmetry)])
    (row, other), (final, other_final) = compute_orbits(points, options)
    np.testing.assert_array_equal(other, expected(row, symmetry), strict=True)
    motion = symmetry.motion
    np.testing.assert_array_equal(other_final, final * [motion, motion, 1.0, 1.0], strict=True)
    return int(row[STATUS])


# These need kernels of their own; tests/kernels/test_every_parameter.py tests their terms too.
OF_STRESS = ["two solids", "harmonics"]
OF_THE_SUITE = [scene for scene in SCENES if scene not in OF_STRESS]


@pytest.mark.parametrize("scene", [*OF_THE_SUITE, *marked("stress", OF_STRESS)])
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


# Scenes with a long largest stable step, liquid above T_c0 or without elasticity.
COARSE: dict[str, tuple[dict[str, float], float]] = {
    "liquid": (
        {"temperature": 300.0, "rheological_index": 0.0, "viscosity_coefficient": 1e4},
        7e-7,
    ),
    "viscous": ({"elastic_coefficient": 0.0}, 2e-5),
    "general power": ({"elastic_coefficient": 0.0, "rheological_index": -0.5}, 2e-5),
    "harmonics": ({"elastic_coefficient": 0.0, "third_harmonic": -0.4}, 1e-5),
}


# Each further fluid costs the compilation of two kernels.
COARSE_SCENES = ["viscous", "general power", *marked("stress", ["liquid", "harmonics"])]


@pytest.mark.parametrize("scene", COARSE_SCENES)
@pytest.mark.parametrize("name", SYMMETRIES)
def test_orbits_by_euler_cromer(name: str, scene: str) -> None:
    changes, dt = COARSE[scene]
    options = Options(method="euler-cromer", dt=dt, stationary_rtol=1e-4, max_periods=30)
    assert_symmetric(Parameters(**changes), SYMMETRIES[name], options)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SYMMETRIES)
def test_trajectories(name: str, method: str) -> None:
    # With a short and fast drive few stable steps make a period of the solid film.
    symmetry = SYMMETRIES[name]
    p = Parameters(
        angular_frequency=2e3, drive_amplitude=8e-9, initial_order_parameter=0.6, temperature=250.0
    )
    options = Options(method=method, dt=5e-9)
    sampled = []
    for point in (p, transformed(p, symmetry)):
        start, samples = np.empty(3), np.empty((17, 3))
        start_kernel(DEFAULTS.physics)(np.array(point), start)
        status = write_trajectory(np.array(point), options, start, 8, samples)
        assert status == Status.OK
        sampled.append(samples)
    ours, other = sampled
    motion = symmetry.motion
    np.testing.assert_array_equal(other, ours * [motion, motion, 1.0], strict=True)
    assert np.ptp(ours[:, 2]) > 1e-4  # the order parameter changes


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
