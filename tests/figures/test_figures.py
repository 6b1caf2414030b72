"""The pictures: what is drawn, in which unit, what is missing, and that files are reproducible."""

from __future__ import annotations

import itertools
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from support.marks import one_then

from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULTS, TRAJECTORY
from sweeps.figure_table import FIGURES
from sweeps.figures import default_figure, draw, obstacle, save
from sweeps.figures.labels import shown, typeset_units
from sweeps.figures.layout import is_geometric, layout_of
from sweeps.figures.style import CURVES

VARIABLES = {**PARAMETERS, **TRAJECTORY, **RESULTS}
GAMMAS = (-2 / 3, 0.0, 2 / 3)
TEMPERATURES = np.linspace(150.0, 320.0, 35)


def described(ds: xr.Dataset) -> xr.Dataset:
    for name in map(str, ds.variables):
        if name in VARIABLES:
            ds[name].attrs.update(units=VARIABLES[name].units, symbol=VARIABLES[name].symbol)
    return ds


def sweep(**axes) -> xr.Dataset:
    """A sweep over the given axes whose stress falls with every axis; the force is constant."""
    shape = tuple(len(values) for values in axes.values())
    ramps = np.meshgrid(*(np.linspace(1.0, 0.2, n) for n in shape), indexing="ij")
    stress = 4e6 * np.prod(ramps, axis=0) if shape else np.array(4.3e6)
    dims = tuple(axes)
    data = {
        "elastic_stress_amplitude": (dims, stress),
        "friction_force_amplitude": (dims, np.full(shape, 4.768e-3)),
        "melting_count": (dims, np.full(shape, 4, dtype="i4")),
        "status": (dims, np.zeros(shape, dtype="i1")),
    }
    fixed = {"block_mass": 0.4, "spring_stiffness": 3000.0, "temperature": 200.0}
    coords = {**{name: value for name, value in fixed.items() if name not in axes}, **axes}
    return described(xr.Dataset(data, coords, attrs={"title": "Three lubricants, γ ≠ 1"}))


def failed(ds: xr.Dataset, status: Status, **index) -> xr.Dataset:
    """The same sweep with some points ended otherwise, as a result file holds them."""
    ds = ds.copy(deep=True)
    ds["status"][index] = status
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        ds[name][index] = np.nan
    return ds


def linked(ds: xr.Dataset) -> xr.Dataset:
    """A sweep along `case` with the parameters of two to nine linked cases."""
    count = ds.sizes["case"]
    amplitude = np.linspace(0.4e-6, 0.8e-6, count)
    linked_coords = {
        "drive_amplitude": ("case", amplitude),
        "angular_frequency": ("case", 8e-6 / amplitude),
    }
    return described(ds.assign_coords(case=np.arange(count, dtype="i4"), **linked_coords))


def motion(omega: float = 10.0, start: float = 0.0, samples: int = 400) -> dict[str, np.ndarray]:
    t = start + np.linspace(0.0, 2 * 2 * np.pi / omega, samples)
    X, V = 0.8e-6 * np.cos(omega * t), -0.8e-6 * omega * np.sin(omega * t)
    x, v = 0.3e-6 * np.sin(3 * omega * t), 0.9e-6 * omega * np.cos(3 * omega * t)
    strain = (V - v) * 10.0
    columns = [t, X, x, V, v, np.full_like(t, 0.6), strain, strain * 1e12, strain * 1e9, V * 500]
    return dict(zip(TRAJECTORY, columns, strict=True))


def trajectory() -> xr.Dataset:
    columns = motion()
    time = columns.pop("time")
    data = {name: ("time", values) for name, values in columns.items()}
    return described(xr.Dataset(data, {"time": time, "temperature": 200.0}))


def trajectories(dim: str, values, columns) -> xr.Dataset:
    data = {name: ((dim, "sample"), np.stack([c[name] for c in columns])) for name in TRAJECTORY}
    return described(xr.Dataset(data, {dim: list(values)}).set_coords("time"))


