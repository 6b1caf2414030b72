"""Extrema inside a step, at the vertex of a parabola through three nodes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.points import amplitude_errors, orbits

from stickslip import Parameters, Status
from stickslip.kernels.adaptive.recording import NODES, WEIGHTS, vertex


@given(
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3, unique=True),
    st.floats(-2.0, 2.0),
    st.floats(0.1, 10.0),
)
def test_a_parabola_has_its_vertex_for_any_nodes(
    nodes: list[float], at: float, bend: float
) -> None:
    nodes = sorted(nodes)
    assume(np.min(np.diff(nodes)) > 1e-3)
    values = (bend * (x - at) ** 2 for x in nodes)
    assert vertex(*nodes, *values) == pytest.approx(at, abs=1e-7)


@pytest.mark.parametrize("values", [(1.0, 1.0, 1.0), (0.0, 1.0, 2.0)])
def test_a_straight_line_has_no_vertex(values: tuple[float, float, float]) -> None:
    # The result is NaN or infinite, which lies between no two nodes and is therefore ignored.
    assert not -1e300 < vertex(0.0, 1.0, 2.0, *values) < 1e300


@pytest.mark.parametrize("degree", range(7))
def test_the_quadrature_of_a_step_is_of_order_6(degree: int) -> None:
    found = sum(w * x**degree for w, x in zip(WEIGHTS, NODES, strict=True))
    exact = 1.0 / (degree + 1)
    assert math.isclose(found, exact, rel_tol=1e-14) == (degree < 6)


def test_the_stated_error_of_a_light_block_covers_a_turn_at_the_end_of_a_half_period() -> None:
    # The rate of the force is a small difference here, and lost in the error of the velocity.
    rng, points = np.random.default_rng(1), []
    for _ in range(40):
        changes = {
            "temperature": rng.uniform(150.0, 330.0),
            "viscosity_coefficient": 10.0 ** rng.uniform(4.0, 5.5),
            "spring_stiffness": rng.uniform(500.0, 1e4),
            "rheological_index": rng.uniform(-0.7, 1.0),
            "angular_frequency": rng.uniform(5.0, 60.0),
            "block_mass": 10.0 ** rng.uniform(-8.0, -4.0),
        }
        points.append(Parameters(**changes))
    light = np.array(points)
    loose, tight = (orbits(light, rtol=rtol, stationary_rtol=rtol) for rtol in (1e-4, 1e-7))
    both = (loose.status == Status.OK) & (tight.status == Status.OK)
    assert both.sum() >= 30
    true = amplitude_errors(
        loose, light, tight.elastic_stress_amplitude, tight.friction_force_amplitude
    )
    assert np.all(true[both] <= 3.0 * loose.amplitude_error[both])
