"""What makes two computations the same: settings and points, and nothing that changes no number."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stickslip.kernels.version import NUMERICS_VERSION
from sweeps.config.load import from_mapping
from sweeps.grid import Grid
from sweeps.identity import (
    KEY_BYTES,
    differences,
    key_of,
    near_duplicates,
    settings_of,
)

CONFIG: dict[str, Any] = {
    "model": {"M": 0.5},
    "sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"]},
    "cases": {"X_m": [4e-7, 8e-7], "omega": [20, 10]},
}


def grid_of(**changes: Any) -> Grid:
    return Grid.from_config(from_mapping(CONFIG | changes))


def key(**changes: Any) -> bytes:
    config = from_mapping(CONFIG | changes)
    return key_of(settings_of(config), Grid.from_config(config))


def settings(**changes: Any) -> dict[str, Any]:
    return dict(settings_of(from_mapping(CONFIG | changes)))


def test_the_settings_of_an_adaptive_sweep() -> None:
    assert settings() == {
        "integrator.method": "adaptive",
        "integrator.rtol": 1e-6,
        "stationary.rtol": 1e-6,
        "stationary.max_periods": 5000,
        "stationary.accelerate": True,
        "noise.treatment": "typical-path",
        "integrator.max_error": 0.01,
        "stationary.window": 200,
        "film.friction": "power-law",
        "film.strain": "adiabatic",
    }


def test_the_settings_of_a_fixed_step() -> None:
    found = settings(integrator={"method": "euler-cromer", "dt": 1e-9, "max_steps": 10})
    assert found["integrator.dt"] == 1e-9
    assert found["integrator.max_steps"] == 10
    assert "integrator.rtol" not in found


def test_the_version_of_the_numerics_enters_the_key(monkeypatch: pytest.MonkeyPatch) -> None:
    before = key()
    monkeypatch.setattr("sweeps.identity.NUMERICS_VERSION", NUMERICS_VERSION + 1)
    assert key() != before


def test_each_difference_is_a_line() -> None:
    old = settings()
    assert differences(old, settings()) == []
    new = settings(
        integrator={"rtol": 1e-5, "max_steps": 10},
        stationary={"accelerate": False},
    )
    assert differences(old, new) == [
        "integrator.rtol: 1e-06 -> 1e-05",
        "stationary.accelerate: True -> False",
        "integrator.max_steps: not set -> 10",
    ]
    assert differences(new, old)[-1] == "stationary.accelerate: False -> True"
    assert "integrator.max_steps: 10 -> not set" in differences(new, old)
    fixed = settings(integrator={"method": "euler-cromer"})
    assert differences(old, fixed) == [
        "integrator.method: adaptive -> euler-cromer",
        "integrator.rtol: 1e-06 -> not set",
        "integrator.dt: not set -> 1e-10",
    ]


CHANGES: dict[str, dict[str, Any]] = {
    "tolerance": {"integrator": {"rtol": 1e-5}},
    "method": {"integrator": {"method": "euler-cromer"}},
    "step": {"integrator": {"method": "euler-cromer", "dt": 1e-9}},
    "budget of steps": {"integrator": {"max_steps": 10**6}},
    "stationary tolerance": {"stationary": {"rtol": 1e-5}},
    "budget of periods": {"stationary": {"max_periods": 4999}},
    "acceleration": {"stationary": {"accelerate": False}},
    "noise": {"model": {"M": 0.5, "phi_0": 0.5}, "noise": {"treatment": "none"}},
    "start without that noise": {"model": {"M": 0.5, "phi_0": 0.5}},
    "fixed value, by a bit": {"model": {"M": np.nextafter(0.5, 1.0).item()}},
    "another fixed value": {"model": {"M": 0.5, "K": 2999.0}},
    "two fixed values exchanged": {"model": {"M": 1.0, "h": 0.5}},
    "... and back": {"model": {"M": 0.5, "h": 1.0}},
    "axis value, by a bit": {
        "sweep": {"T": [150, 200, np.nextafter(250.0, 0.0).item()], "gamma": [0, "2/3"]}
    },
    "order of the values": {"sweep": {"T": [200, 150, 250], "gamma": [0, "2/3"]}},
    "one value more": {"sweep": {"T": [150, 200, 250, 300], "gamma": [0, "2/3"]}},
    "one value less": {"sweep": {"T": [150, 200], "gamma": [0, "2/3"]}},
    "order of the axes": {"sweep": {"gamma": [0, "2/3"], "T": [150, 200, 250]}},
    "an axis more": {"sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"], "K": [3000]}},
    "an axis less": {"sweep": {"T": [150, 200, 250]}},
    "an axis of one value": {
        "sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"], "M": [0.5]},
        "model": {},
    },
    "order of the cases": {"cases": {"X_m": [8e-7, 4e-7], "omega": [10, 20]}},
    "a case paired otherwise": {"cases": {"X_m": [4e-7, 8e-7], "omega": [10, 20]}},
    "no cases": {"cases": {}},
    "an axis instead of cases": {
        "sweep": CONFIG["sweep"] | {"X_m": [4e-7, 8e-7]},
        "cases": {"omega": [20, 10]},
    },
}


def test_the_key_changes_with_whatever_changes_a_point_or_its_number() -> None:
    keys = {"": key()} | {name: key(**changes) for name, changes in CHANGES.items()}
    assert all(len(found) == KEY_BYTES for found in keys.values())
    assert len(set(keys.values())) == len(keys)


@pytest.mark.parametrize(
    "changes",
    [
        {"title": "another"},
        {"output": "elsewhere.nc"},
        {"execution": {"workers": 7, "block_points": 3, "backend": "loky"}},
        {"plot": {"figure": "time_courses"}},
        {"simulation": {"periods": 3}},
        {"integrator": {"rtol": 1e-6}},
        {"model": {"M": 0.5, "K": 3000}},
        {"sweep": {"temperature": {"arange": [150, 250, 50]}, "rheological_index": [0, "2/3"]}},
        {"cases": {"omega": [20, 10], "X_m": [4e-7, 8e-7]}},
    ],
)
def test_the_key_does_not_change_with_what_changes_no_number(changes: dict[str, Any]) -> None:
    assert key(**changes) == key()


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ([150, 200], [150, 200], []),
        ([150, 200], [150.1, 200.1], []),
        ([150, 200, 250], [150, 200.00000001, 250], ["200.0 and 200.00000001"]),
        ([150, 200, 250], [150, 199.99999999, 250], ["200.0 and 199.99999999"]),
        ([150, 200, 250], [150, 200, 200.00000001], ["200.0 and 200.00000001"]),
        ([250, 150, 200], [200.00000001, 100], ["200.0 and 200.00000001"]),
        ([150, 200], [150, 200.0000004], []),
    ],
)
def test_values_that_differ_by_rounding_are_told(
    old: list[float], new: list[float], told: list[str]
) -> None:
    first, second = grid_of(sweep={"T": old}), grid_of(sweep={"T": new})
    assert near_duplicates(first, second) == [f"temperature {pair}" for pair in told]


def test_near_duplicates_are_found_whether_fixed_swept_or_linked() -> None:
    old = grid_of()
    near = 0.5 * (1.0 + 1e-12)
    lines = [f"block_mass 0.5 and {near!r}"]
    assert set(near_duplicates(old, grid_of(model={"M": near}))) == set(lines)
    swept = grid_of(model={}, sweep={"M": [0.1, near, 1.0]})
    assert set(near_duplicates(old, swept)) == set(lines)
    linked = grid_of(model={}, cases={"M": [0.1, near], "omega": [20, 10]})
    assert set(near_duplicates(old, linked)) == set(lines)
    assert near_duplicates(old, grid_of(cases={"X_m": [4e-7], "omega": [20]})) == []


@pytest.mark.parametrize("new", [[200.00000001, 300], [100, 199.99999999], [249.99999999, 250.1]])
def test_each_pair_is_told_once(new: list[float]) -> None:
    for old in ([200], [100.5, 200], [200, 300.5], [250]):
        told = near_duplicates(grid_of(sweep={"T": old}), grid_of(sweep={"T": new}))
        assert len(told) == len(set(told))
