"""Extrema inside a step, at the vertex of the parabola through three nodes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

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
