"""Sliders: their ranges and steps; numbers as boxes show them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.variables import PARAMETERS
from sweeps.config.load import ConfigError, from_mapping
from sweeps.page.controls import (
    Scale,
    complaint_of,
    controls_html,
    exact_text,
    read_number,
    scale_of,
    scale_of_axis,
    scales_of,
    short_text,
)

LINEAR, LOGARITHMIC = Scale(100.0, 350.0), Scale(10.0, 1e5, logarithmic=True)


@pytest.mark.parametrize("name", PARAMETERS)
def test_every_slider_reaches_the_papers_value_and_only_valid_ones(name: str):
    scale, parameter = scale_of(name), PARAMETERS[name]
    assert scale.lower <= parameter.default <= scale.upper
    assert scale.lower < scale.upper
    assert parameter.complaint(scale.lower) is None
    assert parameter.complaint(scale.upper) is None


def test_a_slider_over_decades_is_logarithmic_and_temperatures_are_not():
    for name in (
        "viscosity_coefficient",
        "spring_stiffness",
        "angular_frequency",
        "drive_amplitude",
    ):
        assert scale_of(name).logarithmic
        assert scale_of(name).upper >= 1e3 * scale_of(name).lower
    assert not scale_of("temperature").logarithmic


def test_a_linear_slider_has_round_steps():
    assert LINEAR.step == 1.0
    assert Scale(-0.95, 1.0).step == 0.005


def test_a_slider_grows_to_a_value_of_its_kind():
    assert LINEAR.reaching(400.0) == Scale(100.0, 400.0)
    assert LINEAR.reaching(200.0) == LINEAR
    assert LOGARITHMIC.reaching(1e6).upper == 1e6
    assert LOGARITHMIC.reaching(-1.0) == LOGARITHMIC


def test_an_axis_gives_the_range():
    assert scale_of_axis("temperature", [300.0, 150.0]) == Scale(150.0, 300.0)
    assert scale_of_axis("spring_stiffness", [100.0, 1000.0, 1e4]).logarithmic
    assert not scale_of_axis("spring_stiffness", [100.0, 200.0, 300.0]).logarithmic
    assert scale_of_axis("temperature", [200.0, 200.0]) == scale_of("temperature")
    scales = scales_of({"temperature": [150.0, 300.0]})
    assert list(scales) == list(PARAMETERS)
    assert scales["temperature"] == Scale(150.0, 300.0)
    assert scales["block_mass"] == scale_of("block_mass")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (200.0, "200"),
        (8e-7, "8e-7"),
        (-2 / 3, "-2/3"),
        (4e12, "4e12"),
        (0.0, "0"),
        (0.1, "0.1"),
        (1e-4, "1e-4"),
    ],
)
def test_numbers_are_written_short(value: float, text: str):
    assert exact_text(value) == short_text(value) == text


def test_long_numbers_are_cut_in_a_box_only():
    assert short_text(1730 / 7) == "247.143"
    assert float(exact_text(1730 / 7)) == 1730 / 7


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_text_is_read_as_the_same_number(value: float):
    assert read_number(exact_text(value)) == value


@pytest.mark.parametrize("text", ["1_000", "\u0661\u0660\u0660"])
def test_a_text_that_is_no_number_in_a_config_is_none_in_a_box(text: str):
    with pytest.raises(ConfigError, match="must be a number"):
        from_mapping({}, overrides=[f"temperature={text}"])
    assert "temperature must be a number" in (complaint_of("temperature", text) or "")


def test_the_menu_of_laws_has_that_of_a_package_beside_ours():
    config = from_mapping({})
    assert "friction law" not in controls_html(config)  # of one there is no choice
    film = config.film.model_copy(update={"friction": "limited@its-package-1.0+00"})
    menu = controls_html(config.model_copy(update={"film": film})).split("friction law")[1]
    assert menu.index("<option>power-law<") < menu.index("<option>limited@its-package-1.0+00<")