def portraits() -> xr.Dataset:
    omegas = (10.0, 15.0, 32.0, 38.0)
    return trajectories("angular_frequency", omegas, [motion(omega) for omega in omegas])


def curves(axes):
    """The lines of a panel that show data."""
    furniture = {"missing", "origin", "border"}
    return [line for line in axes.get_lines() if line.get_gid() not in furniture]


def crosses(axes):
    return [line for line in axes.get_lines() if line.get_gid() == "missing"]


def note(figure) -> str:
    return figure.get_supxlabel().replace("\n", " ")


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


# --- amplitudes ---------------------------------------------------------------------------------


def test_amplitudes_are_two_panels_with_a_curve_per_lubricant_in_shown_units():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    upper, lower = panels(draw(ds))
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


def test_labels_come_from_the_registry_with_the_shown_unit():
    upper, lower = panels(draw(sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))))
    assert lower.get_xlabel() == "$T$ (K)"
    assert upper.get_ylabel() == r"$\sigma_\mathrm{el,max}$ (MPa)"
    assert lower.get_ylabel() == r"$F_\mathrm{max}$ (mN)"


def test_the_legend_names_the_lubricants_as_fractions():
    ds = sweep(temperature=TEMPERATURES, rheological_index=[*GAMMAS, 0.5])
    (legend,) = draw(ds).legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert labels == [r"$\gamma = -2/3$", r"$\gamma = 0$", r"$\gamma = 2/3$", r"$\gamma = 0.5$"]


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


def test_a_geometric_axis_is_told_from_any_other():
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


# --- missing points -----------------------------------------------------------------------------


def test_missing_points_are_gaps_crosses_and_a_note():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    ds = failed(ds, Status.NOT_STATIONARY, temperature=slice(5, 8), rheological_index=0)
    ds = failed(ds, Status.PENDING, temperature=20, rheological_index=2)
    figure = draw(ds)
    for axes in panels(figure):
        gaps = [np.flatnonzero(np.isnan(line.get_ydata())).tolist() for line in curves(axes)]
        assert gaps == [[5, 6, 7], [], [20]]
        first, second = crosses(axes)
        np.testing.assert_array_equal(first.get_xdata(), TEMPERATURES[5:8])
        np.testing.assert_array_equal(second.get_xdata(), TEMPERATURES[[20]])
        assert first.get_color() != second.get_color()
        assert axes.get_ylim()[1] * second.get_ydata()[0] > np.nanmax(curves(axes)[1].get_ydata())
    assert note(figure) == "× 4 of 105 points missing (3 not stationary, 1 pending)"


def test_a_number_with_a_bad_status_is_not_drawn():
    ds = sweep(temperature=TEMPERATURES)
    ds["status"][3] = Status.INVARIANT_VIOLATED
    figure = draw(ds)
    assert all(np.isnan(curves(axes)[0].get_ydata()[3]) for axes in panels(figure))
    assert "1 of 35 points missing (1 invariant violated)" in note(figure)


def test_a_nan_without_a_reason_is_told():
    ds = sweep(temperature=TEMPERATURES)
    ds["friction_force_amplitude"][3] = np.nan
    assert "1 without a value" in note(draw(ds))


def test_no_note_where_nothing_is_missing():
    assert note(draw(sweep(temperature=TEMPERATURES))) == ""


def test_a_point_between_two_gaps_has_a_marker():
    ds = failed(sweep(temperature=TEMPERATURES), Status.DIVERGED, temperature=[9, 11])
    (line,) = curves(panels(draw(ds))[0])
    assert line.get_marker() == "o"
    assert line.get_markevery() == [10]


def test_a_sweep_without_any_result_still_says_so():
    ds = failed(sweep(temperature=TEMPERATURES), Status.REFUSED, temperature=slice(None))
    assert "35 of 35 points missing (35 refused)" in note(draw(ds))


# --- layouts ------------------------------------------------------------------------------------


