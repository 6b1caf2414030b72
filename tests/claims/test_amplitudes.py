"""The paper's claims about Figs. 7 to 9, tested on computed data (see docs/equations.md)."""

from __future__ import annotations

import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from support.curves import falls, rises, spread
from support.points import FIG_7, FIG_8, FIG_9, GAMMAS, LOCKED, curve, orbits, row

from stickslip import Status

X_M = 0.8e-6
CONSTANT_FORCE = 0.002
"""Forces count as constant, or as equal, within 0.2 %."""

CONSTANT_STRESS = 0.005
"""The stress of gamma = -2/3 in Fig. 8 counts as constant within 0.5 %."""


# --- Fig. 7: amplitudes against temperature -------------------------------------------------------

LIQUID_STRESS = 1.0
"""Below this amplitude [Pa] a film counts as always liquid; a solid one has 1e4 to 1e7 Pa."""

fig_7 = partial(curve, FIG_7)


def peak(found: SimpleNamespace, quantity: str) -> np.ndarray:
    """Return the larger of the two extremes."""
    return np.maximum(getattr(found, f"{quantity}_max"), -getattr(found, f"{quantity}_min"))


def solid_part(found: SimpleNamespace) -> np.ndarray:
    return found.elastic_stress_amplitude > LIQUID_STRESS


@pytest.mark.slow
# The long tests add a fluid between those of the figure.
@pytest.mark.parametrize("gamma", [*LOCKED, pytest.param(1 / 3, marks=pytest.mark.stress)])
def test_fig_7_stress_falls_with_temperature(gamma: float) -> None:
    found = fig_7(gamma)
    assert np.all(found.status == Status.OK)
    assert falls(found.elastic_stress_amplitude[solid_part(found)])
    assert np.all(np.diff(solid_part(found).astype(int)) <= 0)  # once liquid, liquid


@pytest.mark.slow
def test_fig_7_stress_and_force_peaks_fall_with_temperature_for_the_pseudoplastic() -> None:
    found = fig_7(-2 / 3)
    solid = solid_part(found)
    assert np.all(found.status == Status.OK)
    assert np.all(np.diff(solid.astype(int)) <= 0)
    assert falls(peak(found, "elastic_stress")[solid])
    assert falls(peak(found, "friction_force")[solid])


@pytest.mark.slow
def test_fig_7_amplitudes_of_the_pseudoplastic_fall_wherever_its_orbit_is_symmetric() -> None:
    # At 228 and 229 K the start from rest ends on an asymmetric orbit of three meltings. The
    # second stick in one direction is missing. Maximum and minimum differ, and half of their
    # difference is a third lower than at neighbouring temperatures.
    found = fig_7(-2 / 3)
    symmetric = found.asymmetry < 1e-3
    assert found.x[~symmetric].tolist() == [228.0]
    assert found.melting_count[~symmetric].tolist() == [3]
    part = solid_part(found) & symmetric
    assert falls(found.elastic_stress_amplitude[part])
    assert falls(found.friction_force_amplitude[part])


@pytest.mark.slow
def test_fig_7_the_pseudoplastic_has_the_largest_stress_while_it_is_solid() -> None:
    largest = fig_7(-2 / 3)
    part = largest.x <= 283.0
    for gamma in LOCKED:
        other = fig_7(gamma).elastic_stress_amplitude
        assert np.all(largest.elastic_stress_amplitude[part] > other[part])


@pytest.mark.slow
def test_fig_7_the_pseudoplastic_melts_at_the_lowest_temperature() -> None:
    melting = {gamma: fig_7(gamma).x[~solid_part(fig_7(gamma))].min() for gamma in GAMMAS}
    assert 284.0 < melting[-2 / 3] <= 286.0
    assert melting[0.0] == melting[2 / 3] == 290.0  # from rest the film is liquid above T_c


@pytest.mark.slow
def test_fig_7_the_force_of_the_pseudoplastic_ends_on_a_plateau() -> None:
    found = fig_7(-2 / 3)
    plateau = found.friction_force_amplitude[~solid_part(found)]
    assert spread(plateau) < CONSTANT_FORCE
    # The force never falls below the plateau.
    assert np.all(found.friction_force_amplitude > plateau[0] * (1 - CONSTANT_FORCE))
    assert found.friction_force_amplitude[0] > 7 * plateau[0]


@pytest.mark.slow
def test_fig_7_the_force_is_constant_and_equal_for_the_others() -> None:
    newtonian, dilatant = (fig_7(gamma).friction_force_amplitude for gamma in LOCKED)
    assert spread(newtonian) < CONSTANT_FORCE
    assert spread(dilatant) < CONSTANT_FORCE
    assert np.all(np.abs(newtonian / dilatant - 1) < CONSTANT_FORCE)


# --- Fig. 8: amplitudes against the viscosity coefficient -----------------------------------------


fig_8 = partial(curve, FIG_8)


@pytest.mark.slow
def test_fig_8_stress_is_constant_for_the_pseudoplastic_and_falls_for_the_others() -> None:
    assert spread(fig_8(-2 / 3).elastic_stress_amplitude) < CONSTANT_STRESS
    for gamma in LOCKED:
        assert falls(fig_8(gamma).elastic_stress_amplitude)
        assert spread(fig_8(gamma).elastic_stress_amplitude) > 0.5


