"""Borders on maps: where they are drawn, and where they are refused."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from support.pictures import TEMPERATURES, described, legend_of, panels, sweep

from sweeps.figures import PlotOptions, draw

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
def test_lines_are_drawn_in_the_order_of_the_axes(ds, turned):
    x, y = ("omega", "T") if turned else ("T", "omega")
    options = PlotOptions("regime", x=x, y=y, boundaries=borders_of(spring_stiffness=3000.0))
    (axes,) = panels(draw(ds, options=options))
    (drawn,) = lines_on(axes)  # and no lines between pixels
    points = POINTS[:, ::-1] if turned else POINTS
    paths = [path.vertices for path in drawn.get_paths()]
    assert [len(path) for path in paths] == [3, 2]
    np.testing.assert_array_equal(np.concatenate(paths), points[:5])
    assert not drawn.get_rasterized()


def test_grazing_and_folds_are_told_apart(ds):
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


def test_without_them_pixels_are_parted_as_before(ds):
    (axes,) = panels(draw(ds, options=PlotOptions("regime")))
    (between,) = lines_on(axes)
    assert len(between.get_paths()) == SPEEDS.size


def test_both_amplitudes_have_them(ds):
    figure = draw(ds, options=PlotOptions(boundaries=borders_of()))
    assert [len(lines_on(axes)) for axes in panels(figure)[:2]] == [1, 1]


def test_only_panels_of_their_values_have_them(ds):
    both = xr.concat([ds, ds], dim="spring_stiffness", combine_attrs="override")
    both = described(both.assign_coords(spring_stiffness=[2000.0, 3000.0]))
    options = PlotOptions("regime", boundaries=borders_of(spring_stiffness=3000.0))
    drawn = [len(lines_on(axes)) for axes in panels(draw(both, options=options))[:2]]
    assert drawn == [0, 1]


@pytest.mark.parametrize(
    ("options", "borders", "told"),
    [
        ({"variable": "regime"}, borders_of(spring_stiffness=1000.0), "the borders at .*K = 1000"),
        ({"variable": "regime"}, xr.Dataset(), "no file of borders"),
        ({"variable": "regime", "at": ("omega=10",)}, borders_of(), "borders over temperature and"),
        ({"hue": "omega", "at": ("omega=10,20,30",)}, borders_of(), "on maps: name the axis -y"),
        (
            {"variable": "regime"},
            borders_of().drop_vars("temperature_bracket"),
            "these are points along angular_frequency",
        ),
    ],
)
def test_other_borders_are_refused(ds, options, borders, told):
    with pytest.raises(ValueError, match=told):
        draw(ds, options=PlotOptions(**options, boundaries=borders))


def test_borders_alone_are_no_figure():
    with pytest.raises(ValueError, match="are drawn over their map: give the file of the map"):
        draw(borders_of())