def test_two_long_axes_give_maps_with_colour_bars():
    k = np.geomspace(1e4, 2e5, 12)
    ds = sweep(temperature=TEMPERATURES, viscosity_coefficient=k)
    ds = failed(ds, Status.DIVERGED, temperature=4, viscosity_coefficient=7)
    figure = draw(ds)
    upper, lower = panels(figure)
    (mesh,) = (c for c in upper.collections if isinstance(c, QuadMesh))
    expected = (ds.elastic_stress_amplitude * 1e-6).transpose("viscosity_coefficient", ...)
    np.testing.assert_allclose(mesh.get_array().filled(np.nan), expected)
    bars = [axes.get_ylabel() for axes in figure.axes if axes not in (upper, lower)]
    assert bars == [r"$\sigma_\mathrm{el,max}$ (MPa)", r"$F_\mathrm{max}$ (mN)"]
    assert (lower.get_xlabel(), lower.get_ylabel()) == ("$T$ (K)", r"$k$ (Pa$\cdot$s)")
    assert (lower.get_xscale(), lower.get_yscale()) == ("linear", "log")
    assert note(figure) == "Grey: 1 of 420 points missing (1 diverged)"


def test_the_cells_of_a_map_lie_around_their_points():
    k = np.geomspace(1e4, 2e5, 12)
    upper = panels(draw(sweep(temperature=TEMPERATURES, viscosity_coefficient=k)))[0]
    corners = upper.collections[0].get_coordinates()
    np.testing.assert_allclose(corners[0, :-1, 0] + 2.5, TEMPERATURES)
    np.testing.assert_allclose(np.sqrt(corners[:-1, 0, 1] * corners[1:, 0, 1]), k)


def test_facets_share_one_scale_and_say_what_they_leave_out():
    stiffness = [500.0, 1000.0, 2000.0, 3000.0, 4000.0, 6000.0]
    k = np.geomspace(1e4, 2e5, 12)
    ds = sweep(temperature=TEMPERATURES, viscosity_coefficient=k, spring_stiffness=stiffness)
    figure = draw(ds)
    titles = [axes.get_title() for axes in panels(figure)]
    assert titles[:4] == [f"$K = {value}$ N/m" for value in (500, 2000, 3000, 6000)]
    assert len({axes.collections[0].get_clim() for axes in panels(figure)[:4]}) == 1
    assert note(figure) == "4 of 6 values of $K$ are drawn."


def test_three_axes_with_one_long_give_curves_in_columns():
    ds = sweep(
        rheological_index=list(GAMMAS), temperature=TEMPERATURES, spring_stiffness=[1e3, 3e3]
    )
    figure = draw(ds)
    assert [axes.get_title() for axes in panels(figure)[:2]] == ["$K = 1000$ N/m", "$K = 3000$ N/m"]
    assert panels(figure)[0].get_ylim() == panels(figure)[1].get_ylim()
    line = curves(panels(figure)[1])[2]
    expected = ds.elastic_stress_amplitude.isel(rheological_index=2, spring_stiffness=1) * 1e-6
    np.testing.assert_allclose(line.get_ydata(), expected)


def test_the_longest_axis_carries_the_curves_where_all_are_short():
    ds = sweep(rheological_index=list(GAMMAS), temperature=[200.0, 220.0, 250.0, 300.0])
    assert layout_of(ds).axes == ("temperature",)
    assert layout_of(ds).curve == "rheological_index"


def test_linked_cases_are_labelled_with_all_their_parameters():
    ds = linked(sweep(temperature=TEMPERATURES, case=[0, 1]))
    labels = [text.get_text() for text in draw(ds).legends[0].get_texts()]
    assert labels[1] == r"$X_m = 0.8$ µm, $\omega = 10$ rad/s"


def test_linked_cases_alone_lie_along_their_first_parameter():
    ds = linked(sweep(case=np.arange(9)))
    lower = panels(draw(ds))[1]
    np.testing.assert_allclose(curves(lower)[0].get_xdata(), np.linspace(0.4, 0.8, 9))
    assert lower.get_xlabel() == r"$X_m$ (µm), linked with $\omega$"


