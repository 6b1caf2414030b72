"""The charts of a page, and the numbers with which its script fills them."""

from __future__ import annotations

import numpy as np
import pytest
from support.pictures import TEMPERATURES, described, sweep

pytest.importorskip("bokeh", reason="bokeh is not installed")
import xarray as xr

from sweeps.page.script_data import variables_of
from sweeps.page.sheets import View, colour_mappers, ordered, sheets_of

BORDERS = described(
    xr.Dataset(
        {
            name: ("boundary_point", np.zeros(2, dtype="i1"))
            for name in ("kind_left", "kind_right", "type")
        },
        {
            "line": ("boundary_point", [0, 0]),
            "temperature": ("boundary_point", [200.0, 210.0]),
            "rheological_index": ("boundary_point", [-0.2, 0.3]),
        },
    )
)


def test_a_map_with_borders_has_no_names_on_its_axes():
    few = sweep(temperature=TEMPERATURES, rheological_index=[0.5, 0.0, -0.25])
    rulers = []
    for borders in (None, BORDERS):
        ds = ordered(few, named=borders is None)
        variables, view = variables_of(ds), View("map", "temperature", "rheological_index")
        _, about = dict(sheets_of(ds, view, variables, colour_mappers(), borders))["linear"]
        rulers.append(about["y"]["places"])
    assert rulers == [[0.0, 1.0, 2.0], [-0.25, 0.0, 0.5]]
    assert ds["rheological_index"].values.tolist() == rulers[1]
