"""The subject of a page: the paper, a config or a result; its points as texts and addresses."""

from __future__ import annotations

import itertools
import shlex
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from support import messages
from support.pictures import sweep

from stickslip import Parameters
from stickslip.variables import PARAMETERS
from sweeps import run
from sweeps.config.load import Config, ConfigError, from_mapping, from_yaml
from sweeps.engine.settings import options_of
from sweeps.page.controls import Scale
from sweeps.page.subject import (
    changes_of,
    command_text,
    config_text,
    place_of,
    point_alone,
    point_of_address,
    point_of_result,
    subject_of_config,
    subject_of_paper,
    subject_of_result,
)
from sweeps.points import PointError


def test_the_paper_gives_its_point():
    subject = subject_of_paper()
    assert subject.first.point.parameters == Parameters()
    assert subject.first.label == "the paper's values"
    assert subject.result is None
    assert list(subject.scales) == list(PARAMETERS)


def test_a_config_gives_values_and_ranges():
    config = from_mapping(
        {
            "model": {"block_mass": 0.5},
            "sweep": {"temperature": [150, 200, 300]},
            "cases": {"drive_amplitude": [4e-7, 8e-7], "angular_frequency": [20, 10]},
            "integrator": {"rtol": 1e-8},
            "simulation": {"periods": 3},
        }
    )
    subject = subject_of_config(config, "a.yaml")
    expected = Parameters(
        block_mass=0.5, temperature=200, drive_amplitude=4e-7, angular_frequency=20
    )
    assert subject.first.point.parameters == expected
    assert subject.scales["temperature"] == Scale(150.0, 300.0)
    assert (subject.scales["drive_amplitude"].lower, subject.name) == (4e-7, "a.yaml")
    assert subject.first.config.integrator.rtol == 1e-8
    assert subject.first.point.simulate(samples_per_period=10).sizes["elapsed_time"] == 11


def test_a_schedule_is_left_out():
    config = from_mapping({"simulation": {"schedule": {"temperature": [200, 300]}}})
    subject = subject_of_config(config, "a.yaml")
    assert subject.first.config.simulation.schedule is None


def test_another_method_is_replaced_with_a_note():
    config = from_mapping({"integrator": {"method": "euler-cromer", "dt": 1e-9}})
    subject = subject_of_config(config, "a.yaml")
    assert subject.first.config.integrator.method == "adaptive"
    assert subject.notes == ("This page computes with the method adaptive, not with euler-cromer.",)


def test_a_result_opens_in_its_middle(result: xr.Dataset):
    subject = subject_of_result(result, "a.nc", ("a note",))
    assert subject.first.place == {"temperature": 4, "spring_stiffness": 4}
    stiffness = result.spring_stiffness.values[4]
    expected = Parameters(temperature=250, spring_stiffness=stiffness)
    assert subject.first.point.parameters == expected
    assert subject.first.label == "T = 250 K, K = 2000 N/m"
    assert subject.scales["temperature"] == Scale(210.0, 290.0)
    assert subject.scales["spring_stiffness"].logarithmic
    assert subject.notes == ("a note",)
    assert subject.result is result


def test_a_fit_opens_on_its_curve(result: xr.Dataset):
    """Its data and free parameters have other dimensions."""
    curve = result.isel(spring_stiffness=4)
    fitted = curve.assign(
        fitted_value=("datum", np.ones(3)), parameter_value=("free_parameter", np.ones(2))
    )
    subject = subject_of_result(fitted, "fit.nc")
    assert subject.first.place == {"temperature": 4}
    assert subject.first.point.parameters.temperature == 250
    assert dict(subject.result.sizes) == {"temperature": 9}


def test_a_single_point_has_no_chart():
    alone = run({"model": {"temperature": 250}, "integrator": {"rtol": 1e-4}})
    subject = subject_of_result(alone, "a.nc")
    assert subject.result is None
    assert subject.first.point.parameters == Parameters(temperature=250)


def test_a_stack_without_a_coordinate_opens_by_numbers(result):
    bare = xr.concat([result] * 2, "film")
    first = subject_of_result(bare, "a.nc").first
    assert first.label == "film 1, T = 250 K, K = 2000 N/m"
    assert first.point.loose


def test_a_stack_of_another_method_is_refused():
    """The page computes with another method, so its numbers do not reveal the settings."""
    integrator = {"method": "euler-cromer", "dt": 1e-7}
    quick = {"integrator": integrator, "stationary": {"rtol": 1e-3, "max_periods": 3}}
    one = run(quick | {"sweep": {"temperature": [250.0, 300.0]}})
    assert subject_of_result(one, "a.nc").notes
    with pytest.raises(PointError, match="a stack, and this page computes with the method adapt"):
        subject_of_result(xr.concat([one] * 2, "film"), "a.nc")


def test_another_dataset_is_refused():
    with pytest.raises(PointError, match=messages.NO_RESULT):
        subject_of_result(xr.Dataset({"x": ("t", np.zeros(3))}), "a.nc")


# --- a point as text to copy ----------------------------------------------------------------------

ODD = Parameters(
    temperature=1730 / 7,
    rheological_index=2 / 3,
    drive_amplitude=-0.4e-6,
    viscosity_coefficient=12345.678901234567,
)


def point(config: Config | None = None, parameters: Parameters = ODD):
    return point_alone(config or from_mapping({}), parameters)


