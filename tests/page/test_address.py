"""The end of the page's address says which point is open, and opens it again."""

from __future__ import annotations

import pytest
import xarray as xr

from stickslip import Parameters
from sweeps.config.load import ConfigError, from_mapping
from sweeps.page.subject import changes_of, place_of, point_alone, point_of_address, point_of_result
from sweeps.points import PointError


def test_a_point_between_those_of_a_file():
    config = from_mapping({"integrator": {"rtol": 1e-8}, "film": {"strain": "relaxing"}})
    parameters = Parameters(temperature=1 / 3, rheological_index=-0.1, film_thickness=1.7e-9)
    shown_point = point_alone(config, parameters)
    assert place_of(shown_point, None) is None
    again = point_of_address(changes_of(shown_point), None)
    assert again.point.parameters == parameters
    assert (again.config.integrator, again.config.film) == (config.integrator, config.film)


def test_a_point_of_a_file(result: xr.Dataset):
    shown_point = point_of_result(result, {"temperature": 2, "spring_stiffness": 7})
    parts = place_of(shown_point, result)
    assert parts is not None
    assert parts["at.temperature"] == "230"
    again = point_of_address(parts, result)
    assert again.place == shown_point.place
    assert again.point.parameters == shown_point.point.parameters


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
        point_of_address(parts, result)


@pytest.mark.parametrize("parts", [{"T": "-5"}, {"T": "warm"}, {"integrator.rtol": "2"}])
def test_values_are_judged_as_in_a_config(parts: dict[str, str]):
    with pytest.raises(ConfigError):
        point_of_address(parts, None)