@pytest.mark.parametrize("axes", [{}, {"temperature": [200.0]}])
def test_a_single_point_is_a_table(axes):
    figure = draw(sweep(**axes))
    lines = [text.get_text() for text in figure.texts]
    assert lines[0] == "A single point: nothing was swept."
    assert r"$F_\mathrm{max} = 4.768$ mN" in lines
    assert r"$n_\mathrm{melt} = 4$" in lines
    assert "$T = 200$ K" in lines


def test_a_failed_single_point_says_why():
    ds = sweep(temperature=[200.0])
    ds["status"][0] = Status.DIVERGED
    ds["melting_count"][0] = -1
    lines = [text.get_text() for text in draw(ds).texts]
    assert Status.DIVERGED.sentence in " ".join(lines)
    assert r"$F_\mathrm{max}$ missing" in lines
    assert r"$n_\mathrm{melt}$ missing" in lines


# --- trajectories -------------------------------------------------------------------------------


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
        np.testing.assert_array_equal(lower.get_xdata(), ds.time)
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


def test_phase_portraits_are_lettered_panels_with_their_frequency():
    ds = portraits()
    axes = panels(draw(ds, "phase_portraits"))
    titles = [panel.get_title(loc="left") for panel in axes]
    assert titles == [
        rf"({letter}) $\omega = {omega}$ rad/s"
        for letter, omega in zip("abcd", (10, 15, 32, 38), strict=True)
    ]
    for i, panel in enumerate(axes):
        (line,) = curves(panel)
        one = ds.isel(angular_frequency=i)
        np.testing.assert_allclose(line.get_xdata(), one.lower_displacement * 1e6)
        np.testing.assert_allclose(line.get_ydata(), one.lower_velocity * 1e6)
        assert (panel.get_xlabel(), panel.get_ylabel()) == ("$x$ (µm)", "$v$ (µm/s)")
    rows = {round(panel.get_subplotspec().rowspan.start) for panel in axes}
    assert rows == {0, 1}


def test_a_single_portrait_needs_no_letter():
    (axes,) = panels(draw(trajectory(), "phase_portraits"))
    assert axes.get_title(loc="left") == ""


def test_several_trajectories_get_a_column_each():
    figure = draw(portraits())
    assert len(panels(figure)) == 16
    assert panels(figure)[2].get_title() == r"$\omega = 32$ rad/s"


def test_a_parameter_that_steps_along_time_makes_sections():
    ds = trajectory()
    temperature = np.where(ds.time < ds.time[150], 200.0, 250.0)
    ds = described(ds.assign_coords(temperature=("time", temperature)))
    figure = draw(ds)
    assert [text.get_text() for text in panels(figure)[0].texts] == ["$T = 200$ K", "$T = 250$ K"]
    assert [line.get_xdata().size for line in curves(panels(figure)[3])] == [150, 250]
    (border,) = (line for line in panels(figure)[2].get_lines() if line.get_gid() == "border")
    assert border.get_xdata()[0] == pytest.approx(float(ds.time[150]))


# --- choosing, labels, units --------------------------------------------------------------------


def test_the_figure_is_chosen_from_the_dataset():
    assert default_figure(trajectory()) == "time_courses"
    assert default_figure(portraits()) == "time_courses"
    assert default_figure(sweep(temperature=TEMPERATURES)) == "amplitudes"


@pytest.mark.parametrize(
    ("ds", "figure", "words"),
    [
        (trajectory(), "time_course", "did you mean 'time_courses'"),
        (trajectory(), "pie", "there are amplitudes, time_courses"),
        (trajectory(), "amplitudes", "draws a sweep, and this file holds none"),
        (
            sweep(temperature=TEMPERATURES),
            "phase_portraits",
            "draws a trajectory, and this file holds none",
        ),
        (xr.Dataset(), None, "needs elastic_stress_amplitude, friction_force_amplitude"),
    ],
)
def test_what_cannot_be_drawn_is_refused_by_name(ds, figure, words):
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
        ("noise_intensity", 1e-18, r"$D = 1\times10^{-18}$ 1/s"),
        ("temperature", 200 / 3, "$T = 66.6667$ K"),
        ("rheological_index", 0.5, r"$\gamma = 0.5$"),
        ("rheological_index", 0.1234567, r"$\gamma = 0.123457$"),
        ("drive_amplitude", -0.8e-6, "$X_m = -0.8$ µm"),
    ],
)
def test_a_value_is_named_with_symbol_and_unit(name, value, equation):
    assert shown(xr.DataArray(value, name=name)).equation == equation


