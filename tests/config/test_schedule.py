"""`simulation.schedule`: values along one run."""

from __future__ import annotations

import pytest

from sweeps.config.load import ConfigError, from_mapping, from_yaml


def scheduled(schedule: object, **config: object) -> dict[str, object]:
    return {"simulation": {"periods": 2, "schedule": schedule}, **config}


def test_a_schedule_takes_symbols_lists_and_forms() -> None:
    config = from_mapping(scheduled({"T": [200, 300], "K": {"linspace": [1e3, 2e3], "num": 2}}))
    expected = {"temperature": (200.0, 300.0), "spring_stiffness": (1000.0, 2000.0)}
    assert config.simulation.schedule == expected
    assert from_yaml(config.resolved_yaml()) == config


def test_no_schedule_is_none() -> None:
    for config in ({}, scheduled(None), scheduled({})):
        assert from_mapping(config).simulation.schedule is None
        assert "schedule" not in from_mapping(config).resolved()["simulation"]


@pytest.mark.parametrize(
    ("schedule", "config", "message"),
    [
        ({"T": [200, "x"]}, {}, r"simulation.schedule.T\[1\]: must be a number"),
        ({"T": [-1]}, {}, r"simulation.schedule.T\[0\]: must be at least 0"),
        ({"Tt": [1]}, {}, "unknown parameter .did you mean 'T'"),
        ({"T": 200}, {}, "simulation.schedule.T: must be a list"),
        (5, {}, "simulation.schedule: must consist of lines"),
        ({"T": [1, 2], "K": [1]}, {}, "temperature 2, spring_stiffness 1"),
        ({"x_0": [0]}, {}, "x_0: cannot be scheduled: a run has only one start"),
        ({"T": [1], "temperature": [2]}, {}, "gives temperature a second time"),
        ({"T": [1]}, {"sweep": {"T": [1, 2]}}, "gives temperature a second time"),
        ({"c": [850, 0]}, {}, "simulation.schedule: quartic_coefficient .c. = 0 needs a sextic"),
        ({"c": [-1, 0]}, {}, r"^<dict>: simulation.schedule.c\[0\]: must be at least 0, not -1.0$"),
        ({"T": {"linspace": [1, 2], "num": 100_000}}, {}, "must be at most 100000000"),
    ],
)
def test_a_wrong_schedule_is_refused(schedule: object, config: dict, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        from_mapping(scheduled(schedule, **config))


def test_coefficients_of_a_schedule_change_together() -> None:
    config = from_mapping(scheduled({"c": [850, 0], "e": [0, 100]}))
    assert config.simulation.schedule["quartic_coefficient"] == (850.0, 0.0)


def test_a_value_under_model_applies_to_a_sweep() -> None:
    config = from_mapping(scheduled({"T": [200, 300]}, model={"T": 250}))
    assert config.parameters().temperature == 250.0
    assert "applies to a simulated run only" in config.warnings[0]
