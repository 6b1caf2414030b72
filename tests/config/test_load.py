"""What a config means once it is accepted, how it is overridden, and that nothing else gets out."""

from __future__ import annotations

import json
import math
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS
from sweeps.config.json_schema import json_schema, json_schema_text
from sweeps.config.load import Config, ConfigError, from_mapping, from_yaml, load

CONFIGS = Path(__file__).parents[2] / "configs"
SHIPPED = sorted(CONFIGS.glob("*.yaml"))

EXAMPLE = """\
title: Fig. 7 - amplitudes
model:
  spring_stiffness: 3000
sweep:
  temperature: {linspace: [150, 320], num: 171}
  rheological_index: [-2/3, 0, 2/3]
cases:
  drive_amplitude: [0.4e-6, 0.8e-6]
  angular_frequency: [20, 10]
integrator: {method: adaptive, rtol: 1e-6}
stationary: {rtol: 1e-6, max_periods: 5000}
noise: {treatment: typical-path}
output: results/fig7.nc
execution: {workers: 2, backend: threads}
plot: {figure: amplitudes}
simulation: {periods: 6, start: initial, samples_per_period: 2000}
"""


def problems(yaml: str, *overrides: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        from_yaml(yaml, "f.yaml", overrides)
    return [str(problem) for problem in caught.value.problems]


# --- what a config means ---


def test_left_out_keys_take_the_values_of_the_example() -> None:
    example, empty = from_yaml(EXAMPLE), from_yaml("{}")
    for section in ("integrator", "stationary", "noise", "execution", "plot", "simulation"):
        assert getattr(example, section) == getattr(empty, section)
    assert (empty.title, empty.model, empty.sweep, empty.cases) == (None, {}, {}, {})


def test_an_empty_config_is_the_papers_fig_3() -> None:
    assert from_mapping({}).parameters() == Parameters()


def test_the_defaults_of_the_settings() -> None:
    config = from_mapping({})
    assert (config.integrator.method, config.integrator.rtol) == ("adaptive", 1e-6)
    assert (config.integrator.dt, config.integrator.max_steps) == (1e-10, None)
    assert (config.stationary.rtol, config.stationary.max_periods) == (1e-6, 5000)
    assert (config.noise.treatment, config.noise.seed) == ("typical-path", None)
    assert (config.execution.workers, config.execution.backend) == (2, "threads")
    assert (config.execution.scheduler, config.execution.block_points) == (None, None)
    assert config.plot.figure == "amplitudes"
    simulation = config.simulation
    assert (simulation.periods, simulation.start) == (6, "initial")
    assert simulation.samples_per_period == 2000


def test_symbols_and_names_mean_the_same() -> None:
    by_symbol = {v.symbol: v.default for v in PARAMETERS.values()}
    by_name = {name: by_symbol[v.symbol] for name, v in PARAMETERS.items()}
    assert from_mapping({"model": by_symbol}) == from_mapping({"model": by_name})
    assert list(from_mapping({"model": by_symbol}).model) == list(PARAMETERS)


def test_k_and_K_are_different_parameters() -> None:
    config = from_yaml("model: {k: 1e4, K: 100}")
    assert config.model == {"viscosity_coefficient": 1e4, "spring_stiffness": 100.0}


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


@pytest.mark.parametrize(
    ("axis", "values"),
    [
        ("[3, 1, 2]", (3, 1, 2)),
        ("[-1/2, 1/2]", (-0.5, 0.5)),
        ("{linspace: [0, 1], num: 5}", (0, 0.25, 0.5, 0.75, 1)),
        ("{linspace: [1, 0], num: 2}", (1, 0)),
        ("{num: 2, linspace: [0, 1/2]}", (0, 0.5)),
        ("{linspace: [7, 9], num: 1}", (7,)),
        ("{arange: [0, 1, 0.25]}", (0, 0.25, 0.5, 0.75, 1)),
        ("{arange: [0, 0.9, 0.25]}", (0, 0.25, 0.5, 0.75)),
        ("{arange: [1, 0, -0.5]}", (1, 0.5, 0)),
        ("{arange: [2, 2, 1]}", (2,)),
    ],
)
def test_forms_of_an_axis(axis: str, values: tuple[float, ...]) -> None:
    assert from_yaml(f"sweep: {{x_0: {axis}}}").sweep["initial_displacement"] == values


def test_geomspace_takes_values_not_exponents() -> None:
    values = from_yaml("sweep: {k: {geomspace: [1e4, 1e6], num: 3}}").sweep
    assert values["viscosity_coefficient"] == pytest.approx((1e4, 1e5, 1e6), rel=1e-12)
    assert (values["viscosity_coefficient"][0], values["viscosity_coefficient"][-1]) == (1e4, 1e6)


def test_arange_includes_a_stop_that_rounding_would_lose() -> None:
    values = from_yaml("sweep: {T: {arange: [0, 0.3, 0.1]}}").sweep["temperature"]
    assert len(values) == 4
    assert values[-1] == 0.3  # 3 * 0.1 is 0.30000000000000004
    short = from_yaml("sweep: {T: {arange: [0, 0.3000001, 0.1]}}").sweep["temperature"]
    assert short == (0.0, 0.1, 0.2, 0.3)  # the floats that these decimals are


def test_the_order_of_the_axes_is_kept_and_counts() -> None:
    one, other = from_yaml("sweep: {T: [1], k: [2]}"), from_yaml("sweep: {k: [2], T: [1]}")
    assert list(one.sweep) == ["temperature", "viscosity_coefficient"]
    assert one != other
    assert one.sha256() != other.sha256()


def test_python_users_may_hand_over_arrays_and_numbers_of_numpy() -> None:
    axis = np.linspace(150, 320, 3)
    config = from_mapping(
        {"model": {"K": np.float64(1e3), "k": np.int64(5)}, "sweep": {"T": axis, "M": (1, 2)}}
    )
    assert config.sweep == {"temperature": (150, 235, 320), "block_mass": (1, 2)}
    assert config.model == {"spring_stiffness": 1000, "viscosity_coefficient": 5}
    assert type(config.model["viscosity_coefficient"]) is float


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


def test_a_dict_that_contains_itself_is_refused() -> None:
    endless: dict[str, Any] = {}
    endless["model"] = endless
    with pytest.raises(ConfigError, match="nested too deeply"):
        from_mapping(endless)


# --- how problems are told ---


def test_all_problems_are_told_at_once_in_the_order_of_the_lines() -> None:
    text = """\
titel: x
model: &m
  temprature: 200
  T: 200
  T: 250
  K: 3000 N/m
  gamma: -1
sweep:
  T: [200]
  k: []
  omega: {linspace: [1, b], num: 0}
cases: {A: [1, 2], h: [1]}
integrator: {method: rk4, rtol: 0, dtt: 1}
noise: {treatment: none}
execution: {workers: 0}
output: 3
"""
    told = problems(text)
    expected = [
        "f.yaml:1: titel: unknown key (did you mean 'title'?)",
        "f.yaml:2: model: the anchor &m",
        "f.yaml:3: model.temprature: unknown parameter (did you mean 'temperature'?)",
        "f.yaml:5: model.T: is given twice (first in line 4)",
        "f.yaml:6: model.K: must be a number, not '3000 N/m'; write the number alone",
        "f.yaml:7: model.gamma: must be greater than -1",
        "f.yaml:9: sweep.T: gives temperature a second time, after model.T in line 4",
        "f.yaml:10: sweep.k: has no values",
        "f.yaml:11: sweep.omega.linspace[1]: must be a number, not 'b'",
        "f.yaml:11: sweep.omega.num: must be at least 1, not 0",
        "f.yaml:12: cases: linked parameters need equally many values",
        "f.yaml:13: integrator.method: must be 'adaptive' or 'euler-cromer', not 'rk4'",
        "f.yaml:13: integrator.rtol: must be greater than 1e-13, not 0",
        "f.yaml:13: integrator.dtt: unknown key (did you mean 'dt'?)",
        "f.yaml:14: noise.treatment: initial_order_parameter (phi_0) is 0 without noise",
        "f.yaml:15: execution.workers: must be at least 1, not 0",
        "f.yaml:16: output: must be a text, not 3",
    ]
    assert len(told) == len(expected)
    for line, start in zip(told, expected, strict=True):
        assert line.startswith(start)


def test_a_refused_value_causes_no_further_problems() -> None:
    assert len(problems("model: {D: x}\nsweep: {phi_0: [0, 1]}")) == 1
    assert len(problems("model: {phi_0: x}\nnoise: {treatment: none}")) == 1
    assert len(problems("model: 3\nnoise: {treatment: none}")) == 1
    assert len(problems("sweep: {T: [1, *x]}\ncases: {k: *y}\nintegrator: *z")) == 3
    assert len(problems("integrator: {rtol: *x}\nstationary: {rtol: *y}")) == 2
    assert len(problems("noise: {treatment: stochastic, seed: 3, realizations: 5}")) == 1


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("temprature", "temperature"),
        ("Temperature", "temperature"),
        ("stiffness", "spring_stiffness"),
        ("viscosity", "viscosity_coefficient"),
        ("gama", "gamma"),
        ("Tc", "T_c"),
        ("phi0", "phi_0"),
        ("Xm", "X_m"),
    ],
)
def test_the_parameter_that_is_meant_is_guessed(key: str, meant: str) -> None:
    (told,) = problems(f"model: {{{key}: 1}}")
    assert told.endswith(f"(did you mean {meant!r}?)")


