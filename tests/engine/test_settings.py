"""Settings of a config reach the integrators, and an unstable fixed step is reported first."""

from __future__ import annotations

import re
from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import messages

from stickslip import Options, Parameters, stability
from sweeps.config.load import Config, ConfigError, from_mapping
from sweeps.config.schema import Film
from sweeps.engine import settings
from sweeps.engine.run import run
from sweeps.engine.settings import coarse_step, options_of, read_config, unstable_step


def limit(**parameters: float) -> float:
    return float(stability.largest_stable_step(np.array(Parameters(**parameters)))[0])


def fixed(dt: float, **config: Any) -> list[tuple[str, str]]:
    integrator = {"method": "euler-cromer", "dt": dt}
    return list(unstable_step(from_mapping({"integrator": integrator, **config})))


def test_an_empty_config_gives_the_defaults_of_the_integrators() -> None:
    assert options_of(from_mapping({})) == Options()


@pytest.mark.parametrize(
    ("config", "changes"),
    [
        ({"integrator": {"rtol": 1e-9}}, {"rtol": 1e-9}),
        ({"integrator": {"max_steps": 123}}, {"max_steps": 123}),
        (
            {"integrator": {"method": "euler-cromer", "dt": 3e-10}},
            {"method": "euler-cromer", "dt": 3e-10},
        ),
        ({"stationary": {"rtol": 1e-4}}, {"stationary_rtol": 1e-4}),
        ({"stationary": {"max_periods": 77}}, {"max_periods": 77}),
        ({"stationary": {"accelerate": False}}, {"accelerate": False}),
        ({"noise": {"treatment": "none"}, "model": {"phi_0": 0.5}}, {"noise": "none"}),
    ],
)
def test_each_setting_changes_its_own_option_alone(
    config: dict[str, Any], changes: dict[str, Any]
) -> None:
    found = options_of(from_mapping(config))
    expected = {field.name: getattr(Options(), field.name) for field in fields(Options)}
    assert {name: getattr(found, name) for name in expected} == expected | changes


def test_a_cluster_without_the_address_of_its_scheduler_is_refused() -> None:
    message = "execution.backend: `dask` needs the address of a scheduler"
    with pytest.raises(ConfigError, match=message):
        read_config({"execution": {"backend": "dask"}})
    with pytest.raises(ConfigError, match=message):
        run(from_mapping({}), backend="dask")
    there = ["execution.scheduler=tcp://localhost:8786"]
    assert read_config({"execution": {"backend": "dask"}}, there).execution.backend == "dask"


def test_the_friction_law_reaches_the_integrators() -> None:
    film = Film.model_construct(friction="another")
    config = from_mapping({}).model_copy(update={"film": film})
    with pytest.raises(
        ConfigError, match=r"film.friction: must be one of power-law, not 'another'"
    ):
        options_of(config)


def test_an_adaptive_config_has_no_step_to_check() -> None:
    config = from_mapping({"model": {"kinetic_coefficient": 1e6}})
    assert [*unstable_step(config), *coarse_step(config)] == []


def test_the_largest_stable_step_itself_is_allowed() -> None:
    bound = limit()
    assert fixed(bound) == []
    ((key, message),) = fixed(np.nextafter(bound, 1.0))
    assert key == "integrator.dt"
    assert messages.UNSTABLE in message
    assert f"{bound:.1g}"[-4:] in message  # the power of ten


@pytest.mark.parametrize("position", range(5))
def test_one_stable_point_in_any_chunk_is_enough(
    monkeypatch: pytest.MonkeyPatch, position: int
) -> None:
    monkeypatch.setattr(settings, "CHUNK", 2)
    temperatures = [150.0, 151.0, 152.0, 153.0]
    temperatures.insert(position, 320.0)
    dt = 0.5 * (limit(temperature=320.0) + limit(temperature=153.0))
    assert limit(temperature=153.0) < dt < limit(temperature=320.0)
    assert fixed(dt, sweep={"temperature": temperatures}) == []
    stiff = [T for T in temperatures if T < 200]
    assert len(fixed(dt, sweep={"temperature": stiff})) == 1


@given(st.floats(min_value=1.0, max_value=1000.0), st.floats(min_value=0.1, max_value=1000.0))
def test_the_step_that_the_message_names_is_accepted(T: float, omega: float) -> None:
    model = {"temperature": T, "angular_frequency": omega}
    ((_, message),) = fixed(1e3, model=model)
    named = float(re.search(r"step is (\S+) s$", message)[1])
    assert fixed(named, model=model) == []
    assert named > 0.9 * limit(**model)


def test_a_step_that_only_some_points_refuse_is_warned_about() -> None:
    config = fixed_step(8e-9, sweep={"angular_frequency": [10.0, 38.0]})
    (warning,) = coarse_step(config)
    assert "unstable for 1 of the 2 points" in warning


def test_a_coarse_step_is_warned_about_and_a_fine_one_is_not() -> None:
    (warning,) = coarse_step(fixed_step(5e-9))
    assert "coarse" in warning
    assert list(coarse_step(fixed_step(1e-10))) == []


def fixed_step(dt: float, **sections: object) -> Config:
    return from_mapping({"integrator": {"method": "euler-cromer", "dt": dt}, **sections})
