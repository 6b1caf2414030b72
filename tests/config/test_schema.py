"""The sections of a config: their keys agree with the options of the integrators."""

from __future__ import annotations

import pytest
from support.sweeps.configs import SECTIONS

from stickslip.options import DEFAULTS, METHODS, OPTIONS
from sweeps.config.json_schema import json_schema
from sweeps.config.load import ConfigError, from_mapping, from_yaml
from sweeps.identity import settings_of

# The key of each option of the integrators.
KEYS = {name: ("integrator", name) for name in ("rtol", "dt", "max_steps")} | {
    "stationary_rtol": ("stationary", "rtol"),
    "max_error": ("integrator", "max_error"),
    "max_periods": ("stationary", "max_periods"),
    "window": ("stationary", "window"),
    "realizations": ("noise", "realizations"),
    "seed": ("noise", "seed"),
}
STOCHASTIC = {"treatment": "stochastic"}


def test_the_defaults_of_the_integrators_are_those_of_their_options() -> None:
    config, stochastic = from_mapping({}), from_mapping({"noise": STOCHASTIC})
    assert KEYS.keys() == OPTIONS.keys()
    for name, (section, key) in KEYS.items():
        config = stochastic if section == "noise" else config
        assert getattr(getattr(config, section), key) == OPTIONS[name].default
    config = from_mapping({})
    assert config.integrator.method == DEFAULTS.method
    assert config.stationary.accelerate == DEFAULTS.accelerate
    assert config.noise.treatment == DEFAULTS.noise
    assert config.film.friction == DEFAULTS.friction


@pytest.mark.parametrize("name", OPTIONS)
def test_the_bounds_are_those_of_the_options(name: str) -> None:
    (section, key), valid = KEYS[name], OPTIONS[name].range
    method = {"method": next((m for m, d in METHODS.items() if d.own_option == name), "adaptive")}
    others = {"integrator": method, "noise": STOCHASTIC}.get(section, {})

    def accepts(value: float) -> bool:
        try:
            from_mapping({section: others | {key: value}})
        except ConfigError:
            return False
        return True

    lowest = valid.lower if not valid.lower_open else valid.lower * 1.0001 + 5e-324
    below = valid.lower if valid.lower_open else valid.lower - 1
    assert (accepts(lowest), accepts(below)) == (True, False)
    if valid.upper < float("inf"):
        assert (accepts(valid.upper), accepts(valid.upper * 2)) == (True, False)


def test_every_key_has_a_description() -> None:
    definitions = json_schema()["$defs"]
    for kind in SECTIONS.values():
        for key, value in definitions[kind.__name__]["properties"].items():
            assert value.get("description"), key


def test_a_stochastic_film_has_a_shorter_window_unless_one_is_given() -> None:
    assert from_mapping({"noise": STOCHASTIC}).stationary.window == 32
    given = {"stationary": {"window": 200}, "noise": STOCHASTIC}
    assert from_mapping(given).stationary.window == 200
    # The two windows give different numbers.
    settings = [settings_of(from_mapping(part)) for part in (given, {"noise": STOCHASTIC})]
    assert settings[0] != settings[1]


def test_the_ensemble_of_a_stochastic_film_is_resolved_and_part_of_its_identity() -> None:
    config = from_mapping({"noise": STOCHASTIC})
    assert config.resolved()["noise"] == STOCHASTIC | {"seed": 1, "realizations": 64}
    assert from_yaml(config.resolved_yaml()) == config
    settings = settings_of(config)
    assert (settings["noise.seed"], settings["noise.realizations"]) == (1, 64)
    others = [{"seed": 2}, {"realizations": 32}]
    assert all(settings_of(from_mapping({"noise": STOCHASTIC | o})) != settings for o in others)
    assert "noise.seed" not in settings_of(from_mapping({}))


def test_observables_are_accepted_and_change_nothing() -> None:
    config, plain = from_mapping({"observables": ["moments", "harmonics"]}), from_mapping({})
    assert config.resolved() == plain.resolved()
    assert config.sha256() == plain.sha256()
    assert settings_of(config) == settings_of(plain)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("harmonics", "must be a list of harmonics and moments, not 'harmonics'"),
        (["harmonic"], "observables[0]: must be 'harmonics' or 'moments', not 'harmonic' (did"),
        ([3], "observables[0]: must be 'harmonics' or 'moments', not 3"),
    ],
)
def test_other_observables_are_refused(given: object, words: str) -> None:
    with pytest.raises(ConfigError) as refused:
        from_mapping({"observables": given})
    assert words in str(refused.value)