def test_one_line_for_each_problem_whatever_the_text_contains() -> None:
    told = problems('model: {"a\\nb": 1, "\\u2028": 2, T: "x\\ny"}\n"\\r": 1')
    assert len(told) == 4
    assert all(len(line.splitlines()) == 1 for line in told)


@pytest.mark.parametrize("name", ["", "nothing.yaml", "nul\0byte.yaml", "x" * 5000 + ".yaml"])
def test_a_file_that_cannot_be_read_is_told(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match="cannot be read"):
        load(tmp_path / name)


def test_a_fifo_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os = pytest.importorskip("os")
    os.mkfifo(tmp_path / "fifo.yaml")
    with pytest.raises(ConfigError, match="not a regular file"):
        load(tmp_path / "fifo.yaml")


def test_the_error_survives_pickling() -> None:
    with pytest.raises(ConfigError) as caught:
        from_yaml("a: 1")
    copy = pickle.loads(pickle.dumps(caught.value))
    assert copy.problems == caught.value.problems
    assert str(copy) == str(caught.value)


def test_warnings_name_their_place_and_are_not_printed(capsys: pytest.CaptureFixture[str]) -> None:
    config = from_yaml("model:\n  k: 3000\n  K: 5e4\nsweep:\n  T: [1, 1.0000000001]\n", "f.yaml")
    assert [w.partition(" ")[0] for w in config.warnings] == ["f.yaml:5:", "f.yaml:3:"]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("k", "K", "exchanged"),
    [(5e4, 3e3, 0), (3e3, 5e4, 1), (10, 1e6, 1), (1e4, 1e4, 0), (3e3, 3e3, 0), (1e5, 1e5, 0)],
)
def test_exchanged_k_and_K_are_noticed(k: float, K: float, exchanged: int) -> None:
    assert len(from_mapping({"model": {"k": k, "K": K}}).warnings) == exchanged
    assert (
        len(from_mapping({"sweep": {"k": [k, k * 1.5]}, "model": {"K": K}}).warnings) == exchanged
    )


