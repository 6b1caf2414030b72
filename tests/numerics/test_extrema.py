"""Extrema inside a step: found on the interpolant, not at the ends of the step alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stickslip.numerics.extrema import BOOLE_WEIGHTS, COUNT, NODES, make_extremum, vertex

from stickslip.compiled.decorators import inline


@inline
def cubic(p, step, theta):
    return p[0] + step * theta * (p[1] + theta * (p[2] + theta * p[3]))


extremum = make_extremum(cubic)
NOTHING = -np.inf


def highest(p, sign: float = 1.0, record: float = NOTHING, step: float = 1.0) -> float:
    """The record after a step with the cubic `p`."""
    values = np.array([cubic(p, step, node) for node in NODES])
    return extremum(p, step, sign, values, record)


def parabola(at: float, top: float = 2.0, bend: float = 1.0):
    """Coefficients of top - bend (theta - at)^2."""
    return top - bend * at**2, 2.0 * bend * at, -bend, 0.0


@pytest.mark.parametrize("at", [0.01, 0.02, 0.13, 0.25, 0.37, 0.5, 0.624, 0.9, 0.98, 0.99])
def test_a_maximum_inside_the_step_is_exact(at: float) -> None:
    assert highest(parabola(at)) == pytest.approx(2.0, rel=1e-14)


@pytest.mark.parametrize("at", [0.01, 0.37, 0.9])
def test_a_minimum_is_the_maximum_of_the_negative(at: float) -> None:
    valley = tuple(-coefficient for coefficient in parabola(at))
    assert highest(valley, sign=-1.0) == pytest.approx(2.0, rel=1e-14)


def test_the_maximum_of_a_cubic_is_exact() -> None:
    # theta (1 - theta)^2 has its maximum 4/27 at 1/3.
    assert highest((0.0, 1.0, -2.0, 1.0)) == pytest.approx(4 / 27, rel=1e-14)


@pytest.mark.parametrize("at", [0.001, 0.004, 0.007, 0.993, 0.999])
def test_a_maximum_next_to_an_end_is_missed_by_no_more_than_the_node_there_allows(
    at: float,
) -> None:
    assert 2.0 - (1 / 128) ** 2 <= highest(parabola(at)) <= 2.0 * (1 + 1e-15)


@pytest.mark.parametrize("slope", [1.0, -1.0])
def test_the_maximum_of_a_monotone_step_is_at_its_end(slope: float) -> None:
    assert highest((5.0, slope, 0.0, 0.1 * slope)) == max(5.0, 5.0 + 1.1 * slope)


def test_the_interpolant_sees_the_step() -> None:
    assert highest(parabola(0.37, bend=4.0), step=0.5) == pytest.approx(
        max(cubic(parabola(0.37, bend=4.0), 0.5, x) for x in np.linspace(0, 1, 10001)), rel=1e-7
    )


def test_a_record_that_the_step_does_not_reach_stays() -> None:
    assert highest(parabola(0.37), record=2.0001) == 2.0001


def test_a_record_just_below_the_maximum_is_beaten() -> None:
    node_value = cubic(parabola(0.37), 1.0, 0.25)
    assert highest(parabola(0.37), record=node_value + 0.01) == pytest.approx(2.0, rel=1e-14)
    assert highest(parabola(0.37), record=2.0 - 1e-9) == pytest.approx(2.0, rel=1e-14)


def test_a_constant_step_gives_its_value() -> None:
    assert highest((3.0, 0.0, 0.0, 0.0)) == 3.0


coefficients = st.floats(-10.0, 10.0)


@given(p=st.tuples(coefficients, coefficients, coefficients, coefficients))
def test_a_cubic_is_found_to_the_distance_of_its_nodes_and_never_exceeded(
    p: tuple[float, float, float, float],
) -> None:
    thetas = np.linspace(0.0, 1.0, 2001)
    true = float(np.max(cubic.py_func(p, 1.0, thetas)))
    bend = 2 * abs(p[2]) + 6 * abs(p[3])  # bounds the second derivative
    found = highest(p)
    # A hump between two nodes that is lower than both ends of the step is not looked for.
    assert found >= true - bend / 2 * (1 / 8) ** 2 - 1e-12
    assert found <= true + bend / 8 * (1 / 2000) ** 2 + 1e-12


def test_the_nodes_rise_from_end_to_end() -> None:
    assert (NODES[0], NODES[-1], len(NODES)) == (0.0, 1.0, COUNT)
    assert np.all(np.diff(NODES) > 0)


@pytest.mark.parametrize("power", range(6))
def test_the_quadrature_on_the_nodes_is_exact_to_fifth_degree(power: int) -> None:
    integral = np.dot(BOOLE_WEIGHTS, np.array(NODES) ** power)
    assert integral == pytest.approx(1 / (power + 1), rel=1e-14)


def test_the_quadrature_is_not_exact_beyond() -> None:
    assert np.dot(BOOLE_WEIGHTS, np.array(NODES) ** 6) != pytest.approx(1 / 7, rel=1e-6)


@given(
    places=st.tuples(st.floats(-1.0, 0.0), st.floats(0.1, 1.0), st.floats(0.1, 1.0)),
    at=st.floats(-3.0, 3.0),
    bend=st.floats(0.1, 10.0),
)
def test_the_vertex_of_a_parabola_is_exact(
    places: tuple[float, float, float], at: float, bend: float
) -> None:
    x0, x1, x2 = places[0], places[0] + places[1], places[0] + places[1] + places[2]
    values = [bend * (x - at) ** 2 + 0.7 for x in (x0, x1, x2)]
    assert vertex(x0, x1, x2, *values) == pytest.approx(at, abs=1e-11)
    assert vertex(x0, x1, x2, *(-value for value in values)) == pytest.approx(at, abs=1e-11)


def test_a_straight_line_has_no_finite_vertex() -> None:
    for slope in (1.0, 0.0, -2.0):
        assert not np.isfinite(vertex(0.0, 0.5, 1.0, 0.0, 0.5 * slope, slope))


@pytest.mark.parametrize("where", range(3))
def test_a_vertex_of_nan_is_nan(where: int) -> None:
    values = [0.0, 1.0, 0.5]
    values[where] = np.nan
    assert np.isnan(vertex(0.0, 0.5, 1.0, *values))
