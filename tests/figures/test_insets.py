"""Insets of phase portraits, and the picture of the phases."""

from __future__ import annotations

import numpy as np
import pytest
from support.pictures import curves, panels, portraits

from stickslip import Parameters, phase_diagram, simulate
from sweeps.figures import draw


def with_loop(size: float) -> object:
    """Return portraits of a circle with three loops at its right, `size` times as large."""
    ds = portraits().isel(angular_frequency=[0])
    turn = np.linspace(0.0, 2 * np.pi, 300)
    small = 0.5e-6 * (1.0 - size) + 0.5e-6 * size * np.cos(9 * turn[:100])
    x = np.concatenate([0.5e-6 * np.cos(turn), small])
    v = np.concatenate([5e-6 * np.sin(turn), 5e-6 * size * np.sin(9 * turn[:100])])
    for name, values in (("lower_displacement", x), ("lower_velocity", v)):
        ds[name].values[0] = values
    return ds


@pytest.mark.parametrize(("size", "insets"), [(0.01, 1), (0.2, 0)])
def test_loops_too_small_to_be_seen_are_enlarged(size: float, insets: int) -> None:
    (axes,) = panels(draw(with_loop(size), "phase_portraits"))
    assert len(axes.child_axes) == insets
    for inset in axes.child_axes:
        assert inset.get_xlim()[0] < 0.5e-6 * 1e6 * (1 - 2 * size)
        assert np.ptp(inset.get_xlim()) < 0.1


def test_an_inset_covers_no_curve() -> None:
    (axes,) = panels(draw(with_loop(0.01), "phase_portraits"))
    (inset,) = axes.child_axes
    axes.figure.draw_without_rendering()
    corners = inset.get_window_extent()
    (line,) = curves(axes)[:1]
    shown = axes.transData.transform(line.get_xydata())
    assert not any(corners.contains(*point) for point in shown)


def test_fig_5_enlarges_a_section_at_15_alone() -> None:
    for omega, insets in ((10.0, 0), (15.0, 1), (32.0, 0), (38.0, 0)):
        ds = simulate(Parameters(angular_frequency=omega), periods=2, start="stationary")
        (axes,) = panels(draw(ds, "phase_portraits"))
        assert len(axes.child_axes) == insets, omega


def test_fig_2_shows_three_energies_and_enlarges_the_barrier() -> None:
    above, below = panels(draw(phase_diagram()))
    assert [line.get_label() for line in curves(above)] == [
        "$T = 265$ K",
        "$T = 286$ K",
        "$T = 310$ K",
    ]
    (inset,) = above.child_axes
    (barrier,) = curves(inset)
    assert barrier.get_label() == "$T = 286$ K"
    assert {"solid", "both", "liquid"} <= {text.get_text() for text in below.texts}


def test_nothing_is_enlarged_if_no_film_has_a_barrier() -> None:
    above, _ = panels(draw(phase_diagram(temperatures=[200.0, 250.0])))
    assert above.child_axes == []


def test_all_states_lie_within_the_panel_of_the_phases():
    for temperatures, strain in (([0.0, 250.0], 2.1e-6), ([200.0, 400.0], 2e-5)):
        _, below = panels(draw(phase_diagram(temperatures=temperatures, strain=strain)))
        (left, right), top = below.get_xlim(), below.get_ylim()[1]
        assert left < temperatures[0]
        assert temperatures[-1] < right
        assert strain < top


@pytest.mark.parametrize(
    ("parameters", "temperatures", "said"),
    [
        ({}, [300.0, 310.0], "above 298.189 K a film is liquid at any strain"),
        (
            {"elastic_coefficient": 0.0},
            [250.0, 310.0],
            "no strain melts a film with elastic_coefficient = 0",
        ),
    ],
)
def test_a_landscape_that_no_strain_changes_is_refused(
    parameters: dict[str, float], temperatures: list[float], said: str
) -> None:
    ds = phase_diagram(Parameters(**parameters), temperatures=temperatures)
    with pytest.raises(ValueError, match=said):
        draw(ds, "landscape")
    assert len(panels(draw(ds, "free_energy"))) == 2


def test_many_temperatures_have_a_colour_each():
    figure = draw(phase_diagram(temperatures=np.linspace(150.0, 320.0, 12)))
    colours = {line.get_color() for line in panels(figure)[0].get_legend().get_lines()}
    assert len(colours) == 12
