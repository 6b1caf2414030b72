"""The pictures: curves, units and labels."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from support.pictures import (
    GAMMAS,
    TEMPERATURES,
    curves,
    described,
    drawn,
    fitted,
    legend_of,
    panels,
    portraits,
    sweep,
    trajectory,
)

from sweeps.charts.axes import axis_of, is_geometric
from sweeps.charts.choice import default_figure
from sweeps.charts.colours import CURVES
from sweeps.charts.labels import shown, typeset_units, with_error
from sweeps.figures import Look, PlotOptions, draw
from sweeps.fitting.output import GIVEN, RELATIVE
from sweeps.measurements import read_data

# --- amplitudes ---------------------------------------------------------------------------------


def test_amplitudes_are_two_panels_with_a_curve_for_each_lubricant_in_shown_units():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    upper, lower = panels(draw(ds))
    assert lower.get_xlabel() == "$T$ (K)"
    assert upper.get_ylabel() == r"$\sigma_\mathrm{el,max}$ (MPa)"
    assert lower.get_ylabel() == r"$F_\mathrm{max}$ (mN)"
    for axes, name, factor in (
        (upper, "elastic_stress_amplitude", 1e-6),
        (lower, "friction_force_amplitude", 1e3),
    ):
        assert len(curves(axes)) == 3
        for i, line in enumerate(curves(axes)):
            np.testing.assert_array_equal(line.get_xdata(), TEMPERATURES)
            expected = ds[name].isel(rheological_index=i) * factor
            np.testing.assert_allclose(line.get_ydata(), expected, rtol=1e-14)
    assert upper.get_shared_x_axes().joined(upper, lower)


def test_the_legend_names_the_fluids_with_fractions():
    ds = sweep(temperature=TEMPERATURES, rheological_index=[*GAMMAS, 0.5])
    assert legend_of(draw(ds)) == [
        r"pseudoplastic, $\gamma = -2/3$",
        r"Newtonian, $\gamma = 0$",
        r"dilatant, $\gamma = 2/3$",
        r"dilatant, $\gamma = 0.5$",
    ]


@pytest.mark.parametrize(
    ("gammas", "units"),
    [(GAMMAS, r"Pa$\cdot$s$^{\gamma+1}$"), ([-2 / 3], r"Pa$\cdot$s$^{1/3}$"), ([0], r"Pa$\cdot$s")],
)
def test_the_unit_of_k_depends_on_the_fluid(gammas, units):
    ds = sweep(viscosity_coefficient=np.linspace(1e4, 2e5, 12), rheological_index=list(gammas))
    assert panels(draw(ds))[1].get_xlabel() == f"$k$ ({units})"


def test_curves_that_coincide_stay_visible():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    lines = sorted(curves(panels(draw(ds))[1]), key=lambda line: line.get_zorder())
    widths = [line.get_linewidth() for line in lines]
    assert widths == sorted(widths, reverse=True)
    assert min(a / b for a, b in itertools.pairwise(widths)) > 1.5
    assert lines[-1].get_linestyle() == "--"
    assert len({to_hex(line.get_color()) for line in lines}) == 3


def test_no_two_styles_are_alike_in_width_and_dashes_or_in_colour():
    assert len({style.colour for style in CURVES}) == len(CURVES)
    assert len({(style.width, style.dashes) for style in CURVES}) == len(CURVES)


@pytest.mark.parametrize(
    ("values", "scale"),
    [
        (np.geomspace(100.0, 1e4, 30), "log"),
        (np.linspace(100.0, 1e4, 30), "linear"),
    ],
)
def test_the_x_axis_is_logarithmic_where_the_points_are(values, scale):
    upper, lower = panels(draw(sweep(spring_stiffness=values, rheological_index=list(GAMMAS))))
    assert upper.get_xscale() == lower.get_xscale() == scale
    assert lower.get_xlabel() == "$K$ (N/m)"


def test_a_short_range_has_ticks_that_differ():
    temperatures = np.linspace(250.0, 250.0005, 13)
    for axes in panels(draw(sweep(temperature=temperatures))):
        assert axes.get_xscale() == "linear"
    assert axis_of(sweep(temperature=np.geomspace(250.0, 260.0, 13)), "temperature").geometric


def test_only_values_with_a_common_ratio_are_geometric():
    assert is_geometric(np.geomspace(1e-9, 1e-3, 50))
    assert not is_geometric(np.array([1.0, 2.0]))
    assert not is_geometric(np.array([-4.0, -2.0, -1.0]))
    assert not is_geometric(np.array([1.0, 2.0, 4.1]))


def test_an_unsorted_axis_is_drawn_in_order():
    ds = sweep(temperature=[300.0, 150.0, 220.0, 180.0, 200.0, 280.0, 250.0, 190.0, 170.0])
    (line,) = curves(panels(draw(ds))[0])
    order = np.argsort(ds.temperature.values)
    np.testing.assert_array_equal(line.get_xdata(), ds.temperature.values[order])
    np.testing.assert_allclose(line.get_ydata(), ds.elastic_stress_amplitude[order] * 1e-6)


def test_points_at_zero_lie_inside_the_panel():
    ds = sweep(temperature=TEMPERATURES)
    ds["elastic_stress_amplitude"][20:] = 0.0
    bottom, top = panels(draw(ds))[0].get_ylim()
    assert bottom < 0 < 4 < top


# --- trajectories -------------------------------------------------------------------------------


def test_a_pull_shows_the_spring_force_and_the_friction_force_together():
    ds = trajectory()
    axes = panels(draw(ds, "pull"))
    assert [panel.get_ylabel() for panel in axes] == ["$V$ (µm/s)", "$F$, $2Kx$ (mN)", r"$\varphi$"]
    spring, friction = curves(axes[1])
    np.testing.assert_allclose(spring.get_ydata(), 1e3 * ds.spring_force)
    np.testing.assert_allclose(friction.get_ydata(), 1e3 * ds.friction_force)


def test_a_pull_of_many_slips_is_a_band_and_its_last_slips():
    ds = trajectory()
    time = ds.elapsed_time.values
    slips = np.linspace(time[0], time[-1], 101)
    figure = draw(ds.assign(melting_time=("melting", slips)), "pull")
    whole, end = np.array(panels(figure)).reshape(3, 2).T
    assert [axes[0].get_title() for axes in (whole, end)] == [
        "101 slips, lowest to highest value",
        "the last 8",
    ]
    for axes in whole:
        assert not curves(axes)
        assert axes.get_xlim() == (time[0], time[-1])
    bands = np.concatenate([path.vertices for path in whole[1].collections[0].get_paths()])
    spring = 1e3 * ds.spring_force.values
    assert (bands[:, 1].min(), bands[:, 1].max()) == (spring.min(), spring.max())
    spring_line, _ = curves(end[1])
    assert spring_line.get_xdata()[0] >= slips[-9]
    np.testing.assert_array_equal(spring_line.get_ydata(), spring[time >= slips[-9]])
    few = draw(ds.assign(melting_time=("melting", slips[:30])), "pull")
    assert len(panels(few)) == 3


def test_a_part_of_a_pull_shows_its_own_slips():
    ds = trajectory()
    time = ds.elapsed_time.values
    slips = np.linspace(time[0], time[-1], 101)
    ds = ds.assign(melting_time=("melting", slips))
    figure = draw(ds.isel(elapsed_time=slice(200)), "pull")
    whole, end = np.array(panels(figure)).reshape(3, 2).T
    assert whole[0].get_title() == "50 slips, lowest to highest value"
    assert curves(end[0])[0].get_xdata().size > 0
    assert len(panels(draw(ds.isel(elapsed_time=slice(100)), "pull"))) == 3


def stroboscopic(x: np.ndarray) -> xr.Dataset:
    columns = {"stroboscopic_displacement": 1e-6 * x, "stroboscopic_velocity": -2e-6 * x}
    data = {name: ("period", values) for name, values in columns.items()}
    return trajectory().assign(data).assign_coords(period=np.arange(x.size, dtype="i4"))


def test_a_settled_orbit_is_shown_on_its_way():
    n = np.arange(201)
    axes = panels(draw(stroboscopic(1.0 - 0.5**n), "orbit"))[-1]
    assert axes.get_xlabel() == "drive periods from the start"
    assert axes.get_title().endswith("on the orbit after 9 periods")
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 1.0 - 0.5 ** n[:18])
    twofold = panels(draw(stroboscopic((-1.0) ** n * (1.0 - 0.5**n)), "orbit"))[-1]
    assert "on the orbit after" in twofold.get_title()
    chaos = np.random.default_rng(1).uniform(size=201)
    axes = panels(draw(stroboscopic(chaos), "orbit"))[-1]
    assert axes.get_title() == "stroboscopic map of 200 periods; dots: the last 32"
    assert {line.get_linestyle() for line in axes.lines} <= {"None", "-"}
    assert axes.lines[0].get_linewidth() == 0.0


def test_time_courses_are_four_panels_with_the_upper_block_dashed():
    ds = trajectory()
    axes = panels(draw(ds))
    labels = [panel.get_ylabel() for panel in axes]
    assert labels == [
        "$X$, $x$ (µm)",
        "$V$, $v$ (µm/s)",
        r"$\sigma_\mathrm{el}$ (MPa)",
        "$F$ (mN)",
    ]
    assert axes[-1].get_xlabel() == "$t$ (s)"
    for panel, name, factor in (
        (axes[0], "displacement", 1e6),
        (axes[1], "velocity", 1e6),
    ):
        lower, upper = curves(panel)
        assert (lower.get_linestyle(), upper.get_linestyle()) == ("-", "--")
        assert upper.get_zorder() > lower.get_zorder()
        np.testing.assert_array_equal(lower.get_xdata(), ds.elapsed_time)
        np.testing.assert_allclose(lower.get_ydata(), ds[f"lower_{name}"] * factor)
        np.testing.assert_allclose(upper.get_ydata(), ds[f"upper_{name}"] * factor)
    np.testing.assert_allclose(curves(axes[2])[0].get_ydata(), ds.elastic_stress * 1e-6)
    np.testing.assert_allclose(curves(axes[3])[0].get_ydata(), ds.friction_force * 1e3)


def test_relative_motion_is_upper_minus_lower():
    ds = trajectory()
    upper, lower = panels(draw(ds, "relative_motion"))
    shift = (ds.upper_displacement - ds.lower_displacement) * 1e6
    slip = (ds.upper_velocity - ds.lower_velocity) * 1e6
    np.testing.assert_allclose(curves(upper)[0].get_ydata(), shift, atol=1e-12)
    np.testing.assert_allclose(curves(lower)[0].get_ydata(), slip, atol=1e-12)
    assert [upper.get_ylabel(), lower.get_ylabel()] == ["$X - x$ (µm)", "$V - v$ (µm/s)"]


@pytest.mark.parametrize(
    ("figure", "across", "up", "factor", "labels"),
    [
        (
            "phase_portraits",
            "lower_displacement",
            "lower_velocity",
            1e6,
            ("$x$ (µm)", "$v$ (µm/s)"),
        ),
        ("force_loops", "upper_displacement", "friction_force", 1e3, ("$X$ (µm)", "$F$ (mN)")),
    ],
)
def test_portraits_are_lettered_panels_with_their_frequency(figure, across, up, factor, labels):
    ds = portraits()
    axes = panels(draw(ds, figure))
    for i, (panel, omega) in enumerate(zip(axes, (10, 15, 32, 38), strict=True)):
        assert panel.get_title(loc="left") == rf"({'abcd'[i]}) $\omega = {omega}$ rad/s"
        (line,) = curves(panel)
        one = ds.isel(angular_frequency=i)
        np.testing.assert_allclose(line.get_xdata(), one[across] * 1e6)
        np.testing.assert_allclose(line.get_ydata(), one[up] * factor)
        assert (panel.get_xlabel(), panel.get_ylabel()) == labels
    assert {panel.get_subplotspec().rowspan.start for panel in axes} == {0, 1}


def test_a_single_portrait_needs_no_letter():
    (axes,) = panels(draw(trajectory(), "phase_portraits"))
    assert axes.get_title(loc="left") == ""


def test_several_trajectories_get_a_column_each():
    figure = draw(portraits())
    assert len(panels(figure)) == 16
    assert panels(figure)[2].get_title() == r"$\omega = 32$ rad/s"


def test_a_parameter_that_steps_along_time_makes_sections():
    ds = trajectory()
    temperature = np.where(ds.elapsed_time < ds.elapsed_time[150], 200.0, 250.0)
    ds = described(ds.assign_coords(temperature=("elapsed_time", temperature)))
    figure = draw(ds)
    assert [text.get_text() for text in panels(figure)[0].texts] == ["$T = 200$ K", "$T = 250$ K"]
    assert [line.get_xdata().size for line in curves(panels(figure)[3])] == [150, 251]
    (border,) = (line for line in panels(figure)[2].get_lines() if line.get_gid() == "border")
    assert border.get_xdata()[0] == pytest.approx(float(ds.elapsed_time[149]))


# --- choosing, labels, units --------------------------------------------------------------------


def test_the_figure_is_chosen_from_the_dataset():
    assert default_figure(trajectory()) == "time_courses"
    assert default_figure(portraits()) == "time_courses"
    assert default_figure(sweep(temperature=TEMPERATURES)) == "amplitudes"


@pytest.mark.parametrize(
    ("ds", "figure", "words"),
    [
        (trajectory(), "time_course", "did you mean 'time_courses'"),
        (trajectory(), "pie", "there are amplitudes, pairs, time_courses"),
        (trajectory(), "amplitudes", "draws a sweep, and this file holds none"),
        (
            sweep(temperature=TEMPERATURES),
            "phase_portraits",
            "draws a trajectory, and this file holds none",
        ),
        (xr.Dataset(), None, "needs elastic_stress_amplitude, friction_force_amplitude"),
    ],
)
def test_a_figure_without_its_data_is_refused_by_name(ds, figure, words):
    with pytest.raises(ValueError, match=words):
        draw(ds, figure)


def test_a_converted_variable_keeps_its_own_unit():
    ds = sweep(temperature=TEMPERATURES)
    ds["elastic_stress_amplitude"] = ds.elastic_stress_amplitude * 1e-3
    ds["elastic_stress_amplitude"].attrs["units"] = "kPa"
    upper = panels(draw(ds))[0]
    assert upper.get_ylabel().endswith("(kPa)")
    np.testing.assert_allclose(curves(upper)[0].get_ydata(), ds.elastic_stress_amplitude)


def test_a_converted_parameter_keeps_its_own_unit():
    thickness = xr.DataArray(1e-3, name="film_thickness", attrs={"units": "um"})
    assert shown(thickness).equation == "$h = 0.001$ um"


@pytest.mark.parametrize(
    ("units", "typeset"),
    [
        ("1", ""),
        ("", ""),
        ("K", "K"),
        ("rad s-1", "rad/s"),
        ("J m-3", "J/m$^{3}$"),
        ("s-1", "1/s"),
        ("m3 J-1 s-1", r"m$^{3}$/(J$\cdot$s)"),
    ],
)
def test_units_are_typeset(units, typeset):
    assert typeset_units(units) == typeset


@pytest.mark.parametrize(
    ("name", "value", "equation"),
    [
        ("film_thickness", 1e-9, "$h = 1$ nm"),
        ("film_thickness", 1e300, r"$h = 1\times10^{300}$ m"),  # which nm would make infinite
        ("noise_intensity", 1e-18, r"$D = 1\times10^{-18}$ 1/s"),
        ("temperature", 200 / 3, "$T = 66.6667$ K"),
        ("rheological_index", 0.5, r"$\gamma = 0.5$"),
        ("rheological_index", 0.1234567, r"$\gamma = 0.123457$"),
        ("drive_amplitude", -0.8e-6, "$X_m = -0.8$ µm"),
    ],
)
def test_a_value_is_named_with_symbol_and_unit(name, value, equation):
    assert shown(xr.DataArray(value, name=name)).equation == equation


def test_a_fit_has_curves_data_with_error_bars_and_residuals_below():
    figure = draw(fitted(5.0, 10.0))
    above, below = panels(figure)
    assert [len(bars.get_segments()) for bars in above.collections] == [3, 1, 4]
    assert len(below.lines) == 1 + 3  # zero; the second datum, at a jump, is another line
    (square,) = (line for line in below.lines if line.get_marker() == "s")
    assert square.get_xdata().tolist() == [200.0]
    assert below.get_ylabel() == "residual"
    said = "Residuals are in standard errors. Squares mark data next to a jump."
    assert said in figure.get_supxlabel().replace("\n", " ")


def test_a_fit_of_which_one_curve_is_chosen_leaves_out_the_data_of_the_others():
    whole = fitted(5.0, 10.0)
    figure = draw(whole.sel(angular_frequency=10.0))
    above, below = panels(figure)
    assert sum(len(bars.get_segments()) for bars in above.collections) == 4
    assert "Not drawn: 4 data at other parameters." in figure.get_supxlabel().replace("\n", " ")
    assert len(panels(draw(whole.transpose()))[1].lines) == len(panels(draw(whole))[1].lines)
    assert panels(draw(whole.transpose()))[1].get_xlabel() == below.get_xlabel()


def test_the_note_of_a_fit_has_the_digits_of_the_printed_summary():
    ds = drawn()
    ds["parameter_value"] = ("free_parameter", [6.9e4, -0.55])
    ds["parameter_standard_error"] = ("free_parameter", [1e4, 0.012])
    assert (with_error(6.9e4, 1e4), with_error(-0.55, 0.012)) == ("(6.9±1.0)×10⁴", "-0.550±0.012")
    said = draw(ds).get_supxlabel()
    assert r"Fitted: $k = \left(6.9 \pm 1.0\right) \times 10^{4}$ Pa" in said
    assert r"$\gamma = -0.550 \pm 0.012$;" in said


def test_the_note_of_a_fit_knows_data_without_errors_by_the_sentence_in_the_file():
    ds = fitted().assign_attrs(reduced_chi2=1e-4)
    for errors, words in ((RELATIVE, "relative scatter 1\u00a0%."), (GIVEN, "/dof 0.0001.")):
        figure = draw(ds.assign_attrs(measurement_errors=errors))
        assert words in figure.get_supxlabel().replace("\n", " ")


def test_the_labels_of_a_small_fit_are_within_its_panels():
    figure = draw(fitted(), None, PlotOptions(look=Look(size=(3.37, 3.0))))
    figure.draw_without_rendering()
    for axes in panels(figure):
        label, panel = axes.yaxis.label.get_window_extent(), axes.get_window_extent()
        assert panel.y0 <= label.y0 < label.y1 <= panel.y1


def test_measured_values_have_the_same_marker_in_a_fit_and_over_a_curve():
    data = read_data({"T": [200.0], "F_max": [3e-3]})
    over = draw(sweep(temperature=TEMPERATURES), None, PlotOptions(("F_max",), data=data))
    of_fit = panels(draw(fitted()))[0]
    one, other = (axes.containers[0].lines[0] for axes in (*panels(over), of_fit))
    for own in ("marker", "markersize", "markerfacecolor", "markeredgecolor", "markeredgewidth"):
        assert getattr(one, f"get_{own}")() == getattr(other, f"get_{own}")()


@pytest.mark.parametrize(
    ("part", "figure", "said"),
    [
        (fitted().squeeze(), None, "'fit' needs the dimension free_parameter"),
        (fitted().isel(datum=0), None, "'fit' needs the dimension datum"),
        (drawn().isel(free_parameter=0), "posterior", "needs the dimension free_parameter"),
        (trajectory().isel(elapsed_time=0), None, "a single instant is not a motion"),
        (portraits(), "orbit", "draws one trajectory, but there are several"),
    ],
)
def test_a_part_without_what_a_figure_needs_is_refused(part, figure, said):
    with pytest.raises(ValueError, match=said):
        draw(part, figure)


def test_the_curve_of_a_squeezed_fit_is_drawn():
    curve = fitted().drop_dims("datum").squeeze()
    assert len(panels(draw(curve, options=PlotOptions("F_max")))) == 1