def changed() -> Config:
    """Return a config with all settings of the page changed."""
    settings = ("integrator.rtol=1e-8", "stationary.rtol=1e-8", "noise.treatment=none")
    return from_mapping({"model": {"initial_order_parameter": 0.5}}, overrides=list(settings))


def of_command(text: str) -> Config:
    """Return the config of a command."""
    words = shlex.split(text)
    assert words[:2] == ["stickslip", "simulate"]
    sets = [after for word, after in itertools.pairwise(words) if word == "--set"]
    periods = words[words.index("--periods") + 1]
    return from_yaml("{}", overrides=[*sets, f"simulation.periods={periods}"])


@pytest.mark.parametrize("parameters", [Parameters(), ODD])
@pytest.mark.parametrize("settings", [None, changed()], ids=["usual", "changed"])
def test_both_texts_give_the_same_numbers(parameters: Parameters, settings: Config | None):
    if settings:
        parameters = parameters._replace(initial_order_parameter=0.5)
    shown_point = point(settings, parameters)
    written, command = config_text(shown_point, 3), command_text(shown_point, 3)
    for config in (from_yaml(written), of_command(command)):
        assert config.parameters() == parameters
        assert options_of(config) == options_of(shown_point.config)
        assert config.simulation.periods == 3
        assert config.simulation.start == "stationary"


def test_the_texts_of_the_papers_point_are_short():
    point = subject_of_paper().first
    command = "stickslip simulate --set simulation.start=stationary --periods 1"
    assert command_text(point) == command
    assert config_text(point).startswith("model: {}\n")


def test_a_remark_says_that_a_followed_point_starts_from_its_neighbour():
    line = run({"sweep": {"omega": [10, 11]}, "follow": "omega", "integrator": {"rtol": 1e-4}})
    first = point_of_result(line, {"angular_frequency": 0, "direction": 0})
    second = point_of_result(line, {"angular_frequency": 1, "direction": 0})
    assert "neighbour" not in config_text(first)
    for text in (config_text(second), command_text(second)):
        assert text.startswith("# In the file this point starts from")
    assert "#" not in command_text(first)
    *_, command = command_text(second).splitlines()
    assert of_command(command).parameters() == Parameters(angular_frequency=11)
    assert from_yaml(config_text(second)).parameters() == Parameters(angular_frequency=11)


# --- a point as the end of an address -------------------------------------------------------------


def test_a_point_outside_the_file():
    config = from_mapping({"integrator": {"rtol": 1e-8}, "film": {"strain": "relaxing"}})
    parameters = Parameters(temperature=1 / 3, rheological_index=-0.1, film_thickness=1.7e-9)
    shown_point = point_alone(config, parameters)
    assert place_of(shown_point, None) is None
    again = point_of_address(changes_of(shown_point), None)
    assert again.point.parameters == parameters
    assert (again.config.integrator, again.config.film) == (config.integrator, config.film)


@pytest.mark.parametrize(("window", "named"), [(None, {}), (200, {"stationary.window": "200"})])
def test_the_window_of_a_stochastic_film_is_named_unless_it_is_its_default(
    window: int | None, named: dict[str, str]
):
    """Its default is 32, not 200: 200 was lost, and 32 stayed when the noise was changed back."""
    written = {} if window is None else {"stationary": {"window": window}}
    config = from_mapping({"noise": {"treatment": "stochastic"}} | written)
    point = point_alone(config, config.parameters())
    changes = changes_of(point)
    assert {key: changes[key] for key in changes if key.startswith("stationary.")} == named
    assert from_yaml(config_text(point)).stationary == config.stationary


def test_a_point_of_a_file(result: xr.Dataset):
    shown_point = point_of_result(result, {"temperature": 2, "spring_stiffness": 7})
    parts = place_of(shown_point, result)
    assert parts is not None
    assert parts["at.temperature"] == "230"
    again = point_of_address(parts, result)
    assert again.place == shown_point.place
    assert again.point.parameters == shown_point.point.parameters


def test_the_place_of_a_point_is_in_decimals_which_the_script_reads():
    thirds = sweep(temperature=[200.0, 250.0], rheological_index=[-2 / 3, -1 / 3, 0.0])
    for at, text in enumerate(("-0.6666666666666666", "-0.3333333333333333", "0")):
        shown_point = replace(subject_of_paper().first, place={"rheological_index": at})
        assert place_of(shown_point, thirds) == {"at.rheological_index": text}


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"temprature": "1"}, "temprature is neither a parameter nor a setting"),
        ({"drive.table": "secret.csv"}, "drive.table is neither a parameter nor a setting"),
        ({"output": "a.nc"}, "output is neither"),
        ({"T": "[200, 250]"}, "an address must have a single value for each parameter"),
        ({"at.temperature": "250"}, "at.spring_stiffness is missing"),
        ({"at.temperature": "9000", "at.spring_stiffness": "500"}, "goes from 210 to 290"),
    ],
)
def test_an_impossible_address_is_refused(parts: dict[str, str], message: str, result: xr.Dataset):
    with pytest.raises(PointError, match=message.replace("[", r"\[")):
        point_of_address(parts, result)


@pytest.mark.parametrize("parts", [{"T": "-5"}, {"T": "warm"}, {"integrator.rtol": "2"}])
def test_values_are_judged_as_in_a_config(parts: dict[str, str]):
    with pytest.raises(ConfigError):
        point_of_address(parts, None)
