"""The JSON Schema agrees with what is read, and the shipped one is the current one."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from support.sweeps.configs import EXAMPLE, SHIPPED, problems

from stickslip.variables import PARAMETERS
from sweeps.config.json_schema import json_schema
from sweeps.config.load import from_yaml, load


@cache
def validator() -> Any:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(json_schema())
    return jsonschema.Draft202012Validator(json_schema())


def schema_accepts(config: Any) -> bool:
    return bool(validator().is_valid(config))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_schema_accepts_the_shipped_configs(path: Path) -> None:
    assert schema_accepts(YAML(typ="safe", pure=True).load(path))
    assert schema_accepts(load(path).resolved())


@pytest.mark.parametrize(
    ("text", "accepted"),
    [
        (EXAMPLE, True),
        ("model: {T: 200, gamma: -2/3, X_m: -1}", True),
        ("sweep: {k: {geomspace: [1, 2], num: 3}, K: {arange: [1, 2, 1/2]}}", True),
        ("model:\nsweep:\nplot:", True),
        ("integrator: {method: euler-cromer, dt: 1/1000, max_steps: null}", True),
        ("sample: {sobol: 4, T: [150, 320], K: {log: [500, 1e4]}}", True),
        ("simulation: {schedule: {T: [200, 300], K: {linspace: [1, 2], num: 2}}}", True),
        ("sweep: {T: {linspace: [1, 9], num: 9}}\nrefine: {axes: [T], where: [regime]}", True),
        ("modle: {}", False),
        ("model: {temprature: 1}", False),
        ("model: {T: -1}", False),
        ("model: {T: '200'}", False),
        ("model: {X_m: 0}", False),
        ("model: {gamma: -1}", False),
        ("model: {phi_0: 3}", False),
        ("cases: {temprature: [1]}", False),
        ("cases: {T: [-1]}", False),
        ("sample: {sobol: 4, temprature: [1, 2]}", False),
        ("sample: {sobol: 4, T: [-1, 2]}", False),
        ("sample: {sobol: 4, T: {log: [-1, 2]}}", False),
        ("simulation: {schedule: {T: [-1]}}", False),
        ("simulation: {schedule: {x_0: [0]}}", False),
        ("sweep: {T: [1, 2]}\nrefine: {axes: [T], levels: 9}", False),
        ("sweep: {T: 3}", False),
        ("sweep: {T: []}", False),
        ("sweep: {T: [-1]}", False),
        ("sweep: {T: {linspace: [1, 2]}}", False),
        ("sweep: {T: {logspace: [1, 2], num: 3}}", False),
        ("integrator: {method: rk4}", False),
        ("integrator: {rtol: 0}", False),
        ("stationary: {max_period: 3}", False),
    ],
)
def test_the_schema_agrees_with_the_reader(text: str, accepted: bool) -> None:
    assert schema_accepts(YAML(typ="safe", pure=True).load(text)) is accepted
    if accepted:
        from_yaml(text)
    else:
        problems(text)


def test_the_schema_describes_every_parameter_with_its_unit() -> None:
    properties = json_schema()["properties"]["model"]["anyOf"][0]["properties"]
    for name, variable in PARAMETERS.items():
        for key in (name, variable.symbol):
            assert f"[{variable.unit or 1}]" in properties[key]["description"]
