"""What makes two computations the same: settings and points, and nothing that changes no number."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
import pytest

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import PARAMETERS
from sweeps.config.load import from_mapping
from sweeps.config.schema import SECTIONS, Film, Neutral
from sweeps.grid import Grid
from sweeps.identity import (
    KEY_BYTES,
    differences,
    key_of,
    near_duplicates,
    seal_key,
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
        "numerics_version": NUMERICS_VERSION,
    }


def test_the_settings_of_a_fixed_step() -> None:
    found = settings(integrator={"method": "euler-cromer", "dt": 1e-9, "max_steps": 10})
    assert found["integrator.dt"] == 1e-9
    assert found["integrator.max_steps"] == 10
    assert "integrator.rtol" not in found


def test_the_version_of_the_numerics_is_that_of_whoever_computed() -> None:
    config = from_mapping(CONFIG)
    assert settings_of(config, "1")["numerics_version"] == 1
    assert key_of(settings_of(config, 1), grid_of()) != key_of(settings_of(config, 2), grid_of())


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


# Of commit 5070a2e: files and journals written then carry them. They hold as long as no key and no
# parameter enters at its neutral value.
DIGESTS: dict[str, tuple[dict[str, Any], str, str]] = {
    "empty": (
        {},
        "40a9c2fcbf513123cafedb1e36f7e18b",
        "e6e5c569e31961e4b8fb6e5aa0f884cc",
    ),
    "sweep with cases": (
        CONFIG,
        "801f6585aae8c8646db9281b0be33657",
        "02d4499dd7ea4b14244fa53d4484d776",
    ),
    "fixed step": (
        {
            "integrator": {"method": "euler-cromer", "dt": 1e-9, "max_steps": 10},
            "sweep": {"T": {"linspace": [150, 320], "num": 171}},
        },
        "581f4a062fcd10dfea177ad7b6131942",
        "b433f1b8287d614a9a643c6eca928b9b",
    ),
    "no noise": (
        {
            "model": {"phi_0": 0.5},
            "noise": {"treatment": "none"},
            "stationary": {"rtol": 1e-5, "max_periods": 77, "accelerate": False},
        },
        "1d12696d124126d0f5de972a659fae03",
        "ba87f2b9d7d42559b96627d8a3f3b696",
    ),
}


@pytest.mark.parametrize(("config", "key", "seal"), DIGESTS.values(), ids=DIGESTS)
def test_keys_and_seals_are_those_of_older_files(
    config: dict[str, Any], key: str, seal: str
) -> None:
    read = from_mapping(config)
    found, grid = settings_of(read, 2), Grid.from_config(read)
    assert key_of(found, grid).hex() == key
    assert seal_key(found, grid).hex() == seal


# --- neutral values ---


class OtherFilm(Film):
    """The film as a later version may have it: a second law, which is its default."""

    friction: Annotated[Literal["power-law", "eyring"], Neutral("power-law")] = "eyring"


@pytest.fixture
def second_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SECTIONS, "film", OtherFilm)


@pytest.fixture
def younger_thickness() -> Iterator[None]:
    """The thickness of the film as a parameter that older files do not name: theirs was 5e-10."""
    variable = PARAMETERS["film_thickness"]
    object.__setattr__(variable, "neutral", 5e-10)
    yield
    object.__setattr__(variable, "neutral", None)


def test_a_key_at_its_neutral_value_enters_nothing(second_law: None) -> None:
    before, at_neutral = from_mapping({}, older=True), {"film": {"friction": "power-law"}}
    assert "film.friction" not in settings(**at_neutral)
    assert settings()["film.friction"] == "eyring"
    assert key(**at_neutral) != key()
    same, other = from_mapping(at_neutral), from_mapping({})
    assert same.sha256() == before.sha256() != other.sha256()


def test_an_older_file_is_read_with_neutral_values_and_not_with_todays_defaults(
    second_law: None,
) -> None:
    old, new = from_mapping({}, older=True), from_mapping({})
    assert (old.film.friction, new.film.friction) == ("power-law", "eyring")
    assert from_mapping({"film": {}}, older=True).film.friction == "power-law"
    assert from_mapping({"film": {"friction": "eyring"}}, older=True).film.friction == "eyring"
    assert key_of(settings_of(old, 2), Grid.from_config(old)).hex() == DIGESTS["empty"][1]
    assert seal_key(settings_of(old), Grid.from_config(old)).hex() == DIGESTS["empty"][2]
    assert seal_key(settings_of(new), Grid.from_config(new)).hex() != DIGESTS["empty"][2]


def test_a_resolved_config_names_the_neutral_value(second_law: None) -> None:
    old = from_mapping({}, older=True)
    assert old.resolved()["film"] == {"friction": "power-law", "strain": "adiabatic"}
    assert from_mapping(old.resolved()) == old


def test_a_difference_names_the_neutral_value(second_law: None) -> None:
    old, new = settings(film={"friction": "power-law"}), settings()
    assert differences(old, new) == ["film.friction: power-law -> eyring"]
    assert differences(new, old) == ["film.friction: eyring -> power-law"]


def test_a_parameter_at_its_neutral_value_enters_nothing(younger_thickness: None) -> None:
    model = CONFIG["model"] | {"h": 5e-10}
    grid = grid_of(model=model)
    fixed = {name: value for name, value in grid.fixed.items() if name != "film_thickness"}
    before = Grid(grid.dims, grid.shape, grid.coords, fixed)
    assert key(model=model) == key_of(settings(), before)
    assert seal_key(settings(), grid) == seal_key(settings(), before)
    assert key() != key(model=model) != key(model=CONFIG["model"] | {"h": 4e-10})
    swept = CONFIG["sweep"] | {"h": [5e-10]}
    assert key(sweep=swept) != key(model=model)


def test_an_older_file_has_the_neutral_value_of_a_parameter_that_it_does_not_name(
    younger_thickness: None,
) -> None:
    old = from_mapping(CONFIG, older=True)
    high = {"quintic_coefficient": 0.0, "sextic_coefficient": 0.0}  # which came later
    assert old.model == {"block_mass": 0.5, "film_thickness": 5e-10} | high
    assert old.resolved()["model"]["film_thickness"] == 5e-10
    for given in ({"model": {"h": 2e-9}}, {"sweep": {"h": [2e-9]}}, {"cases": {"h": [2e-9]}}):
        config = from_mapping(given, older=True)
        assert config.model.get("film_thickness", 2e-9) == 2e-9


def test_the_hash_of_a_config_does_not_see_a_parameter_at_its_neutral_value(
    younger_thickness: None,
) -> None:
    same = from_mapping({"model": {"h": 5e-10}})
    before = same.resolved()
    for key in ("film", "plot", "simulation"):
        del before[key]
    del before["model"]["film_thickness"], before["integrator"]["max_error"]
    del before["model"]["quintic_coefficient"], before["model"]["sextic_coefficient"]
    del before["stationary"]["window"]
    text = json.dumps(before | {"sweep": []}, sort_keys=True, separators=(",", ":"))
    assert same.sha256() == hashlib.sha256(text.encode()).hexdigest()
    assert same.sha256() == from_mapping({}, older=True).sha256() != from_mapping({}).sha256()
