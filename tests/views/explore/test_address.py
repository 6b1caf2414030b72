"""The end of the page's address says which point is open, and opens it again."""

from __future__ import annotations

import pytest
import xarray as xr

pytest.importorskip("bokeh", reason="bokeh is not installed")
from stickslip import Parameters
from sweeps.config.load import ConfigError, from_mapping
from sweeps.points import PointError
from sweeps.views.explore.address import opened_by, parts_of, read, under, within, written
from sweeps.views.explore.beginning import lone, open_point, with_parameters


def test_a_point_between_those_of_a_file():
    config = from_mapping({"integrator": {"rtol": 1e-8}, "film": {"strain": "relaxing"}})
    parameters = Parameters(temperature=1 / 3, rheological_index=-0.1, film_thickness=1.7e-9)
    opened = lone(with_parameters(config, parameters))
    parts = read("#" + written(parts_of(opened, None)))
    again = opened_by(parts, None)
    assert again.point.parameters == parameters
    assert (again.config.integrator, again.config.film) == (config.integrator, config.film)


def test_a_point_of_a_file(result: xr.Dataset):
    opened = open_point(result, {"temperature": 2, "spring_stiffness": 7})
    parts = parts_of(opened, result)
    assert parts["at.temperature"] == "230"
    again = opened_by(read(written(parts)), result)
    assert again.place == opened.place
    assert again.point.parameters == opened.point.parameters


def test_parts_with_a_prefix_are_no_part_of_the_point():
    parts = {"T": "250"} | under("kept.", {"T": "230"}) | under("chart.", {"variable": "regime"})
    assert opened_by(parts, None).point.parameters == Parameters(temperature=250)
    assert within(parts, "kept.") == {"T": "230"}


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"temprature": "1"}, "temprature is neither a parameter nor a setting"),
        ({"drive.table": "secret.csv"}, "drive.table is neither a parameter nor a setting"),
        ({"output": "a.nc"}, "output is neither"),
        ({"T": "[200, 250]"}, "an address has one value of each parameter"),
        ({"at.temperature": "250"}, "at.spring_stiffness is missing"),
        ({"at.temperature": "9000", "at.spring_stiffness": "500"}, "goes from 210 to 290"),
    ],
)
def test_what_it_refuses(parts: dict[str, str], message: str, result: xr.Dataset):
    with pytest.raises(PointError, match=message.replace("[", r"\[")):
        opened_by(parts, result)


@pytest.mark.parametrize("parts", [{"T": "-5"}, {"T": "warm"}, {"integrator.rtol": "2"}])
def test_values_are_judged_as_in_a_config(parts: dict[str, str]):
    with pytest.raises(ConfigError):
        opened_by(parts, None)
