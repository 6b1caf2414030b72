"""The chart of a result on the page: where it has borders, and what it says where it has none."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from support.pictures import described, sweep

pytest.importorskip("bokeh", reason="bokeh is not installed")
from sweeps.views.explore.chart_view import ChartView

T, OMEGA = np.linspace(150.0, 320.0, 12), np.linspace(5.0, 60.0, 10)


@pytest.fixture
def view() -> ChartView:
    ds = sweep(temperature=T, angular_frequency=OMEGA, spring_stiffness=[2000.0, 3000.0])
    along = {"temperature": [200.0, 210.0], "angular_frequency": [10.0, 20.0], "line": [0, 0]}
    data = {f"{name}_bracket": [0.0, 0.0] for name in ("temperature", "angular_frequency")}
    data |= {"kind_left": [2, 2], "kind_right": [0, 0], "type": [1, 1]}
    borders = xr.Dataset(
        *({name: ("boundary_point", v) for name, v in some.items()} for some in (data, along))
    )
    borders = described(borders.assign_coords(spring_stiffness=3000.0))
    return ChartView(ds, lambda _: None, borders)


def lines(view: ChartView) -> int:
    return len(list(view.column.select({"name": "borders fold"})))


def test_borders_are_drawn_at_their_values_alone(view: ChartView) -> None:
    assert (lines(view), view.message.text) == (1, "")
    view.sliders["spring_stiffness"].value = 0
    assert lines(view) == 0
    assert view.message.text == "No borders: these are the borders at K = 3000 N/m, not here."
    view.sliders["spring_stiffness"].value = 1
    view.across.value, view.up.value = "spring_stiffness", "temperature"
    assert lines(view) == 0
    assert view.message.text == "The borders lie over temperature and angular_frequency."


def test_what_is_chosen_is_chosen_again(view: ChartView) -> None:
    assert view.parts() == {"spring_stiffness": "3000"}
    view.sliders["spring_stiffness"].value = 0
    view.variable.value, view.across.value = "friction_force_amplitude", "angular_frequency"
    view.log.active = [0]
    parts = view.parts()
    assert parts == {
        "variable": "friction_force_amplitude",
        "across": "angular_frequency",
        "logarithmic": "yes",
        "spring_stiffness": "2000",
    }
    view.restore({})
    assert view.parts() == {"spring_stiffness": "2000"}
    view.restore(parts | {"upward": "nothing of the kind", "temperature": "odd"})
    assert view.parts() == parts
