"""Borders on maps of the pages: their lines, their legend, and what the pointer shows."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from support.pictures import described, sweep

from sweeps.charts.chart import chart_of
from sweeps.charts.choice import Choice

pytest.importorskip("bokeh", reason="bokeh is not installed")
from bokeh.models import HoverTool, LinearColorMapper

from sweeps.page.drawing import add_borders, draw

STRESS = "elastic_stress_amplitude"
T, OMEGA = np.linspace(150.0, 320.0, 12), np.linspace(5.0, 60.0, 10)
GRAZING, FOLD, MEETING = 0, 1, 2

# Line 0 is a grazing, then a fold up to where it meets others; line 1 a fold; line 2 a point.
LINES = [0, 0, 0, 0, 0, 1, 1, 2]
TYPES = [GRAZING, GRAZING, FOLD, FOLD, MEETING, FOLD, FOLD, FOLD]
PLACES = np.column_stack([np.linspace(160.0, 300.0, 8), np.linspace(6.0, 50.0, 8)])


def borders_of(**more: list[int]) -> xr.Dataset:
    data = {"kind_left": [2] * 8, "kind_right": [2] * 5 + [0] * 3, "type": TYPES, **more}
    data |= dict.fromkeys(("temperature_bracket", "angular_frequency_bracket"), [0.0] * 8)
    coords = {"line": LINES, "temperature": PLACES[:, 0], "angular_frequency": PLACES[:, 1]}
    along = [{name: ("boundary_point", v) for name, v in some.items()} for some in (data, coords)]
    return described(xr.Dataset(*along))


def drawn_with(borders: xr.Dataset, across: str | None = None, up: str | None = None):
    chart = chart_of(sweep(temperature=T, angular_frequency=OMEGA), Choice(STRESS, across, up))
    drawn = draw(chart, 300, LinearColorMapper())
    before = len(drawn.renderers)
    add_borders(drawn, chart, borders)
    return drawn, {shape.name: shape for shape in drawn.renderers[before:]}


def lines_in(shape):
    data = shape.data_source.data
    pairs = zip(data["x"], data["y"], strict=True)
    return [np.column_stack(pair) for pair in pairs]


@pytest.mark.parametrize("turned", [False, True])
def test_lines_are_divided_where_their_type_changes(turned):
    axes = ("angular_frequency", "temperature") if turned else ("temperature", "angular_frequency")
    _, shapes = drawn_with(borders_of(), *axes)
    places = PLACES[:, ::-1] if turned else PLACES
    wanted = {"borders grazing": [places[:3]], "borders fold": [places[2:5], places[5:7]]}
    assert set(shapes) == set(wanted)
    for name, lines in wanted.items():
        np.testing.assert_equal(lines_in(shapes[name]), lines)


def test_a_legend_hides_them_and_the_pointer_names_them():
    drawn, shapes = drawn_with(borders_of())
    legend = drawn.legend[-1]
    assert legend.click_policy == "hide"
    assert [item.label.value for item in legend.items] == ["border: grazing", "border: fold"]
    assert [item.renderers for item in legend.items] == [[shape] for shape in shapes.values()]
    (hover,) = (tool for tool in drawn.select(HoverTool) if tool.line_policy == "interp")
    assert hover.renderers == list(shapes.values())
    assert hover.tooltips == [("between", "@between"), ("border", "@type")]
    data = shapes["borders fold"].data_source.data
    symmetric = "stick-slip, symmetric"
    assert data["between"] == [f"{symmetric} | {symmetric}", f"{symmetric} | liquid"]
    assert data["type"] == ["fold", "fold"]


def test_borders_of_counts_name_the_counts():
    counts = {"orbit_periods_left": [1] * 8, "orbit_periods_right": [2] * 8}
    _, shapes = drawn_with(borders_of(**counts))
    (words,) = shapes["borders grazing"].data_source.data["between"]
    before, after = (f"stick-slip, symmetric, orbit periods {count}" for count in (1, 2))
    assert words == f"{before} | {after}"


def test_single_points_are_not_lines():
    drawn, shapes = drawn_with(borders_of().isel(boundary_point=[7]))
    assert not shapes
    assert not drawn.legend
