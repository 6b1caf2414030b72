"""Numbers as people write them in a config."""

from __future__ import annotations

import math

import pytest

from sweeps.config.load import from_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-9", 1e-9),
        ("4e12", 4e12),
        (".5", 0.5),
        ("5.", 5.0),
        ("1E2", 100.0),
        ("+3", 3.0),
        ("010", 10.0),
        ("0o10", 8.0),
        ("0x10", 16.0),
        ("2/3", 2 / 3),
        ("' 1 / 3 '", 1 / 3),
        ("1e-400", 0.0),
    ],
)
def test_numbers_are_those_of_yaml_1_2_and_fractions(text: str, value: float) -> None:
    assert from_yaml(f"model: {{T: {text}}}").model["temperature"] == value


def test_minus_zero_is_zero() -> None:
    value = from_yaml("model: {x_0: -0.0, v_0: -0/1}").model
    assert [math.copysign(1, v) for v in value.values()] == [1, 1]
