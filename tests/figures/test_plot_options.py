"""The choices of a user: variables, axes, slices, scales; bad choices are refused."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from support.pictures import (
    GAMMAS,
    TEMPERATURES,
    curves,
    fitted,
    legend_of,
    linked,
    note,
    panels,
    portraits,
    sweep,
    trajectory,
)

import sweeps.accessor  # noqa: F401 - registers `stickslip`
from stickslip import Status
from stickslip.variables import RESULTS
from sweeps.figures import Look, PlotOptions, draw
from sweeps.measurements import read_data

STIFFNESS = np.geomspace(500.0, 1e4, 6)


@pytest.fixture
def ds():
    return sweep(
        temperature=TEMPERATURES, spring_stiffness=STIFFNESS, rheological_index=list(GAMMAS)
    )


def chosen(ds, **options):
    return draw(ds, None, PlotOptions(**options))


@pytest.mark.parametrize("name", ["friction_force_amplitude", "F_max"])
def test_a_variable_has_a_single_row_of_panels(ds, name):
    (axes,) = panels(chosen(ds, variable=name, at=("K=3000",)))
    assert axes.get_ylabel() == r"$F_\mathrm{max}$ (mN)"
    np.testing.assert_allclose(curves(axes)[0].get_ydata(), 4.768)


def test_a_variable_named_twice_is_drawn_once(ds):
    figure = chosen(ds, variable=("F_max", "friction_force_amplitude"), at=("K=3000",))
    assert len(panels(figure)) == 1


def test_axes_are_named_by_symbol_or_name(ds):
    figure = chosen(ds, x="K", hue="gamma", col="temperature", at=())
    assert [axes.get_xlabel() for axes in panels(figure)[4:]] == ["$K$ (N/m)"] * 4
    assert note(figure) == "4 of 35 values of $T$ are drawn."
    line = curves(panels(figure)[3])[2]
    expected = ds.elastic_stress_amplitude.isel(temperature=-1, rheological_index=2) * 1e-6
    np.testing.assert_allclose(line.get_ydata(), expected)


def test_a_slice_is_at_the_nearest_point_and_says_where(ds):
    figure = chosen(ds, at=("K=2900", "gamma=-2/3"))
    assert note(figure) == r"At $K = 3017.09$ N/m, $\gamma = -2/3$."
    expected = ds.elastic_stress_amplitude.isel(spring_stiffness=3, rheological_index=0) * 1e-6
    np.testing.assert_allclose(curves(panels(figure)[0])[0].get_ydata(), expected)


def test_several_points_of_an_axis_are_kept_with_it(ds):
    figure = chosen(ds, hue="T", x="K", at=("T=[180, 200, 300]", "gamma=-2/3"))
    wanted = [float(ds.temperature.sel(temperature=T, method="nearest")) for T in (180, 200, 300)]
    found = curves(panels(figure)[0])
    assert len(found) == 3
    expected = ds.elastic_stress_amplitude.sel(temperature=wanted).isel(rheological_index=0) * 1e-6
    for line, values in zip(found, expected.values, strict=True):
        np.testing.assert_allclose(line.get_ydata(), values)


def test_several_values_nearest_to_one_point_cut_the_axis_there(ds):
    figure = chosen(ds, variable="F_max", x="K", at=("T=200,201", "gamma=0"))
    assert note(figure).startswith("At $T = 200$ K")
    point = sweep(temperature=TEMPERATURES)
    assert chosen(point, at=("T=200,201",)).texts[0].get_text().startswith("At $T = 200$ K")
    with pytest.raises(ValueError, match="slices temperature a second time"):
        chosen(point, at=("T=200,201", "T=300"))


@pytest.mark.parametrize("motion", [trajectory, portraits])
def test_the_time_of_a_trajectory_is_not_cut(motion):
    ds = motion()
    along = ds["elapsed_time"].dims[-1]
    with pytest.raises(ValueError, match="a trajectory is drawn over all its time; to show a part"):
        chosen(ds, variable="friction_force", at=(f"{along}=0",))


def test_no_variable_is_the_default(ds):
    assert len(panels(chosen(ds, variable=(), x="T", at=("gamma=0", "K=3000")))) == 2


def test_y_makes_a_map(ds):
    figure = chosen(ds, x="T", y="K", at=("gamma=0",))
    for axes in panels(figure):
        assert any(isinstance(drawn, QuadMesh) for drawn in axes.collections)
    assert panels(figure)[0].get_ylabel() == "$K$ (N/m)"
    assert panels(figure)[0].get_yscale() == "log"


def test_rows_and_columns_of_a_variable(ds):
    figure = chosen(ds, variable="elastic_stress_amplitude", row="gamma", col="K")
    assert len(panels(figure)) == 12
    axes = panels(figure)[4 + 3]
    expected = ds.elastic_stress_amplitude.isel(rheological_index=1, spring_stiffness=5) * 1e-6
    np.testing.assert_allclose(curves(axes)[0].get_ydata(), expected)
    assert panels(figure)[4].get_ylabel().startswith("$\\gamma = 0$\n")


def test_facets_of_one_variable_are_wrapped(ds):
    figure = chosen(ds, variable="elastic_stress_amplitude", col="K")
    assert len(panels(figure)) == 6
    rows = {axes.get_subplotspec().rowspan.start for axes in panels(figure)}
    assert rows == {0, 1}
    assert note(figure) == ""


def test_scales_are_logarithmic_where_asked(ds):
    one = {"at": ("gamma=0", "K=3000"), "variable": "elastic_stress_amplitude"}
    (axes,) = panels(chosen(ds, log="x,z", **one))
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    (axes,) = panels(chosen(ds, **one))
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "linear")
    figure = chosen(ds, x="T", y="K", at=("gamma=0",), log="z")
    assert [bar.get_yscale() for bar in figure.axes[2:]] == ["log", "log"]


def test_kinds_beside_a_curve_have_their_names():
    kinds = np.where(TEMPERATURES < 250.0, 2, 0).astype("i1")
    ds = sweep(temperature=TEMPERATURES).assign(regime=("temperature", kinds))
    _, axes = panels(chosen(ds, variable=("F_max", "regime")))
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert (axes.get_yticks().tolist(), names) == ([0, 2], ["liquid", "stick-slip,\nsymmetric"])
    above, below = panels(chosen(ds, variable=("F_max", "regime"), log="z"))
    assert (above.get_yscale(), below.get_yscale()) == ("log", "linear")


MEASURED = read_data({"T": [200.0], "F_max": [3e-3]})


@pytest.mark.parametrize(
    ("axes", "options", "message"),
    [
        ({"temperature": TEMPERATURES}, {"variable": "melting_count", "log": "y"}, "no vertical"),
        ({"temperature": TEMPERATURES}, {"variable": "melting_count", "log": "z"}, "have no scale"),
        (
            {"temperature": TEMPERATURES, "rheological_index": [0.2, 0.5]},
            {"variable": "melting_count", "log": "y"},
            "points of rheological_index have names here",
        ),
        (
            {"temperature": TEMPERATURES},
            {"variable": "sigma_el,max", "data": MEASURED},
            "the data are for friction_force_amplitude, but this picture shows elastic_stress",
        ),
        ({}, {"x": "T"}, "it is a single point and has no axes"),
        ({}, {"hue": "T"}, "it is a single point and has no axes"),
        ({}, {"log": "z"}, "a single point is drawn as a table; leave out log"),
        ({}, {"data": MEASURED}, "a single point is drawn as a table; leave out data"),
        ({"temperature": TEMPERATURES}, {"look": Look(clim=(0.0, 1.0))}, "no colour scale"),
        (
            {"temperature": TEMPERATURES},
            {"variable": "melting_count", "look": Look(clim=(0.0, None))},
            "no colour scale",
        ),
        ({}, {"look": Look(xlim=(0.0, 1.0))}, "xlim does not apply: this picture has no axes"),
    ],
)
def test_an_option_without_effect_is_refused(axes, options, message):
    with pytest.raises(ValueError, match=message):
        chosen(sweep(**axes), **options)


def test_values_without_a_logarithm_are_counted(ds):
    ds["elastic_stress_amplitude"][:4] = 0.0
    one = ("gamma=0", "K=3000")
    figure = chosen(ds, variable="elastic_stress_amplitude", at=one, log="z")
    assert "is not above 0 at 4 points: not drawn." in note(figure)


def test_a_linked_parameter_can_be_the_axis():
    cases = linked(sweep(case=np.arange(9)))
    assert panels(chosen(cases, x="omega"))[1].get_xlabel() == (
        r"$\omega$ (rad/s), linked with $X_m$"
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"variable": "regme"}, r"unknown variable 'regme' \(did you mean 'regime'\?\)"),
        ({"variable": "F"}, r"unknown variable 'F' \(did you mean 'F_max'\?\)"),
        ({"variable": "sigma"}, r"unknown variable 'sigma' \(did you mean 'sigma_el,max'\?\)"),
        ({"variable": "regime"}, "this result lacks regime: it was left out"),
        ({"x": "temprature"}, r"unknown axis 'temprature' \(did you mean 'temperature'\?\)"),
        ({"x": "M"}, r"block_mass is 0.4 throughout this file; its axes are temperature \(T\)"),
        ({"x": "T", "hue": "temperature"}, "temperature is both x and hue"),
        ({"y": "T", "hue": "K"}, "choose one of them"),
        ({"at": ("T",)}, "'T' must be KEY=VALUE"),
        ({"at": ("T=warm",)}, "'T=warm': must be a number, not 'warm'"),
        ({"at": ("T=2_00",)}, "must be a number, not '2_00'; write it without underscores"),
        ({"at": ("T=1/0",)}, "'T=1/0': must be a number, but '1/0' divides by zero"),
        ({"at": ("T=.nan",)}, "must be a finite number"),
        ({"at": ("T=200", "temperature=250")}, "several points write temperature=180,220,300"),
        ({"at": ("T=180,200", "T=220,240")}, "'T=220,240' slices temperature a second time"),
        ({"at": ("T=180,200", "temperature=200")}, "'temperature=200' slices temperature a second"),
        ({"at": ("T=200", "T=180,200")}, "'T=200' slices temperature a second time"),
        ({"log": "w"}, "log scales are x, y and z"),
        ({"log": "x", "x": "gamma"}, "needs numbers above 0"),
    ],
)
def test_a_bad_choice_is_refused_with_the_remedy(ds, options, words):
    with pytest.raises(ValueError, match=words):
        chosen(ds, **options)


def test_a_slice_of_words_is_refused_with_the_words():
    both = sweep(temperature=TEMPERATURES).expand_dims(direction=["up", "down"])
    with pytest.raises(ValueError, match="'direction=left': the values are up and down"):
        chosen(both, at=("direction=left",))


def test_variables_of_a_trajectory_choose_panels_of_its_courses():
    ds = trajectory()
    (axes,) = panels(chosen(ds, variable="F"))
    assert axes.get_ylabel() == "$F$ (mN)"
    assert len(curves(axes)) == 1
    figure = chosen(ds, variable=("lower_velocity", "upper_velocity", "viscous_stress"))
    assert [len(curves(axes)) for axes in panels(figure)] == [2, 1]
    assert len(legend_of(figure)) == 2
    mine = Figure().subplots()
    assert ds.stickslip.plot("friction_force", ax=mine) is mine
    assert len(curves(mine)) == 1
    assert note(chosen(portraits(), variable="F", at=("omega=15",))) == r"At $\omega = 15$ rad/s."
    with pytest.raises(ValueError, match=r"'friction' of a trajectory \(did you mean 'friction_fo"):
        chosen(ds, variable="friction")


@pytest.mark.parametrize(
    ("ds", "options", "words"),
    [
        (trajectory(), {"x": "T"}, "holds a trajectory, .* a variable or a figure.*: 'time_cour"),
        (fitted(), {"variable": "F_max"}, "holds a fit, .* choose a figure by name: 'fit'"),
        (
            fitted(),
            {"data": read_data({"T": [200.0], "F_max": [3e-3]})},
            "of a fit shows the fitted data; leave out data .`stickslip plot FILE --figure fit`",
        ),
    ],
)
def test_only_a_sweep_has_axes_to_choose(ds, options, words):
    with pytest.raises(ValueError, match=words):
        chosen(ds, **options)


def test_a_figure_by_name_takes_no_variable():
    with pytest.raises(ValueError, match="figure draws a whole picture"):
        draw(trajectory(), "time_courses", PlotOptions("friction_force"))


def test_a_variable_of_the_user_has_its_name_and_unit(ds):
    ds = ds.sel(spring_stiffness=STIFFNESS[0]).isel(rheological_index=0)
    force = ds.friction_force_amplitude
    force.attrs |= RESULTS["friction_force_amplitude"].attributes  # handed on by xarray or not
    power = (force * 2).assign_attrs(force.attrs | {"units": "W", "long_name": "lost power"})
    own = ds.assign(mu=(force / 0.01).assign_attrs(force.attrs), n=2 * ds.melting_count, lost=power)
    figure = chosen(own, variable=("mu", "n", "lost"))
    labels = [axes.get_ylabel() for axes in panels(figure)]
    assert labels == ["mu", "n", "lost power (W)"]
    drawn = [curves(axes)[0].get_ydata()[0] for axes in panels(figure)]
    np.testing.assert_allclose(drawn, [0.4768, 8.0, 2 * 4.768e-3])
    with pytest.raises(ValueError, match=r"unknown variable 'm'.*mu"):
        chosen(own.drop_vars("n"), variable="m")
    with pytest.raises(ValueError, match="unknown variable 'words'"):
        chosen(own.assign(words=force.astype(str)), variable="words")


def test_a_map_of_a_variable_of_the_user(ds):
    ds = ds.isel(rheological_index=0)
    own = ds.assign(mu=(ds.friction_force_amplitude / 0.01).drop_attrs())
    figure = chosen(own, variable="mu", x="T", y="K")
    (mesh,) = (mesh for mesh in panels(figure)[0].collections if isinstance(mesh, QuadMesh))
    np.testing.assert_allclose(mesh.get_array(), 0.4768)


def test_a_variable_of_the_user_may_have_its_axes_in_another_order(ds):
    ds = ds.isel(rheological_index=0, temperature=[0, 1, 2])
    ds.status[0, 1] = Status.DIVERGED
    own = ds.assign(speed=ds.spring_stiffness * ds.friction_force_amplitude)
    assert own.speed.dims != own.status.dims
    figure = chosen(own, variable="speed", x="T", y="K")
    assert note(figure).startswith("Grey: 1 of 18 points missing (1 diverged)")


@pytest.mark.parametrize("count", [4, 7])
def test_many_variables_leave_room_for_one_row_of_panels_each(ds, count):
    ds = ds.isel(rheological_index=0)
    own = ds.assign({f"own {i}": (i + 1) * ds.elastic_stress_amplitude for i in range(count)})
    names = tuple(f"own {i}" for i in range(count))
    figure = chosen(own, variable=names, x="T", row="K")
    assert len(panels(figure)) == count
    stiffness = own.spring_stiffness.size
    assert f"1 of {stiffness} values of $K$ are drawn." in note(figure)


@pytest.mark.parametrize("role", ["hue", "row", "col"])
def test_a_stack_without_a_coordinate_has_numbers(ds, role):
    ds = ds.isel(spring_stiffness=0, rheological_index=0)
    stack = xr.concat([ds, ds * 2], "film", combine_attrs="override").drop_vars("spring_stiffness")
    figure = chosen(stack, variable="F_max", **{role: "film"})
    texts = {
        "hue": lambda: legend_of(figure),
        "row": lambda: [axes.get_ylabel().split("\n")[0] for axes in panels(figure)],
        "col": lambda: [axes.get_title() for axes in panels(figure)],
    }
    assert texts[role]() == ["film $0$", "film $1$"]
    (one,) = panels(chosen(stack, variable="F_max", at=("film=1",)))
    np.testing.assert_allclose(curves(one)[0].get_ydata(), 2 * 4.768)
