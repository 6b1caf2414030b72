"""Options: defaults, ranges, and the table of methods."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from stickslip import options
from stickslip.model.laws import FrictionLaw, friction_law
from stickslip.options import (
    DEFAULTS,
    FRICTION_LAWS,
    METHODS,
    NO_NOISE,
    NOISE_TREATMENTS,
    OFFERED,
    OPTIONS,
    STOCHASTIC,
    TYPICAL_PATH,
    OptionError,
    Options,
    Settings,
)
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS

CHOICES: dict[str, Any] = {
    "method": METHODS,
    "noise": NOISE_TREATMENTS,
    "friction": FRICTION_LAWS,
}


# --- methods, treatments, laws --------------------------------------------------------------------


@pytest.mark.parametrize("left_out", [*OFFERED, "stochastic_walk"])
def test_a_module_that_lacks_a_function_is_no_method(
    left_out: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = import_module(METHODS["adaptive"].module)
    monkeypatch.delattr(module, left_out)
    with pytest.raises(
        TypeError, match=f"the method {module.__name__} lacks the function {left_out}$"
    ):
        assert METHODS["adaptive"].kernels


def test_a_method_without_noise_needs_no_stochastic_walk_and_refuses_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    method = replace(METHODS["adaptive"], noises=(TYPICAL_PATH, NO_NOISE))
    monkeypatch.delattr(import_module(method.module), "stochastic_walk")
    assert method.kernels
    monkeypatch.setattr(options, "METHODS", METHODS | {"calm": method})
    assert Options(method="calm", noise=NO_NOISE).method == "calm"
    with pytest.raises(OptionError) as caught:
        Options(method="calm", noise=STOCHASTIC)
    assert str(caught.value) == "noise 'stochastic' needs the method adaptive or euler-cromer"


def test_the_budget_of_euler_cromer_covers_all_periods_at_the_step_of_the_paper() -> None:
    period = 2 * math.pi / Parameters().angular_frequency
    assert METHODS["euler-cromer"].max_steps > period / DEFAULTS.dt * DEFAULTS.max_periods


@pytest.mark.parametrize("name", METHODS)
def test_a_method_returns_the_largest_step_of_each_point(name: str) -> None:
    points = np.array([Parameters(), Parameters(elastic_coefficient=0.0)])
    steps = METHODS[name].kernels.largest_step(points, Options(method=name))
    assert steps.shape == (2,)
    assert np.all(steps > 0)


@pytest.mark.parametrize("name", FRICTION_LAWS)
def test_a_law_is_declared_under_its_name(name: str) -> None:
    law = friction_law(name)
    assert isinstance(law, FrictionLaw)
    assert law.name == name
    assert set(law.parameters) <= set(PARAMETERS)
    assert set(law.scaled) <= set(law.parameters)


# --- defaults -------------------------------------------------------------------------------------


def test_the_defaults_are_those_of_the_interface() -> None:
    assert Options() == DEFAULTS
    assert (
        Options(
            method="adaptive",
            rtol=1e-6,
            dt=1e-10,
            max_steps=None,
            stationary_rtol=1e-6,
            max_periods=5000,
            window=200,
            accelerate=True,
            noise="typical-path",
            friction="power-law",
        )
        == DEFAULTS
    )


def test_every_option_with_a_range_is_a_field_with_its_default() -> None:
    assert set(OPTIONS) < {field.name for field in fields(Options)}
    for name, option in OPTIONS.items():
        assert getattr(DEFAULTS, name) == option.default
        assert option.meaning


# --- ranges ---------------------------------------------------------------------------------------

EDGES = {  # the last value refused and the first one taken, at either end
    "rtol": (1e-13, math.nextafter(1e-13, 1.0), 1e-2, math.nextafter(1e-2, 1.0)),
    "stationary_rtol": (1e-13, math.nextafter(1e-13, 1.0), 1e-2, math.nextafter(1e-2, 1.0)),
    "dt": (0.0, 5e-324, 1e300, math.inf),
    "max_steps": (0, 1, 2**63 - 1, 2**63),
    "max_error": (0.0, 5e-324, 1.0, math.nextafter(1.0, 2.0)),
    "max_periods": (0, 1, 2**63 - 1, 2**63),
    "window": (19, 20, 1_000_000, 1_000_001),
    "realizations": (0, 1, 1_000_000, 1_000_001),
    "seed": (-1, 0, 2**64 - 1, 2**64),
}


@pytest.mark.parametrize("name", OPTIONS)
def test_a_range_ends_where_it_says(name: str) -> None:
    too_low, lowest, highest, too_high = EDGES[name]
    for value in (lowest, highest):
        assert getattr(Options(**{name: value}), name) == value
    for value in (too_low, too_high, -1, math.nan, math.inf, -math.inf):
        with pytest.raises(OptionError, match=rf"^{name} must be "):
            Options(**{name: value})


@pytest.mark.parametrize("name", ["max_steps", "max_periods", "window"])
def test_a_count_with_a_fraction_is_refused_not_cut(name: str) -> None:
    assert getattr(Options(**{name: 1e3}).settings(), name) == 1000
    with pytest.raises(OptionError, match=rf"^{name} must be a whole number, .*, not 99\.5$"):
        Options(**{name: 99.5})


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize("value", ["1e-6", b"1", None, True, [1.0], {}, 1j])
def test_a_value_that_is_no_number_is_refused_by_name(name: str, value: object) -> None:
    if value is None and OPTIONS[name].default is None:
        assert getattr(Options(**{name: value}), name) is None
        return
    with pytest.raises(OptionError, match=rf"^{name} must be "):
        Options(**{name: value})


@pytest.mark.parametrize("name", CHOICES)
def test_an_unknown_choice_is_refused_with_the_known_ones(name: str) -> None:
    with pytest.raises(OptionError) as caught:
        Options(**{name: "nonsense"})
    known = ", ".join(CHOICES[name])
    message, _, how_to_add = str(caught.value).partition("; ")
    assert message == f"{name} must be one of {known}, not 'nonsense'"
    assert ("register_law" in how_to_add) == (name == "friction")
    for value in CHOICES[name]:
        assert getattr(Options(**{name: value}), name) == value


def test_all_complaints_come_at_once() -> None:
    with pytest.raises(OptionError) as caught:
        Options(method="euler", rtol=2.0, dt=-1.0, max_steps=0)
    assert str(caught.value).split("; ") == [
        "method must be one of adaptive, euler-cromer, not 'euler'",
        "rtol must be 1e-13 < value <= 0.01, not 2.0",
        "dt must be greater than 0, not -1.0",
        "max_steps must be a whole number, 1 <= value <= 9.22337e+18, not 0",
    ]


# --- as kernels take them -------------------------------------------------------------------------


def test_settings_are_plain_numbers() -> None:
    settings = Options(rtol=np.float32(1e-3), max_steps=np.int8(5), dt=1, max_periods=7).settings()
    assert [type(value) for value in settings] == [float, float, int, float, int, int, bool]
    assert settings == Settings(float(np.float32(1e-3)), 1.0, 5, 1e-6, 7, 200, True)


@pytest.mark.parametrize("name", METHODS)
def test_settings_left_out_are_those_of_the_method(name: str) -> None:
    settings = Options(method=name).settings()
    assert settings.max_steps == METHODS[name].max_steps
    assert settings.accelerate == METHODS[name].accelerates
    assert Options(method=name, max_steps=3).settings().max_steps == 3
    assert not Options(method=name, accelerate=False).settings().accelerate
