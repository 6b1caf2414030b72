"""Maps: the colours of kinds, counts and values, and borders between kinds of motion."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import to_hex, to_rgb
from support.pictures import (
    GAMMAS,
    TEMPERATURES,
    described,
    failed,
    legend_of,
    linked,
    note,
    panels,
    sweep,
)

from stickslip.regime import Regime
from stickslip.status import Status
from sweeps.charts.colours import kind_colour
from sweeps.figures import PlotOptions, draw

K = np.geomspace(1e4, 2e5, 12)
STIFFNESS = [1e3, 2e3, 3e3, 4e3]
ORANGE = "#e69f00"


def with_regimes(ds, codes):
    return described(ds.assign(regime=(ds.status.dims, np.asarray(codes, dtype="i1"))))


def mapped(ds, variable="regime"):
    figure = draw(ds, None, PlotOptions(variable=variable))
    (axes,) = panels(figure)
    (mesh,) = (drawn for drawn in axes.collections if isinstance(drawn, QuadMesh))
    return figure, axes, mesh


def cell_colours(mesh):
    mesh.update_scalarmappable()
    return np.array([to_hex(colour) for colour in mesh.get_facecolors().reshape(-1, 4)])


def test_a_map_of_regimes_names_those_that_are_there():
    ds = sweep(temperature=TEMPERATURES, viscosity_coefficient=K)
    codes = np.zeros((35, 12))
    codes[10:20] = Regime.STICK_SLIP_SYMMETRIC
    figure, _, mesh = mapped(with_regimes(ds, codes))
    assert legend_of(figure) == ["liquid", "stick-slip, symmetric"]
    orange = (cell_colours(mesh) == ORANGE).reshape(12, 35)
    np.testing.assert_array_equal(orange, codes.T == Regime.STICK_SLIP_SYMMETRIC)


def test_a_regime_keeps_its_colour_beside_other_regimes():
    ds = sweep(temperature=TEMPERATURES, viscosity_coefficient=K)
    for others in (Regime.LIQUID, Regime.APERIODIC):
        codes = np.full((35, 12), int(others))
        codes[0, 0] = Regime.STICK_SLIP_SYMMETRIC
        _, _, mesh = mapped(with_regimes(ds, codes))
        assert (cell_colours(mesh) == ORANGE).sum() == 1


def test_regimes_differ_in_a_print_without_colours():
    greys = sorted(np.dot([0.299, 0.587, 0.114], to_rgb(kind_colour("regime", r))) for r in Regime)
    assert np.diff(greys).min() > 0.04


def test_a_line_parts_regimes():
    ds = sweep(temperature=[200.0, 210.0, 220.0], viscosity_coefficient=[1e4, 2e4])
    _, axes, _ = mapped(with_regimes(ds, [[0, 0], [2, 2], [2, 0]]))
    (borders,) = (drawn for drawn in axes.collections if isinstance(drawn, LineCollection))
    assert {tuple(map(tuple, line)) for line in borders.get_segments()} == {
        ((205.0, 5e3), (205.0, 1.5e4)),
        ((205.0, 1.5e4), (205.0, 2.5e4)),
        ((215.0, 1.5e4), (215.0, 2.5e4)),
        ((215.0, 1.5e4), (225.0, 1.5e4)),
    }


def test_regimes_along_one_axis_are_a_strip_for_each_fluid():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    codes = np.tile([2, 1, 0], (35, 1))
    _, axes, mesh = mapped(with_regimes(ds, codes))
    assert mesh.get_array().shape == (3, 35)
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names[0] == "pseudoplastic,\n$\\gamma = -2/3$"
    alone, axes, mesh = mapped(with_regimes(ds, codes).isel(rheological_index=0))
    assert mesh.get_array().shape == (1, 35)
    assert axes.get_yticks().size == 0
    assert legend_of(alone) == ["stick-slip, symmetric"]


def test_a_hue_of_regimes_is_a_strip_for_each_fluid_and_never_a_map():
    ds = with_regimes(
        sweep(temperature=[200.0, 250.0], spring_stiffness=STIFFNESS), np.zeros((2, 4))
    )
    with pytest.raises(ValueError, match="use spring_stiffness as y, not as hue"):
        draw(ds, None, PlotOptions(variable="regime", x="T", hue="K"))
    ds = with_regimes(
        sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)), np.zeros((35, 3))
    )
    (axes,) = panels(draw(ds, None, PlotOptions(variable="regime", hue="gamma")))
    assert len(axes.get_yticks()) == 3


def test_points_that_would_share_a_cell_are_refused():
    ds = linked(sweep(case=np.arange(9))).drop_vars("temperature")
    ds = ds.assign_coords(temperature=("case", np.repeat([200.0, 250.0, 300.0], 3)))
    assert len(panels(draw(ds, None, PlotOptions("melting_count", x="omega")))) == 1
    with pytest.raises(ValueError, match="several points have the same temperature"):
        draw(ds, None, PlotOptions("melting_count", x="T"))
    assert len(panels(draw(ds, None, PlotOptions("F_max", x="T")))) == 1  # curves show all


def test_a_point_without_a_regime_is_grey_and_counted():
    ds = with_regimes(sweep(temperature=TEMPERATURES), np.zeros(35))
    ds["regime"][3] = Regime.UNKNOWN
    figure, _, mesh = mapped(failed(ds, Status.DIVERGED, temperature=3))
    assert legend_of(figure) == ["liquid"]
    assert np.flatnonzero(mesh.get_array().mask).tolist() == [3]
    assert note(figure) == "Grey: 1 of 35 points missing (1 diverged)"


def test_statuses_are_named_and_none_is_missing():
    ds = sweep(temperature=TEMPERATURES)
    ds["status"][:3] = [Status.DIVERGED, 9, Status.PENDING]
    figure, _, mesh = mapped(ds, "status")
    assert legend_of(figure) == ["ok", "diverged", "interpolated", "pending"]
    assert not np.ma.getmaskarray(mesh.get_array()).any()
    assert note(figure) == ""


@pytest.mark.parametrize(
    ("variable", "counts", "ticks"),
    [
        ("melting_count", [0, 2, 2, 7], ["0", "2", "7"]),
        ("orbit_periods", [0, 1, 1, 2], ["aperiodic", "1", "2"]),
    ],
)
def test_counts_have_a_colour_each_with_a_whole_number(variable, counts, ticks):
    ds = sweep(temperature=[200.0, 210.0, 220.0, 230.0])
    ds = described(ds.assign({variable: ("temperature", np.array(counts, dtype="i4"))}))
    figure, axes, mesh = mapped(ds, variable)
    (bar,) = (other for other in figure.axes if other is not axes)
    assert [label.get_text() for label in bar.get_yticklabels()] == ticks
    assert len(set(cell_colours(mesh))) == 3


def test_many_counts_are_a_curve():
    ds = sweep(temperature=TEMPERATURES)
    ds = ds.assign(periods_integrated=("temperature", np.arange(35, dtype="i4")))
    (axes,) = panels(draw(described(ds), None, PlotOptions(variable="periods_integrated")))
    assert not axes.collections
    np.testing.assert_array_equal(axes.get_lines()[0].get_ydata(), np.arange(35))


# --- borders: where they are drawn, and where they are refused ------------------------------------

SPEEDS = np.linspace(5.0, 60.0, 12)
POINTS = np.array(
    [[200.0, 10.0], [210.0, 20.0], [220.0, 15.0], [300.0, 5.0], [310.0, 6.0], [160.0, 7.0]]
)
LINES = [0, 0, 0, 1, 1, 2]  # the last is a point


def borders_of(**coordinates: float) -> xr.Dataset:
    along = dict(zip(("temperature", "angular_frequency"), POINTS.T, strict=True))
    data = {f"{name}_bracket": ("boundary_point", np.zeros(len(LINES))) for name in along}
    sides = ("kind_left", "kind_right", "type")
    data |= {name: ("boundary_point", np.zeros(len(LINES), dtype="i1")) for name in sides}
    coords = {"line": LINES} | along
    return described(
        xr.Dataset(data, {n: ("boundary_point", v) for n, v in coords.items()} | coordinates)
    )


@pytest.fixture
def ds() -> xr.Dataset:
    ds = sweep(temperature=TEMPERATURES, angular_frequency=SPEEDS)
    kinds = (ds.temperature > 250).astype("i1") + 0 * ds.angular_frequency.astype("i1")
    return ds.assign(regime=kinds.transpose("temperature", "angular_frequency"))


def lines_on(axes) -> list[LineCollection]:
    return [c for c in axes.collections if isinstance(c, LineCollection)]


@pytest.mark.parametrize("turned", [False, True])
def test_lines_follow_the_order_of_the_axes(ds, turned):
    x, y = ("omega", "T") if turned else ("T", "omega")
    options = PlotOptions("regime", x=x, y=y, boundaries=borders_of(spring_stiffness=3000.0))
    (axes,) = panels(draw(ds, options=options))
    (drawn,) = lines_on(axes)  # and no lines between pixels
    points = POINTS[:, ::-1] if turned else POINTS
    paths = [path.vertices for path in drawn.get_paths()]
    assert [len(path) for path in paths] == [3, 2]
    np.testing.assert_array_equal(np.concatenate(paths), points[:5])
    assert not drawn.get_rasterized()


def test_grazing_and_folds_differ(ds):
    borders = borders_of()
    borders["type"][:] = [0, 0, 1, 1, 1, 0]  # of the second line all; of the first line a part
    figure = draw(ds, options=PlotOptions("regime", boundaries=borders))
    (axes,) = panels(figure)
    (drawn,) = lines_on(axes)
    dashed = [pattern is not None for _, pattern in drawn.get_linestyles()]
    assert dashed == [False, True]
    assert legend_of(figure)[-2:] == ["border: grazing", "border: fold"]
    borders["type"][:] = [0, 1, 1, 0, 0, 0]
    (drawn,) = lines_on(panels(draw(ds, options=PlotOptions("regime", boundaries=borders)))[0])
    assert [len(path.vertices) for path in drawn.get_paths()] == [2, 2, 2]
    assert [pattern is not None for _, pattern in drawn.get_linestyles()] == [False, True, False]
    same = draw(ds, options=PlotOptions("regime", boundaries=borders_of()))
    assert not [label for label in legend_of(same) if "border" in label]


def test_without_borders_lines_separate_cells(ds):
    (axes,) = panels(draw(ds, options=PlotOptions("regime")))
    (between,) = lines_on(axes)
    assert len(between.get_paths()) == SPEEDS.size


def test_both_amplitudes_have_borders(ds):
    figure = draw(ds, options=PlotOptions(boundaries=borders_of()))
    assert [len(lines_on(axes)) for axes in panels(figure)[:2]] == [1, 1]


@pytest.mark.parametrize("gammas", [[-0.5, 0.0, 0.5], [0.5, 0.0, -0.5]])
def test_borders_over_an_axis_whose_points_have_names_lie_on_its_scale(ds, gammas):
    borders = borders_of().rename(
        angular_frequency="rheological_index",
        angular_frequency_bracket="rheological_index_bracket",
    )
    few = sweep(temperature=TEMPERATURES, rheological_index=gammas)
    figure = draw(few, options=PlotOptions("melting_count", boundaries=borders))
    (axes,) = panels(figure)
    (drawn,) = lines_on(axes)
    np.testing.assert_array_equal(drawn.get_paths()[0].vertices, POINTS[:3])
    assert axes.get_ylim() == (-0.75, 0.75)
    assert axes.get_ylabel() == r"$\gamma$"


def test_only_panels_with_the_parameters_of_the_borders_have_them(ds):
    both = xr.concat([ds, ds], dim="spring_stiffness", combine_attrs="override")
    both = described(both.assign_coords(spring_stiffness=[2000.0, 3000.0]))
    options = PlotOptions("regime", boundaries=borders_of(spring_stiffness=3000.0))
    drawn = [len(lines_on(axes)) for axes in panels(draw(both, options=options))[:2]]
    assert drawn == [0, 1]


@pytest.mark.parametrize(
    ("options", "borders", "message"),
    [
        (
            {"variable": "regime"},
            borders_of(spring_stiffness=1000.0),
            "these borders are at .*K = 1000",
        ),
        ({"variable": "regime"}, xr.Dataset(), "not a file of borders"),
        (
            {"variable": "regime"},
            borders_of()[["kind_left", "kind_right", "type"]],
            "not a file of borders",
        ),
        (
            {"variable": "regime", "at": ("omega=10",)},
            borders_of(),
            "borders were computed over temperature and",
        ),
        ({"hue": "omega", "at": ("omega=10,20,30",)}, borders_of(), "on maps; add an axis with -y"),
        (
            {"variable": "regime"},
            borders_of().drop_vars("temperature_bracket"),
            "these are points along angular_frequency",
        ),
    ],
)
def test_other_borders_are_refused(ds, options, borders, message):
    with pytest.raises(ValueError, match=message):
        draw(ds, options=PlotOptions(**options, boundaries=borders))


def test_a_single_point_of_borders_belongs_to_its_map(ds):
    alone = borders_of().isel(boundary_point=[4])  # between points of the map
    (axes,) = panels(draw(ds, options=PlotOptions("regime", boundaries=alone)))
    assert not any(len(lines.get_segments()) for lines in lines_on(axes))


def test_borders_alone_are_no_figure():
    with pytest.raises(ValueError, match="are drawn over their map; plot the file of the map"):
        draw(borders_of())
    with pytest.raises(ValueError, match="are drawn over their map; plot the file of the map"):
        draw(borders_of(), options=PlotOptions("F_max"))