@pytest.mark.slow
def test_fig_8_force_grows_for_the_pseudoplastic_and_is_constant_for_the_others() -> None:
    assert rises(fig_8(-2 / 3).friction_force_amplitude)
    assert spread(fig_8(-2 / 3).friction_force_amplitude) > 0.2
    for gamma in LOCKED:
        assert np.all(fig_8(gamma).status == Status.OK)
        assert spread(fig_8(gamma).friction_force_amplitude) < CONSTANT_FORCE


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
@pytest.mark.parametrize("figure", [FIG_7, FIG_8], ids=["fig. 7", "fig. 8"])
def test_figs_7_and_8_the_force_is_smallest_for_the_pseudoplastic(
    figure: tuple[str, tuple[float, ...]], gamma: float
) -> None:
    smallest, other = curve(figure, -2 / 3), curve(figure, gamma)
    assert np.all(smallest.friction_force_amplitude < other.friction_force_amplitude)


# --- Fig. 9: amplitudes against the spring stiffness ----------------------------------------------


fig_9 = partial(curve, FIG_9)


def steepness(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return d ln y/d ln x between neighbours, which is 1 for proportional growth."""
    return np.diff(np.log(y)) / np.diff(np.log(x))


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
def test_fig_9_stress_grows_slowly_for_the_locked_blocks(gamma: float) -> None:
    # Slowly means hardly faster than K, and without the jump of the pseudoplastic.
    found = fig_9(gamma)
    assert rises(found.elastic_stress_amplitude)
    assert np.max(steepness(found.x, found.elastic_stress_amplitude)) < 1.2


@pytest.mark.slow
def test_fig_9_stress_jumps_up_and_then_stays_for_the_pseudoplastic() -> None:
    found = fig_9(-2 / 3)
    steep = steepness(found.x, found.elastic_stress_amplitude) > 2.0
    # Between two neighbouring jumps the orbits are asymmetric, with a single slip per period.
    assert found.x[1:][steep].tolist() == [1100.0, 1200.0]
    before, after = found.x <= 1000.0, found.x >= 1200.0
    assert rises(found.elastic_stress_amplitude[before])
    assert np.max(found.elastic_stress_amplitude[before]) < 0.6 * np.min(
        found.elastic_stress_amplitude[after]
    )
    assert spread(found.elastic_stress_amplitude[after]) < 0.01


@pytest.mark.slow
def test_fig_9_force_is_linear_in_the_stiffness_and_equal_for_the_locked_blocks() -> None:
    newtonian, dilatant = (fig_9(gamma) for gamma in LOCKED)
    for found in (newtonian, dilatant):
        line = (2 * found.x - 0.4 * 10.0**2) * X_M
        assert np.all(found.status == Status.OK)
        assert np.all(np.abs(found.friction_force_amplitude / line - 1) < CONSTANT_FORCE)
    ratio = newtonian.friction_force_amplitude / dilatant.friction_force_amplitude
    assert np.all(np.abs(ratio - 1) < CONSTANT_FORCE)


@pytest.mark.slow
def test_fig_9_force_grows_and_saturates_for_the_pseudoplastic() -> None:
    found = fig_9(-2 / 3)
    force = found.friction_force_amplitude
    assert np.all(found.status == Status.OK)
    assert rises(force[found.x <= 1000.0])
    saturated = force[found.x >= 1200.0]
    assert spread(saturated) < 0.01  # while K grows eightfold
    assert np.min(saturated) > 1.7 * np.max(force[found.x <= 1000.0])


@pytest.mark.slow
@pytest.mark.parametrize("gamma", LOCKED)
def test_fig_9_force_is_smallest_for_the_pseudoplastic_unless_it_slips_early(
    gamma: float,
) -> None:
    # A start from rest slips between K = 1100 and the knee near 1770 N/m, where a locked block
    # would still need less force.
    smallest, other = fig_9(-2 / 3), fig_9(gamma)
    excess = smallest.friction_force_amplitude / other.friction_force_amplitude - 1
    early = (smallest.x >= 1100.0) & (smallest.x < 1770.0)
    assert np.all(excess[early] > 0)
    # At K = 100 N/m locked blocks differ by 1e-6. At the default settings the offset, which decays
    # slowly there, is larger, but the stated errors cover it.
    resolved = smallest.x >= 200.0
    assert np.all(excess[~early & resolved] < 0)
    assert np.all(excess[~resolved] < (smallest.amplitude_error + other.amplitude_error)[~resolved])
    assert np.all(excess[smallest.x > 1770.0] < -0.01)


def test_fig_9_a_start_from_rest_slips_where_a_matched_start_is_locked() -> None:
    matched = {"initial_displacement": X_M, "initial_order_parameter": 0.6}
    rest = orbits(row(spring_stiffness=1500.0))
    locked = orbits(row(spring_stiffness=1500.0, **matched))
    assert (rest.melting_count, locked.melting_count) == (2, 0)
    assert math.isclose(locked.friction_force_amplitude[0], (2 * 1500 - 40) * X_M, rel_tol=1e-3)