# --- overrides ---


def test_an_override_fixes_a_parameter_by_name_or_symbol() -> None:
    for key in ("temperature", "T", "model.temperature", "model.T"):
        config = from_yaml("model: {T: 200, K: 100}", overrides=[f"{key}=250"])
        assert config.model == {"temperature": 250, "spring_stiffness": 100}


def test_a_number_for_a_swept_parameter_takes_its_axis_away() -> None:
    config = from_yaml("sweep: {T: [1, 2], k: [3, 4]}", overrides=["temperature=250"])
    assert config.model == {"temperature": 250}
    assert config.sweep == {"viscosity_coefficient": (3, 4)}


@pytest.mark.parametrize("value", ["[7, 8]", "{linspace: [7, 8], num: 2}"])
@pytest.mark.parametrize("key", ["T", "temperature", "sweep.T", "sweep.temperature"])
def test_an_axis_replaces_an_axis_in_its_place(key: str, value: str) -> None:
    config = from_yaml("sweep: {T: [1, 2], k: [3, 4]}", overrides=[f"{key}={value}"])
    assert list(config.sweep) == ["temperature", "viscosity_coefficient"]
    assert config.sweep["temperature"] == (7, 8)


def test_an_axis_for_a_fixed_parameter_is_put_behind_the_others() -> None:
    config = from_yaml("model: {T: 1}\nsweep: {k: [3, 4]}", overrides=["T=[7, 8]"])
    assert list(config.sweep) == ["viscosity_coefficient", "temperature"]
    assert config.model == {}


def test_a_parameter_of_cases_is_replaced_by_a_list_only() -> None:
    text = "cases: {T: [1, 2], k: [3, 4]}"
    assert from_yaml(text, overrides=["T=[7, 8]"]).cases["temperature"] == (7, 8)
    assert problems(text, "T=7") == [
        "--set T=7: T: is linked in `cases`; pick one case with --set case=0, or give a list"
    ]
    assert "equally many" in problems(text, "T=[7, 8, 9]")[0]


