"""The texts to copy ask for the point that is shown."""

from __future__ import annotations

import itertools
import shlex

import pytest

from stickslip import Parameters
from sweeps.config.load import Config, from_mapping, from_yaml
from sweeps.engine.settings import options_of
from sweeps.page.subject import (
    command_text,
    config_text,
    point_alone,
    point_of_result,
    subject_of_paper,
)

ODD = Parameters(
    temperature=1730 / 7,
    rheological_index=2 / 3,
    drive_amplitude=-0.4e-6,
    viscosity_coefficient=12345.678901234567,
)


def point(config: Config | None = None, parameters: Parameters = ODD):
    return point_alone(config or from_mapping({}), parameters)


def changed() -> Config:
    """A config with all settings of the page changed."""
    settings = ("integrator.rtol=1e-8", "stationary.rtol=1e-8", "noise.treatment=none")
    return from_mapping({"model": {"initial_order_parameter": 0.5}}, overrides=list(settings))


def of_command(text: str) -> Config:
    """The config that a command asks for."""
    words = shlex.split(text)
    assert words[:2] == ["stickslip", "simulate"]
    sets = [after for word, after in itertools.pairwise(words) if word == "--set"]
    periods = words[words.index("--periods") + 1]
    return from_yaml("{}", overrides=[*sets, f"simulation.periods={periods}"])


@pytest.mark.parametrize("parameters", [Parameters(), ODD])
@pytest.mark.parametrize("settings", [None, changed()], ids=["usual", "changed"])
def test_both_texts_ask_for_the_same_numbers(parameters: Parameters, settings: Config | None):
    if settings:
        parameters = parameters._replace(initial_order_parameter=0.5)
    shown_point = point(settings, parameters)
    for config in (
        from_yaml(config_text(shown_point, 3)),
        of_command(command_text(shown_point, 3)),
    ):
        assert config.parameters() == parameters
        assert options_of(config) == options_of(shown_point.config)
        assert config.simulation.periods == 3
        assert config.simulation.start == "stationary"


def test_the_papers_point_is_said_in_few_words():
    shown_point = subject_of_paper().first
    assert (
        command_text(shown_point)
        == "stickslip simulate --set simulation.start=stationary --periods 1"
    )
    assert config_text(shown_point).startswith("model: {}\n")


def test_a_followed_point_is_said_to_come_from_its_neighbour():
    from sweeps import run

    line = run({"sweep": {"omega": [10, 11]}, "follow": "omega", "integrator": {"rtol": 1e-4}})
    first = point_of_result(line, {"angular_frequency": 0, "direction": 0})
    second = point_of_result(line, {"angular_frequency": 1, "direction": 0})
    assert "neighbour" not in config_text(first)
    assert config_text(second).startswith("# In the file this point starts from")
    assert from_yaml(config_text(second)).parameters() == Parameters(angular_frequency=11)
