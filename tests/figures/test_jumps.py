"""Jumps are not slopes: where the line of a curve breaks, and where it does not."""

from __future__ import annotations

import numpy as np
import pytest
from support.pictures import TEMPERATURES, curves, described, jumps, panels, sweep

from sweeps.figures import PlotOptions, draw

STEP = 20  # the first point of another regime
BETWEEN = (TEMPERATURES[STEP - 1] + TEMPERATURES[STEP]) / 2


def curve(stress, other=None):
    """Return the upper panel of a sweep with stresses (35,); `other` marks points of regime 3."""
    regime = np.zeros(35, dtype="i1")
    regime[STEP:] = 2
    if other is not None:
        regime = np.where(other, 3, 2).astype("i1")
    ds = sweep(temperature=TEMPERATURES)
    ds = ds.assign(regime=("temperature", regime))
    ds["elastic_stress_amplitude"] = ("temperature", np.asarray(stress, dtype=float))
    return panels(draw(described(ds)))[0]


def test_a_jump_is_a_gap_with_a_dotted_line():
    stress = np.linspace(4e6, 3e6, 35) - 1e6 * (np.arange(35) >= STEP)
    axes = curve(stress)
    assert jumps(axes) == [BETWEEN]
    (line,) = curves(axes)
    assert np.flatnonzero(np.isnan(line.get_ydata())).tolist() == [STEP]
    np.testing.assert_array_equal(np.delete(line.get_xdata(), STEP), TEMPERATURES)
    np.testing.assert_allclose(np.delete(line.get_ydata(), STEP), stress * 1e-6)


@pytest.mark.parametrize(
    "stress",
    [
        np.linspace(4e6, 1e6, 35),  # smooth across the border
        np.where(np.arange(35) < STEP, 4e6 - 1e5 * np.arange(35), 4e6 - 1e5 * STEP),  # a bend
        4e6 * np.exp(-((np.arange(35) / 8.0) ** 2)),
        1e6 * np.sqrt(np.maximum(np.arange(35) - STEP + 1.0, 0.0)),
    ],
)
def test_a_smooth_curve_has_no_gap(stress):
    axes = curve(stress)
    assert jumps(axes) == []
    assert np.isfinite(curves(axes)[0].get_ydata()).all()


def test_a_steep_curve_within_one_regime_has_no_gap():
    stress = np.linspace(4e6, 3e6, 35) - 1e6 * (np.arange(35) >= 10)
    assert jumps(curve(stress)) == []


def test_a_notch_of_a_single_point_is_two_jumps():
    notch = np.arange(35) == 12
    axes = curve(np.linspace(4e6, 3e6, 35) - 1e6 * notch, notch)
    assert len(jumps(axes)) == 2
    assert curves(axes)[0].get_markevery() == [13]


def test_a_count_jumps_wherever_it_changes():
    ds = sweep(temperature=TEMPERATURES)
    counts = np.where(np.arange(35) < 17, 0, 4)
    ds = ds.assign(solid_transition_count=("temperature", counts.astype("i4")))
    options = PlotOptions(variable=("friction_force_amplitude", "solid_transition_count"))
    force, transitions = panels(draw(described(ds), None, options))
    assert not jumps(force)
    assert jumps(transitions) == [pytest.approx(TEMPERATURES[16:18].mean())]


def test_a_jump_on_a_logarithmic_axis_is_in_its_middle():
    stiffness = np.geomspace(100.0, 1e4, 21)
    ds = sweep(spring_stiffness=stiffness)
    ds = ds.assign(melting_count=("spring_stiffness", np.repeat([0, 2], [10, 11]).astype("i4")))
    ds["elastic_stress_amplitude"][10:] += 3e6
    (place,) = jumps(panels(draw(described(ds)))[0])
    assert place == pytest.approx(np.sqrt(stiffness[9] * stiffness[10]))