def test_a_case_is_picked() -> None:
    config = from_yaml("cases: {T: [1, 2], k: [3, 4]}\nmodel: {K: 5}", overrides=["case=1"])
    assert config.model == {"spring_stiffness": 5, "temperature": 2, "viscosity_coefficient": 4}
    assert config.cases == {}


@pytest.mark.parametrize(
    ("text", "override", "told"),
    [
        ("cases: {T: [1, 2]}", "case=2", "case: must be 0 ... 1"),
        ("cases: {T: [1, 2]}", "case=-1", "case: must be 0 ... 1"),
        ("cases: {T: [1, 2]}", "case=x", "case: must be a number, not 'x'"),
        ("{}", "case=0", "case: there are no `cases` to pick from"),
        ("{}", "T", "must be KEY=VALUE"),
        ("{}", "=3", "must be KEY=VALUE"),
        ("{}", "T=", "model.temperature: must be a number, not nothing"),
        ("{}", "T=-1", "model.temperature: must be at least 0, not -1.0"),
        ("{}", "T=1e3 K", "write the number alone"),
        ("{}", "T=[1", "not valid YAML"),
        ("{}", "T=*a", "alias"),
        ("{}", "T=1\n---\n2", "second document"),
        ("{}", "temprature=3", "unknown key (did you mean 'temperature'?)"),
        ("{}", "model.temprature=3", "unknown parameter (did you mean 'temperature'?)"),
        ("{}", "integrator.rtoll=3", "integrator.rtoll: unknown key (did you mean 'rtol'?)"),
        ("{}", "integrator.rtol.x=3", "integrator.rtol: must be a number, not a mapping"),
        ("{}", "integrator=3", "integrator: must hold lines"),
        ("title: x", "title.y=3", "title.y: there are no keys below title"),
        ("{}", "integrator" + ".x" * 5000 + "=3", "unknown key"),
        ("{}", "title=\udcff", "contains a control character"),
    ],
)
def test_problems_of_an_override_name_it(text: str, override: str, told: str) -> None:
    (line,) = problems(text, override)
    assert line.startswith("--set ")
    assert told in line
    assert len(line) < 400


def test_a_parameter_set_twice_is_refused() -> None:
    (line,) = problems("{}", "T=1", "temperature=2")
    assert "is set twice, first by --set T=1" in line


def test_dotted_paths_reach_every_section() -> None:
    config = from_yaml(
        "integrator: {rtol: 1e-6}",
        overrides=["integrator.rtol=1e-8", "plot.figure=time_courses", "output=a.nc", "title=x"],
    )
    assert (config.integrator.rtol, config.plot.figure) == (1e-8, "time_courses")
    assert (config.output, config.title) == ("a.nc", "x")
    whole = from_yaml(
        "integrator: {rtol: 1e-6}", overrides=["integrator={method: euler-cromer, dt: 1e-9}"]
    )
    assert (whole.integrator.method, whole.integrator.dt) == ("euler-cromer", 1e-9)


def test_problems_of_the_file_and_of_the_overrides_are_told_together() -> None:
    told = problems("model: {K: x}", "T=-1", "foo=1")
    assert {line.split(": ")[0] for line in told} == {"f.yaml:1", "--set T=-1", "--set foo=1"}


# --- the seam for checks that need the physics ---


def test_a_check_finds_the_line_of_its_key(tmp_path: Path) -> None:
    path = tmp_path / "f.yaml"
    path.write_text("integrator:\n  method: euler-cromer\n  dt: 1e-3\n")
    with pytest.raises(ConfigError) as caught:
        load(path, checks=[lambda config: [("integrator.dt", f"{config.integrator.dt} is a lot")]])
    assert str(caught.value) == f"{path}:3: integrator.dt: 0.001 is a lot"


def test_a_check_sees_sound_configs_only() -> None:
    with pytest.raises(ConfigError, match="unknown key"):
        from_mapping({"foo": 1}, checks=[lambda _: pytest.fail("called")])


# --- identity and round trip ---


def round_trip(config: Config) -> Config:
    overrides = [f"output={config.output}", f"execution.workers={config.execution.workers}"]
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


def test_readers_of_yaml_1_1_see_the_same_numbers() -> None:
    reader = YAML(typ="safe", pure=True)
    reader.version = (1, 1)
    config = from_yaml("sweep: {h: [1e-9, 1e-300, 2.5e-9, 1e300]}\ntitle: 'no'")
    assert reader.load(config.resolved_yaml()) == config.resolved()


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


@pytest.mark.parametrize(
    "title", ["a\u2028b", "a\x85b", "\ufeffa", "a\uffffb", 'a"\\b', "a\nb", "😀"]
)
def test_titles_with_odd_characters_survive_the_round_trip(title: str) -> None:
    assert round_trip(from_mapping({"title": title})).title == title