# --- files --------------------------------------------------------------------------------------


def test_both_formats_are_written_whole(tmp_path):
    figure = draw(sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)))
    png, pdf = save(figure, tmp_path / "new" / "fig7.5")
    assert [png.name, pdf.name] == ["fig7.5.png", "fig7.5.pdf"]
    assert png.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert pdf.read_bytes().startswith(b"%PDF-")
    assert pdf.read_bytes().rstrip().endswith(b"%%EOF")
    assert sorted(path.name for path in png.parent.iterdir()) == ["fig7.5.pdf", "fig7.5.png"]
    width = int.from_bytes(png.read_bytes()[16:20], "big")
    assert width == round(3.4 * 200)


def test_a_named_file_is_the_only_one_written(tmp_path):
    target = tmp_path / "one.pdf"
    assert save(draw(trajectory()), target) == [target]
    assert list(tmp_path.iterdir()) == [target]


def test_an_older_picture_survives_a_failure(tmp_path, monkeypatch):
    (old,) = save(draw(trajectory()), tmp_path / "a.png")
    before = old.read_bytes()

    def full_disk(path, content):
        with path.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError("no space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full_disk)
    with pytest.raises(OSError, match="no space"):
        save(draw(sweep(temperature=TEMPERATURES)), old)
    assert old.read_bytes() == before
    assert list(tmp_path.iterdir()) == [old]


def contents(ds: xr.Dataset, folder) -> list[bytes]:
    return [path.read_bytes() for path in save(draw(ds), folder / "picture")]


@pytest.mark.parametrize("kind", one_then("stress", ["trajectory", "curves", "map"]))
def test_two_runs_give_the_same_bytes(tmp_path, monkeypatch, kind):
    k = np.geomspace(1e4, 2e5, 12)
    ds = {
        "curves": sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)),
        "map": sweep(temperature=TEMPERATURES, viscosity_coefficient=k),
        "trajectory": trajectory(),
    }[kind]
    first = contents(ds, tmp_path / "a")
    # What matplotlib dates its files with; a day later must make no difference.
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert contents(ds, tmp_path / "b") == first


def test_drawing_in_threads_changes_nothing(tmp_path):
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    with ThreadPoolExecutor(3) as pool:
        results = list(pool.map(lambda i: contents(ds, tmp_path / str(i)), range(3)))
    assert all(result == results[0] for result in results)


def test_the_title_travels_in_the_file(tmp_path):
    ds = sweep(temperature=TEMPERATURES)
    (png,) = save(draw(ds), tmp_path / "a.png")
    assert "Three lubricants, γ ≠ 1".encode() in png.read_bytes()


def test_the_dataset_is_left_as_it_was():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    before = ds.copy(deep=True)
    draw(ds)
    assert ds.identical(before)


def test_importing_figures_needs_no_compiler_and_no_pyplot():
    code = (
        "import sys, sweeps.figures; heavy = ('numba', 'matplotlib.pyplot', 'stickslip.kernels'); "
        "print([name for name in heavy if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_figure_of_the_table_is_drawn_by_a_function_that_has_its_data():
    for name, entry in FIGURES.items():
        ds = trajectory() if entry.data == "trajectory" else sweep(temperature=TEMPERATURES)
        assert obstacle(ds, name) == ""
        assert panels(draw(ds, name))
        lacking = ds.drop_vars(entry.variables[0])
        assert obstacle(lacking, name) == (
            f"the figure '{name}' needs {entry.variables[0]}, which this file lacks"
        )


def test_the_table_of_figures_needs_no_matplotlib():
    code = "import sys, sweeps.figure_table; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
