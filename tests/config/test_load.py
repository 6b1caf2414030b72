"""The meaning of an accepted config; reading returns a Config or raises ConfigError."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML
from support.sweeps.bad_configs import ALL, Outcome
from support.sweeps.configs import EXAMPLE, SHIPPED

from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS
from sweeps.config.load import Config, ConfigError, from_mapping, from_yaml, load


@pytest.mark.parametrize(
    ("content", "outcome"), [row[1:] for row in ALL], ids=[row[0] for row in ALL]
)
def test_each_config_has_the_expected_outcome(
    tmp_path: Path, content: str | bytes, outcome: Outcome
) -> None:
    path = tmp_path / "bad.yaml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    if outcome.kind == "refused":
        with pytest.raises(ConfigError) as caught:
            load(path)
        problems = caught.value.problems
        assert any(p.line == outcome.line and outcome.part in str(p) for p in problems), problems
        assert str(caught.value).count("\n") == len(problems) - 1
    else:
        config = load(path)
        assert isinstance(config, Config)
        expected = [f"{path}:{outcome.line}: "] if outcome.kind == "warned" else []
        warnings = [text for text in config.warnings if "in another unit?" not in text]
        assert len(warnings) == len(expected)
        for warning, start in zip(warnings, expected, strict=True):
            assert warning.startswith(start)
            assert outcome.part in warning


def test_left_out_keys_take_the_values_of_the_example() -> None:
    example, empty = from_yaml(EXAMPLE), from_yaml("{}")
    for section in ("integrator", "stationary", "noise", "execution", "plot", "simulation"):
        assert getattr(example, section) == getattr(empty, section)
    assert (empty.title, empty.model, empty.sweep, empty.cases) == (None, {}, {}, {})


def test_an_empty_config_is_the_papers_fig_3() -> None:
    assert from_mapping({}).parameters() == Parameters()


@pytest.mark.parametrize(
    ("text", "overrides", "output"),
    [
        ("{}", [], "results/map.nc"),
        ("output:", [], "results/map.nc"),
        ("output: a.nc", [], "a.nc"),
        ("output: a.nc", ["output=b.nc"], "b.nc"),
        ("output: a.nc", ["output=null"], "results/map.nc"),
    ],
)
def test_the_output_is_named_after_the_file_unless_it_is_given(
    tmp_path: Path, text: str, overrides: list[str], output: str
) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(text)
    assert load(path, overrides).output == output


def test_the_order_of_the_axes_is_kept_and_counts() -> None:
    one, other = from_yaml("sweep: {T: [1], k: [2]}"), from_yaml("sweep: {k: [2], T: [1]}")
    assert list(one.sweep) == ["temperature", "viscosity_coefficient"]
    assert one != other
    assert one.sha256() != other.sha256()


def test_python_users_may_pass_arrays_and_numbers_of_numpy() -> None:
    axis = np.linspace(150, 320, 3)
    config = from_mapping(
        {"model": {"K": np.float64(1e3), "k": np.int64(5)}, "sweep": {"T": axis, "M": (1, 2)}}
    )
    assert config.sweep == {"temperature": (150, 235, 320), "block_mass": (1, 2)}
    assert config.model == {"spring_stiffness": 1000, "viscosity_coefficient": 5}
    assert type(config.model["viscosity_coefficient"]) is float
    point = xr.DataArray(250.0, name="temperature")  # such as ds.temperature[3]
    scalars = {"model": {"T": point, "K": np.array(1e3)}, "sweep": {"M": [np.array(1), 2]}}
    config = from_mapping(scalars | {"stationary": {"accelerate": np.False_}})
    assert config.model == {"temperature": 250, "spring_stiffness": 1000}
    assert (config.sweep, config.stationary.accelerate) == ({"block_mass": (1, 2)}, False)


@pytest.mark.parametrize(
    "mapping",
    [
        [],
        None,
        "model",
        {1: 2},
        {"model": {3: 1}},
        {"model": {"T": np.bool_(True)}},
        {"model": {"T": object()}},
        {"model": {"T": 10**5000}},
        {"sweep": {"T": {1, 2}}},
        {"sweep": {"T": np.zeros((2, 2))}},
        {"integrator": {"method": object()}},
        {"title": "\ud800"},
        {"model": {"a\nb": 1}},
    ],
    ids=range(13),
)
def test_python_users_get_readable_problems_too(mapping: Any) -> None:
    with pytest.raises(ConfigError) as caught:
        from_mapping(mapping)
    assert all(str(problem).startswith("<dict>: ") for problem in caught.value.problems)
    assert len(str(caught.value).splitlines()) == len(caught.value.problems)


def test_a_check_finds_the_line_of_its_key(tmp_path: Path) -> None:
    path = tmp_path / "f.yaml"
    path.write_text("integrator:\n  method: euler-cromer\n  dt: 1e-3\n")
    with pytest.raises(ConfigError) as caught:
        load(path, checks=[lambda config: [("integrator.dt", f"{config.integrator.dt} is a lot")]])
    assert str(caught.value) == f"{path}:3: integrator.dt: 0.001 is a lot"


def test_a_check_sees_sound_configs_only() -> None:
    with pytest.raises(ConfigError, match="unknown key"):
        from_mapping({"foo": 1}, checks=[lambda _: pytest.fail("called")])


def round_trip(config: Config) -> Config:
    overrides = [f"output={config.output}"]
    if config.execution.workers:
        overrides.append(f"execution.workers={config.execution.workers}")
    return from_yaml(config.resolved_yaml(), overrides=overrides)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_resolved_config_means_the_same(path: Path) -> None:
    config = load(path)
    again = round_trip(config)
    assert again == config
    assert again.resolved() == config.resolved()
    assert again.sha256() == config.sha256()
    assert again.parameters() == config.parameters()
    assert YAML(typ="safe", pure=True).load(config.resolved_yaml()) == config.resolved()
    assert json.loads(json.dumps(config.resolved(), allow_nan=False)) == config.resolved()


@example(title='\ufeffa\u2028b\x85c\uffff"\\b\n😀', value=0.0, axis=[0.0])
@settings(max_examples=200, deadline=None)
@given(
    title=st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1).filter(str.strip)
    | st.none(),
    value=st.floats(0, 1e300, allow_nan=False),
    axis=st.lists(st.floats(-0.99, 1e300), min_size=1, max_size=5, unique=True),
)
def test_any_title_and_any_float_survive_the_round_trip(
    title: str | None, value: float, axis: list[float]
) -> None:
    config = from_mapping({"title": title, "model": {"T": value}, "sweep": {"gamma": axis}})
    assert round_trip(config) == config
    assert round_trip(config).title == title


def test_resolved_holds_all_parameters_and_nothing_of_the_execution() -> None:
    resolved = from_yaml(EXAMPLE).resolved()
    given = [*resolved["model"], *resolved["sweep"], *resolved["cases"]]
    assert sorted(given) == sorted(PARAMETERS)
    assert "execution" not in resolved
    assert "output" not in resolved
    assert resolved["integrator"] == {"method": "adaptive", "rtol": 1e-6, "max_error": 1e-2}


def test_the_hash_depends_on_what_defines_the_numbers_and_nothing_else() -> None:
    base = from_yaml(EXAMPLE)
    same = ["title=x", "output=y.nc", "execution.workers=7", "plot.figure=time_courses"]
    for override in [*same, "simulation.periods=3", "K=3000", "T_c=290"]:
        assert from_yaml(EXAMPLE, overrides=[override]).sha256() == base.sha256(), override
    other = ["K=3001", "T=[150]", "integrator.rtol=1e-7", "stationary.max_periods=1", "T_c=291"]
    hashes = {from_yaml(EXAMPLE, overrides=[override]).sha256() for override in other}
    assert len(hashes | {base.sha256()}) == len(other) + 1


def test_the_hash_stays_what_it_was() -> None:
    # Changes with every change of what is hashed: results on disk would no longer be recognised.
    assert (
        from_mapping({}).sha256()
        == "93535d370342c9507bd882f319e6aabd64a62fa8859c92f4f10e0cb1673fd665"
    )


def test_equality_ignores_only_the_warnings() -> None:
    assert from_yaml("{}") == from_yaml("model: {T: 200}")
    assert from_yaml("{}") != from_yaml("{}", overrides=["output=x"])
    assert from_yaml("{}") != from_yaml("execution: {workers: 3}")
    assert hash(from_yaml("{}")) == hash(from_yaml("model: {T: 200}"))


def test_a_config_is_frozen_and_pickles() -> None:
    config = from_yaml(EXAMPLE)
    with pytest.raises(ValueError, match="frozen"):
        config.title = "x"  # type: ignore[misc]
    assert pickle.loads(pickle.dumps(config)) == config


def read_or_refuse(read: Callable[[], Config]) -> None:
    """Read and write a config; fail on anything but a ConfigError with a line for each problem."""
    try:
        read().resolved_yaml()
    except ConfigError as error:
        lines, problems = str(error).splitlines(), error.problems
        assert len(lines) == len(problems) > 0


@settings(max_examples=400, deadline=None)
@given(
    flips=st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=6
    )
)
def test_a_file_with_flipped_bytes_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, flips: list[tuple[float, int]]
) -> None:
    content = bytearray(EXAMPLE.encode())
    for place, byte in flips:
        content[int(place * len(content))] = byte
    path = tmp_path_factory.getbasetemp() / "flipped.yaml"
    path.write_bytes(content)
    read_or_refuse(lambda: load(path))


@settings(max_examples=200, deadline=None)
@given(
    cut=st.integers(0, len(EXAMPLE)), insert=st.text("\n\t :-,[]{}#&*!|>'\"%@`?~.<0", max_size=4)
)
def test_a_truncated_or_mangled_file_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, cut: int, insert: str
) -> None:
    path = tmp_path_factory.getbasetemp() / "mangled.yaml"
    for text in (EXAMPLE[:cut] + insert, EXAMPLE[:cut] + insert + EXAMPLE[cut:]):
        path.write_text(text)
        read_or_refuse(lambda: load(path))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=8,
)


SECTION = st.dictionaries(
    st.sampled_from([*PARAMETERS, "T", "k", "K", "method", "rtol", "dt", "treatment", "workers"]),
    JSON | st.fixed_dictionaries({"linspace": st.lists(JSON, max_size=3), "num": JSON}),
    max_size=4,
)


@settings(max_examples=300, deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(["model", "sweep", "cases", "integrator", "noise", "execution", "title"]),
        SECTION | JSON,
        max_size=4,
    )
)
def test_any_mapping_is_read_or_refused(mapping: dict[str, Any]) -> None:
    read_or_refuse(lambda: from_mapping(mapping))
