"""Linked cases in no order: points, coloured by regime, without lines between them."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from support.pictures import described, failed, legend_of, note, panels, random_cases

from stickslip.status import Status
from sweeps.figures import PlotOptions, draw
from sweeps.measurements import read_data

VARIED = {"temperature": (150.0, 320.0), "spring_stiffness": (500.0, 1e4), "block_mass": (0.3, 0.5)}


def points(axes):
    (cloud,) = (drawn for drawn in axes.collections if isinstance(drawn, PathCollection))
    return np.asarray(cloud.get_offsets()).T


def test_each_amplitude_against_each_parameter_and_no_lines():
    ds = random_cases(**VARIED)
    figure = draw(ds)
    assert [axes.get_xlabel() for axes in panels(figure)] == [
        "$T$ (K)",
        "$K$ (N/m)",
        "$M$ (kg)",
    ] * 2
    assert not any(axes.get_lines() for axes in panels(figure))
    for axes, name in zip(panels(figure)[:3], VARIED, strict=True):
        np.testing.assert_allclose(points(axes), [ds[name], ds.elastic_stress_amplitude * 1e-6])
    assert legend_of(figure) == ["liquid", "locked", "stick-slip, symmetric"]


def test_six_parameters_have_lines_of_their_own_for_each_amplitude():
    more = {"angular_frequency": (5.0, 60.0), "film_thickness": (1e-9, 2e-9)}
    figure = draw(random_cases(**VARIED, **more, drive_amplitude=(1e-7, 1e-6)))
    assert len(panels(figure)) == 12
    assert panels(figure)[3].get_ylabel() == r"$\sigma_\mathrm{el,max}$ (MPa)"
    assert panels(figure)[6].get_ylabel() == r"$F_\mathrm{max}$ (mN)"


def test_a_chosen_parameter_is_the_only_one_across():
    figure = draw(random_cases(**VARIED), None, PlotOptions(x="K", variable="melting_count"))
    assert [axes.get_xlabel() for axes in panels(figure)] == ["$K$ (N/m)"]


def test_a_value_over_two_parameters_is_a_colour():
    ds = random_cases(**VARIED)
    options = PlotOptions(x="T", y="K", variable="elastic_stress_amplitude")
    figure = draw(ds, None, options)
    (axes,) = panels(figure)
    np.testing.assert_allclose(points(axes), [ds.temperature, ds.spring_stiffness])
    assert figure.axes[1].get_ylabel() == r"$\sigma_\mathrm{el,max}$ (MPa)"


def test_regimes_lie_over_two_parameters():
    ds = random_cases(**VARIED)
    figure = draw(ds, None, PlotOptions(variable="regime"))
    np.testing.assert_allclose(points(panels(figure)[0]), [ds.spring_stiffness, ds.temperature])
    assert legend_of(figure) == ["liquid", "locked", "stick-slip, symmetric"]


def test_kinds_of_each_variable_are_named():
    ds = random_cases(**VARIED)
    kinds = ["liquid", "locked", "stick-slip, symmetric"]
    assert legend_of(draw(ds, None, PlotOptions(variable=("regime", "F_max")))) == kinds
    assert legend_of(draw(ds, None, PlotOptions(variable=("regime", "status")))) == [*kinds, "ok"]


def test_a_kind_is_drawn_beside_a_logarithmic_scale():
    ds = random_cases(**VARIED)
    assert note(draw(ds, None, PlotOptions(variable=("regime", "F_max"), log="z"))) == ""
    ds["friction_force_amplitude"][:4] = 0.0
    figure = draw(ds, None, PlotOptions(variable=("regime", "F_max"), log="z"))
    assert note(figure) == r"$F_\mathrm{max}$ is not above 0 at 4 points: not drawn."


def test_kinds_lie_over_two_parameters_wherever_they_are_named():
    ds = random_cases(**VARIED)
    for variables in (("regime", "F_max"), ("F_max", "regime")):
        figure = draw(ds, None, PlotOptions(variable=variables))
        assert {axes.get_ylabel() for axes in panels(figure)} == {"$T$ (K)", ""}


def test_kinds_over_a_single_parameter_have_their_names():
    ds = random_cases(temperature=(150.0, 320.0))
    figure = draw(ds, None, PlotOptions(variable=("regime", "F_max"), log="z"))
    above, below = panels(figure)
    names = [text.get_text() for text in above.get_yticklabels()]
    assert names == ["liquid", "locked", "stick-slip,\nsymmetric"]
    assert (above.get_yscale(), below.get_yscale()) == ("linear", "log")
    with pytest.raises(ValueError, match="kinds and counts have no scale"):
        draw(ds, None, PlotOptions(variable="regime", log="z"))


def test_a_parameter_is_not_drawn_over_itself():
    with pytest.raises(ValueError, match="temperature is both x and y"):
        draw(random_cases(**VARIED), None, PlotOptions(variable="F_max", x="T", y="temperature"))


def test_a_single_parameter_is_not_the_vertical_axis():
    with pytest.raises(ValueError, match="no parameter is left for x: only temperature varies"):
        draw(random_cases(temperature=(150.0, 320.0)), None, PlotOptions(variable="F_max", y="T"))


def test_a_missing_case_is_counted():
    ds = random_cases(**VARIED)
    ds["status"][4] = 3
    assert note(draw(ds)) == "Not drawn: 1 of 60 points missing (1 diverged)"


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("lost", [0, slice(None)])
def test_a_first_case_without_a_result_is_left_out_without_a_warning(lost):
    ds = failed(random_cases(**VARIED), Status.DIVERGED, case=lost)
    figure = draw(ds, None, PlotOptions(variable="regime"))
    (cloud,) = panels(figure)[0].collections
    drawn = ~np.ma.getmaskarray(cloud.get_offsets()).any(axis=1)
    assert drawn.sum() == int((ds.status == 0).sum())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"x": "case"}, r"lie over their parameters \(temperature, spring_stiffness"),
        ({"x": "T", "y": "case"}, "not over case"),
        ({"log": "x", "x": "gamma"}, "needs numbers above 0; rheological_index has others"),
        ({"log": "z", "variable": "regime"}, "kinds and counts have no scale"),
        ({"data": read_data({"T": [200.0], "F_max": [3e-3]})}, "unordered cases give neither"),
    ],
)
def test_an_option_without_effect_on_points_is_refused(options, message):
    ds = random_cases(**VARIED, rheological_index=(-0.5, 0.5))
    with pytest.raises(ValueError, match=message):
        draw(ds, None, PlotOptions(**options))


def test_heights_without_a_logarithm_are_counted():
    ds = random_cases(**VARIED)
    ds["elastic_stress_amplitude"][:4] = 0.0
    figure = draw(ds, None, PlotOptions(variable="sigma_el,max", x="T", log="z"))
    assert "is not above 0 at 4 points: not drawn." in note(figure)
    own = ds.assign(mu=ds.friction_force_amplitude)
    (axes,) = panels(draw(own, None, PlotOptions(variable="mu", x="T", log="z")))
    assert axes.get_yscale() == "log"


def test_cases_in_no_order_have_no_curves():
    with pytest.raises(ValueError, match="unordered cases are points over x and y"):
        draw(random_cases(**VARIED), None, PlotOptions(hue="T"))


@pytest.mark.parametrize(("spaced", "scale"), [(np.geomspace, "log"), (np.linspace, "linear")])
def test_a_parameter_sampled_over_decades_has_a_logarithmic_axis(spaced, scale):
    ds = random_cases(temperature=(150.0, 320.0)).drop_vars("spring_stiffness")
    stiffness = np.random.default_rng(1).permutation(spaced(100.0, 1e4, 60))
    figure = draw(described(ds.assign_coords(spring_stiffness=("case", stiffness))))
    scales = {axes.get_xlabel(): axes.get_xscale() for axes in panels(figure)}
    assert scales == {"$T$ (K)": "linear", "$K$ (N/m)": scale}


def test_pairs_show_the_kinds_over_each_pair_of_parameters():
    ds = described(random_cases(**VARIED))
    figure = draw(ds, "pairs")
    assert len(panels(figure)) == 3
    assert [axes.get_xlabel() for axes in panels(figure)] == ["", "$T$ (K)", "$K$ (N/m)"]
    assert [axes.get_ylabel() for axes in panels(figure)] == ["$K$ (N/m)", "$M$ (kg)", ""]
    np.testing.assert_allclose(points(panels(figure)[1]), [ds.temperature, ds.block_mass])
    with pytest.raises(ValueError, match="of at least two parameters"):
        draw(described(random_cases(temperature=(150.0, 320.0))), "pairs")