def test_resolved_holds_all_parameters_and_nothing_of_the_execution() -> None:
    resolved = from_yaml(EXAMPLE).resolved()
    given = [*resolved["model"], *resolved["sweep"], *resolved["cases"]]
    assert sorted(given) == sorted(PARAMETERS)
    assert "execution" not in resolved
    assert "output" not in resolved
    assert resolved["integrator"] == {"method": "adaptive", "rtol": 1e-6}


def test_the_hash_sees_what_defines_the_numbers_and_nothing_else() -> None:
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
        == "6ea8837173455b0e3ec2c22617b82f5891043cc7ace8c1ba7a8622354a56adb2"
    )


def test_equality_looks_at_everything_but_the_warnings() -> None:
    assert from_yaml("{}") == from_yaml("model: {T: 200}")
    assert from_yaml("{}") != from_yaml("{}", overrides=["output=x"])
    assert from_yaml("{}") != from_yaml("execution: {workers: 3}")
    assert hash(from_yaml("{}")) == hash(from_yaml("model: {T: 200}"))


def test_a_config_is_frozen_and_pickles() -> None:
    config = from_yaml(EXAMPLE)
    with pytest.raises(ValueError, match="frozen"):
        config.title = "x"  # type: ignore[misc]
    assert pickle.loads(pickle.dumps(config)) == config


# --- the shipped configs and the schema ---


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_config_says_what_it_produces(path: Path) -> None:
    claim, editor, *_ = path.read_text().splitlines()
    assert claim.startswith("# ")
    assert len(claim) > 60
    assert editor == "# yaml-language-server: $schema=stickslip.schema.json"
    config = load(path)
    assert config.title
    assert config.output == f"results/{path.stem}.nc"
    assert config.warnings == ()


def test_the_configs_that_others_rely_on_are_shipped() -> None:
    shipped = {path.stem for path in SHIPPED}
    assert {"quickstart", "fig3", "fig5", "fig7", "fig8", "fig9", "cube"} <= shipped


def test_the_shipped_schema_is_the_current_one() -> None:
    shipped = json.loads((CONFIGS / "stickslip.schema.json").read_text())
    assert shipped == json.loads(json_schema_text()) == json_schema()


def schema_accepts(config: Any) -> bool:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(json_schema())
    return bool(jsonschema.Draft202012Validator(json_schema()).is_valid(config))


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
        ("modle: {}", False),
        ("model: {temprature: 1}", False),
        ("model: {T: -1}", False),
        ("model: {T: '200'}", False),
        ("model: {X_m: 0}", False),
        ("model: {gamma: -1}", False),
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
    properties = json_schema()["properties"]["model"]["properties"]
    for name, variable in PARAMETERS.items():
        for key in (name, variable.symbol):
            assert f"[{variable.units}]" in properties[key]["description"]


# --- nothing but a Config or a ConfigError ---


def read_or_refuse(read: Callable[[], Config]) -> None:
    """Read and write a config; anything else than a ConfigError with a line each gets out."""
    try:
        read().resolved_yaml()
    except ConfigError as error:
        lines, told = str(error).splitlines(), error.problems
        assert len(lines) == len(told) > 0


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


def test_importing_the_config_is_light() -> None:
    heavy = ("numba", "xarray", "matplotlib", "scipy", "netCDF4", "joblib", "typer")
    code = f"import sys, sweeps.config; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("coarse", "fine"),
    [
        ("linspace: [0, 1], num: 11", "linspace: [0, 5], num: 501"),
        ("linspace: [0.1, 0.7], num: 7", "arange: [0, 1, 0.05]"),
        ("linspace: [150, 320], num: 8", "linspace: [150, 320], num: 15"),
        ("geomspace: [1e4, 3e6], num: 7", "geomspace: [1e4, 3e6], num: 19"),
        ("geomspace: [1e-3, 7], num: 4", "geomspace: [1e-3, 7], num: 10"),
    ],
)
def test_a_refined_axis_has_the_same_floats_as_the_coarse_one(coarse: str, fine: str) -> None:
    few, many = (
        from_yaml(f"sweep: {{x_0: {{{axis}}}}}").sweep["initial_displacement"]
        for axis in (coarse, fine)
    )
    assert set(few) < set(many)


def test_values_of_an_axis_are_the_decimals_that_they_stand_for() -> None:
    tenths = from_yaml("sweep: {x_0: {linspace: [0, 1], num: 11}}").sweep["initial_displacement"]
    assert tenths == (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
