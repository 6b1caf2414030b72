"""How a picture looks: size, limits, letters, title, small print, the user's axes and points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from support.pictures import (
    GAMMAS,
    TEMPERATURES,
    curves,
    described,
    legend_of,
    note,
    panels,
    sweep,
)
from support.pictures import (
    drawn as posterior,
)

import sweeps.accessor  # noqa: F401 - registers `stickslip`
from sweeps import run
from sweeps.figures import Look, PlotOptions, draw, save
from sweeps.figures.look import range_of, size_of
from sweeps.measurements import read_data

FORCE = "friction_force_amplitude"


@pytest.fixture
def ds():
    return sweep(temperature=TEMPERATURES, spring_stiffness=[1000.0, 2000.0, 3000.0])


def drawn(ds, *variables, look=None, **options):
    return draw(ds, None, PlotOptions(variables or None, look=look or Look(), **options))


@pytest.mark.parametrize("size", [(3.37, 2.5), (7.0, 3.0)])
def test_the_size_is_the_size_of_the_whole_picture(ds, size):
    assert tuple(drawn(ds, look=Look(size=size)).get_size_inches()) == size


def test_a_legend_leaves_a_small_picture_most_of_its_height():
    many = sweep(temperature=TEMPERATURES, spring_stiffness=np.linspace(1000.0, 8000.0, 8))
    figure = drawn(many, FORCE, hue="K", look=Look(size=(3.37, 2.5)))
    figure.draw_without_rendering()
    (axes,) = panels(figure)
    assert axes.get_position().height > 0.6
    assert legend_of(figure) == ["$K$ (N/m):", *(f"${1000 * k}$" for k in range(1, 9))]
    usual = drawn(many, FORCE, hue="K")
    assert legend_of(usual)[0] == "$K = 1000$ N/m"


def test_a_style_file_may_give_the_size(ds, tmp_path):
    style = tmp_path / "a.mplstyle"
    style.write_text("figure.figsize: 3.37, 4.2\n")
    assert tuple(drawn(ds, look=Look(style=style)).get_size_inches()) == (3.37, 4.2)
    both = Look(style=style, size=(2.0, 2.0))
    assert tuple(drawn(ds, look=both).get_size_inches()) == (2.0, 2.0)


def test_limits_letters_title_and_no_note(ds):
    look = Look(xlim=(180.0, None), ylim=(0.0, 3.0), letters=True, note=False)
    figure = drawn(ds, look=look)
    for axes, letter in zip(panels(figure), "ab", strict=True):
        assert axes.get_xlim()[0] == 180.0
        assert axes.get_ylim() == (0.0, 3.0)
        assert f"({letter})" in [text.get_text() for text in axes.texts]
    assert note(figure) == ""


@pytest.mark.parametrize("size", [None, (3.37, 3.0)])
@pytest.mark.parametrize("hue", ["K", None])
def test_a_title_lies_above_the_legend_and_is_never_cut(ds, hue, size):
    title = "My oil, with a title that is too long for a single line of a column of a journal"
    at = () if hue else ("K=1000",)
    figure = drawn(ds, x="T", hue=hue, at=at, look=Look(size=size, title=title))
    figure.draw_without_rendering()
    (written,) = (t for t in figure.findobj(Text) if t.get_text().replace("\n", " ") == title)
    box = written.get_window_extent()
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    legend = [text for each in figure.legends for text in each.get_texts()]
    assert len(legend) == (3 if hue else 0)
    below = [item.get_window_extent().y1 for item in [*legend, *panels(figure)]]
    assert box.y0 >= max(below)


def test_kinds_of_two_variables_have_one_legend(ds):
    regimes = (np.arange(ds.status.size) % 3).reshape(ds.status.shape).astype("i1")
    ds = described(ds.assign(regime=(ds.status.dims, regimes)))
    figure = drawn(ds, "regime", "status", y="K")
    assert len(figure.legends) == 1
    assert legend_of(figure) == ["liquid", "locked", "stick-slip, symmetric", "ok"]


def test_limits_of_colours_are_those_of_the_bar(ds):
    figure = drawn(ds, FORCE, y="K", look=Look(clim=(1.0, 2.0)))
    (axes, bar) = figure.axes
    assert axes.collections[0].get_clim() == (1.0, 2.0)
    assert bar.get_ylim() == (1.0, 2.0)


def test_colours_begin_where_the_data_do(ds):
    ds[FORCE] = ds[FORCE] * 0.0 + np.linspace(1.1e-3, 2e-3, ds[FORCE].size).reshape(ds[FORCE].shape)
    (axes, _) = drawn(ds, FORCE, y="K").axes
    assert axes.collections[0].get_clim() == pytest.approx((1.1, 2.0))


@pytest.mark.parametrize(
    ("look", "said"),
    [
        ({"size": (0.0, 3.0)}, "a size is a width and a height of 0 to 100 inches"),
        ({"xlim": (math.nan, None)}, "each end of xlim must be a finite number"),
        ({"ylim": (0.0, math.inf)}, "each end of ylim must be a finite number"),
        ({"ylim": (2.0, 1.0)}, "ylim must rise, not go from 2.0 to 1.0"),
        ({"size": (3.0,)}, "size must be two numbers"),
        ({"xlim": (1, 2, 3)}, "xlim must be two numbers"),
        ({"clim": 3.0}, "clim must be two numbers"),
        *(
            ({"letters": wrong}, "letters must start at one of a to z")
            for wrong in ("", "B", "bc", "1")
        ),
    ],
)
def test_an_impossible_look_is_refused(look, said):
    with pytest.raises(ValueError, match=said):
        Look(**look)


@pytest.mark.parametrize(
    ("options", "limits"),
    [
        ({"log": "x"}, {"xlim": (0.0, 300.0)}),
        ({"log": "x"}, {"xlim": (None, -3.0)}),
        ({"log": "z"}, {"ylim": (-2.0, 3.0)}),
        ({"log": "z", "x": "T", "y": "K"}, {"clim": (0.0, 3.0)}),
        ({"log": "y", "x": "T", "y": "K"}, {"ylim": (0.0, None)}),
    ],
)
def test_limits_that_a_logarithmic_scale_lacks_are_refused(ds, options, limits):
    """Matplotlib would change the limits, and warn."""
    ((name, _),) = limits.items()
    with pytest.raises(ValueError, match=f"{name} on a logarithmic scale must be greater than 0"):
        drawn(ds, FORCE, look=Look(**limits), **options)


@pytest.mark.parametrize("size", [(0.1, 0.1), (0.5, 0.5)])
def test_a_picture_without_room_for_its_panels_is_not_written(ds, tmp_path, size):
    look = Look(size=size)
    with pytest.raises(ValueError, match=f"{size[0]} x {size[1]} inches leave no room"):
        save(drawn(ds, look=look), tmp_path / "a.png", look)
    assert not list(tmp_path.iterdir())


def test_control_characters_of_a_title_are_spaces(ds, tmp_path):
    """No font has them: each would cause a warning, and a box in the picture."""
    look = Look(title="a\tb\x07\x1bc\nd")
    figure = drawn(ds, look=look)
    texts = [text.get_text().split() for text in figure.findobj(Text)]
    assert ["a", "b", "c", "d"] in texts
    save(figure, tmp_path / "a.png", look)


def test_texts_of_sizes_and_limits():
    assert size_of("3.37x2.5") == (3.37, 2.5)
    assert [range_of(text) for text in ("0:3", ":3", "1e-3:")] == [(0, 3), (None, 3), (1e-3, None)]
    for wrong in ("3", "3x", "axb"):
        with pytest.raises(ValueError, match=r"as in 3\.37x2\.5"):
            size_of(wrong)
    for wrong in ("3", "1:2:3", "a:b"):
        with pytest.raises(ValueError, match="as in 0:3"):
            range_of(wrong)


def test_a_name_keeps_its_subscripts():
    ds = sweep(temperature=TEMPERATURES)
    named = {"long_name": r"shear_stress $\tau_s$", "units": "1"}
    ds = ds.assign(tau=ds.elastic_stress_amplitude.drop_attrs().assign_attrs(named))
    (axes,) = panels(drawn(ds, "tau"))
    assert axes.get_ylabel() == r"shear stress $\tau_s$"


@pytest.mark.parametrize(
    ("options", "look"),
    [
        ({"x": "T"}, {"ylim": (100.0, None)}),
        ({"x": "T"}, {"xlim": (None, 10.0)}),
        ({"x": "T", "y": "K"}, {"clim": (100.0, None)}),
    ],
)
def test_a_limit_beyond_the_other_end_is_refused(ds, options, look):
    with pytest.raises(
        ValueError,
        match=r"xlim ends at 10, before|(ylim|clim) begins at 100, beyond the other end at",
    ):
        drawn(ds, FORCE, **options, look=Look(**look))


def test_short_logarithmic_colours_have_plain_numbers(ds):
    ds[FORCE] = ds[FORCE] * 0.0 + np.geomspace(6e-4, 5e-3, ds[FORCE].size).reshape(ds[FORCE].shape)
    figure = drawn(ds, FORCE, y="K", log="z")
    figure.draw_without_rendering()
    texts = [label.get_text() for label in figure.axes[1].get_yticklabels(which="both")]
    assert "2" in texts
    assert not any("times" in text for text in texts)


def test_a_band_lies_around_means_and_within_the_panel():
    ds = sweep(temperature=TEMPERATURES)
    periods = np.where(np.arange(35) < 20, 0, 3)  # an orbit of three periods has no mean
    ds = ds.assign(
        orbit_periods=("temperature", periods.astype("i4")),
        elastic_stress_amplitude_spread=("temperature", np.full(35, 1e6)),
    )
    axes = panels(draw(described(ds)))[0]
    (band,) = axes.collections
    x, y = band.get_paths()[0].vertices.T
    assert x[y > 5.0 - 1e-9].min() == TEMPERATURES[0]
    assert np.ptp(y[x == TEMPERATURES[19]]) == pytest.approx(2.0)
    assert np.ptp(y[x == TEMPERATURES[20]]) == pytest.approx(0.0)
    assert axes.get_ylim()[1] > 5.0


def test_a_band_ends_at_a_jump_and_a_mean_between_two_jumps_has_a_bar():
    ds = sweep(temperature=TEMPERATURES)
    periods, stress = np.ones(35, dtype="i4"), np.full(35, 4e6)
    for means in (slice(5, 6), slice(15, 20)):  # a single mean, and a band of five
        periods[means], stress[means] = 0, 2e6
    ds = ds.assign(
        orbit_periods=("temperature", periods),
        elastic_stress_amplitude=("temperature", stress),
        elastic_stress_amplitude_spread=("temperature", np.full(35, 2e5)),
    )
    axes = panels(draw(described(ds)))[0]
    band, bar = axes.collections
    x = np.concatenate([path.vertices[:, 0] for path in band.get_paths()])
    y = np.concatenate([path.vertices[:, 1] for path in band.get_paths()])
    wide = x[(np.abs(y - 4.0) > 1e-9) & (x != TEMPERATURES[5])]
    assert (wide.min(), wide.max()) == (TEMPERATURES[15], TEMPERATURES[19])
    (ends,) = bar.get_segments()
    np.testing.assert_allclose(ends, [[TEMPERATURES[5], 1.8], [TEMPERATURES[5], 2.2]])


def test_axes_of_the_user_are_drawn_into(ds):
    figure = Figure(figsize=(3.37, 4.2))
    above, below = figure.subplots(2)
    for axes, name in ((above, "elastic_stress_amplitude"), (below, FORCE)):
        drawn(ds, name, x="T", look=Look(axes=axes))
        assert len(curves(axes)) == 3
        assert axes.get_legend() is not None
    assert below.get_ylabel() == r"$F_\mathrm{max}$ (mN)"
    assert below.get_xlabel() == "$T$ (K)"
    assert figure.get_supxlabel() == ""
    assert tuple(figure.get_size_inches()) == (3.37, 4.2)
    with pytest.raises(ValueError, match="ax takes a picture with one panel, but this one has 2"):
        drawn(ds, look=Look(axes=above))


def test_ordered_curves_are_alike_and_fluids_are_not(ds):
    (axes,) = panels(drawn(ds, FORCE, x="T", hue="K"))
    assert len({line.get_linewidth() for line in curves(axes)}) == 1
    assert len({line.get_color() for line in curves(axes)}) == 3
    (axes,) = panels(drawn(sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)), FORCE))
    assert len({line.get_linewidth() for line in curves(axes)}) == len(GAMMAS)


def test_measured_points_lie_over_the_curve_of_their_parameters(ds):
    table = {
        "T": [200.0, 250.0, 200.0],
        "K": [1000.0, 3000.0, 1500.0],
        "F_max": [1e-3, 2e-3, 3e-3],
        "F_max_error": [1e-4, 1e-4, 1e-4],
    }
    figure = drawn(ds, FORCE, x="T", hue="K", data=read_data(table))
    (axes,) = panels(figure)
    points = {
        (float(x), float(y)): each.lines[0].get_markerfacecolor()
        for each in axes.containers
        for x, y in zip(*each.lines[0].get_data(), strict=True)
    }
    assert {place: points[place] for place in points} == {
        (200.0, 1.0): curves(axes)[0].get_color(),
        (250.0, 2.0): curves(axes)[2].get_color(),
    }
    assert "Not drawn: 1 measured value at other parameters." in note(figure)
    (axes,) = Figure().subplots(1, 1, squeeze=False).flat
    said = "Not drawn: 1 measured value at other parameters."
    with pytest.warns(UserWarning, match=said) as warned:  # there is no small print
        ds.stickslip.plot(FORCE, x="T", hue="K", data=table, ax=axes)
    assert warned[0].filename == __file__
    with pytest.raises(ValueError, match="measured points are drawn over curves"):
        drawn(ds, FORCE, x="T", y="K", data=read_data(table))
    with pytest.raises(ValueError, match="the data have no column temperature"):
        drawn(ds, FORCE, x="T", hue="K", data=read_data({"K": [1000.0], "F_max": [1e-3]}))


def test_measured_points_lie_over_the_parameter_that_linked_cases_show():
    linked = {"X_m": [4e-7, 4e-7, 8e-7], "omega": [5.0, 10.0, 20.0]}
    ds = run({"cases": linked})
    data = read_data(linked | {"F_max": ds[FORCE].values.tolist()})
    (axes,) = panels(drawn(ds, FORCE, data=data))
    assert axes.get_xlabel().startswith(r"$\omega$")  # X_m is not different in all cases
    (points,) = axes.containers
    np.testing.assert_array_equal(points.lines[0].get_xdata(), [5.0, 10.0, 20.0])
    with pytest.raises(ValueError, match="the data have no column angular_frequency"):
        drawn(ds, FORCE, data=read_data({"X_m": [4e-7], "F_max": [1e-3]}))


def test_a_measured_value_that_one_of_several_panels_shows_is_drawn(ds):
    table = {"T": [200.0, 250.0], "K": [1000.0, 3000.0], "F_max": [1e-3, 2e-3]}
    figure = drawn(ds, FORCE, x="T", col="K", data=read_data(table))
    points = [axes.containers[0].lines[0].get_xdata().tolist() for axes in panels(figure)]
    assert points == [[200.0], [], [250.0]]
    assert "Not drawn" not in note(figure)
    table["K"][0] = 1500.0
    figure = drawn(ds, x="T", col="K", data=read_data(table))
    assert "Not drawn: 1 measured value at other parameters." in note(figure)


@pytest.mark.parametrize("log", ["", "z"])
def test_the_vertical_axis_reaches_all_measured_points(ds, log):
    table = {"T": [200.0, 250.0], "K": [1000.0, 3000.0], "F_max": [1e-3, 9e-3]}
    table |= {"F_max_error": [2e-3, 1e-3]}
    for axes in panels(drawn(ds, FORCE, x="T", col="K", log=log, data=read_data(table))):
        low, high = axes.get_ylim()
        assert low < (1.0 if log else -1.0)
        assert 10.0 < high < 12.0


def with_regimes(ds):
    regimes = (np.arange(ds.status.size) % 5).reshape(ds.status.shape).astype("i1")
    return described(ds.assign(regime=(ds.status.dims, regimes)))


def test_given_axes_have_the_legend_of_kinds_above_and_the_title_above_that(ds):
    figure = Figure(figsize=(3.37, 3.0), layout="constrained")
    axes = figure.subplots()
    drawn(with_regimes(ds), "regime", x="T", y="K", look=Look(axes=axes, title="My oil"))
    figure.draw_without_rendering()
    legend = axes.get_legend()
    box, panel = legend.get_window_extent(), axes.get_window_extent()
    assert box.y0 >= panel.y1
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    title = legend.get_title()
    assert title.get_text() == "My oil"
    assert title.get_window_extent().y0 >= max(
        text.get_window_extent().y1 for text in legend.get_texts()
    )


def test_a_scale_of_values_says_nothing_of_kinds(ds):
    assert note(drawn(with_regimes(ds), FORCE, "regime", x="T", y="K", log="z")) == ""


def test_a_posterior_has_the_size_asked_for_and_letters_on_its_panels_alone():
    figure = draw(posterior(), "posterior", PlotOptions(look=Look(size=(3.0, 3.0), letters=True)))
    assert tuple(figure.get_size_inches()) == (3.0, 3.0)
    assert [axes.texts[-1].get_text() for axes in figure.axes] == ["(a)", "(b)", "(c)"]
    with pytest.raises(ValueError, match="this picture needs a whole figure; leave ax out"):
        draw(posterior(), "posterior", PlotOptions(look=Look(axes=Figure().subplots())))


def test_the_note_of_a_posterior_explains_its_contours_and_lines():
    figure = draw(posterior(), "posterior")
    assert note(figure) == (
        "1600 independent draws. Contours enclose 68 and 95\u00a0% of the probability; dashed "
        "lines are the 2.5, 50 and 97.5\u00a0% quantiles."
    )
    figure.draw_without_rendering()
    (small_print,) = figure.texts
    below = min(axes.xaxis.label.get_window_extent().y0 for axes in figure.axes)
    assert small_print.get_window_extent().y1 <= below


def test_a_small_posterior_has_few_numbers_and_its_labels_beside_them():
    figure = draw(posterior(), "posterior", PlotOptions(look=Look(size=(3.37, 3.0))))
    figure.draw_without_rendering()
    (_, corner, right) = figure.axes
    assert [axes.get_xlabel()[:3] for axes in (corner, right)] == ["$k$", r"$\g"]
    for axes in (corner, right):
        low, high = axes.get_xlim()
        numbers = [text for text in axes.get_xticklabels() if low <= text.get_position()[0] <= high]
        assert 2 <= len(numbers) <= 4
        lowest = min(text.get_window_extent().y0 for text in numbers)
        assert axes.xaxis.label.get_window_extent().y1 <= lowest
    leftmost = min(text.get_window_extent().x0 for text in corner.get_yticklabels())
    assert corner.yaxis.label.get_window_extent().x1 <= leftmost


def test_letters_may_begin_anywhere(ds):
    (axes, other) = panels(drawn(ds, look=Look(letters="b")))
    assert [text.get_text() for text in (axes.texts[-1], other.texts[-1])] == ["(b)", "(c)"]
    with pytest.raises(
        ValueError, match="letters run out at z: too few for 2 panels starting at z"
    ):
        drawn(ds, look=Look(letters="z"))


def test_a_measured_value_belongs_to_the_nearest_curve_or_panel_alone():
    ds = run({"sweep": {"omega": [10.0, 20.0], "T": [284.0, 286.0, 288.0]}})
    table = {"omega": [12.0, 14.0], "T": [284.0, 288.0], "F_max": [1e-3, 2e-3]}
    (axes,) = panels(drawn(ds, FORCE, x="omega", hue="T", data=read_data(table)))
    points = [each.lines[0].get_xdata().tolist() for each in axes.containers]
    assert points == [[12.0], [], [14.0]]
    figure = drawn(ds, FORCE, x="omega", col="T", data=read_data(table))
    points = [axes.containers[0].lines[0].get_xdata().tolist() for axes in panels(figure)]
    assert points == [[12.0], [], [14.0]]


def test_a_measured_value_has_all_parameters_of_linked_cases():
    ds = run({"cases": {"T": [200.0, 220.0, 240.0], "K": [3000.0, 3200.0, 3400.0]}})
    table = {"T": [200.0, 230.0, 240.0], "K": [3000.0, 3300.0, 9999.0], "F_max": [1e-3] * 3}
    figure = drawn(ds, FORCE, x="T", data=read_data(table))
    (axes,) = panels(figure)
    assert axes.containers[0].lines[0].get_xdata().tolist() == [200.0, 230.0]
    assert "Not drawn: 1 measured value at other parameters." in note(figure)


def test_measured_values_are_not_drawn_over_a_variable_in_another_unit(ds):
    force = (ds[FORCE] * 1e3).assign_attrs(ds[FORCE].attrs | {"units": "mN"})
    table = {"T": [200.0], "K": [1000.0], "F_max": [1e-3]}
    with pytest.raises(ValueError, match="the data are in N and friction_force_amplitude is in mN"):
        drawn(ds.assign({FORCE: force}), FORCE, x="T", hue="K", data=read_data(table))
