"""`--set KEY=VALUE`: its changes, and messages about refused ones."""

from __future__ import annotations

import pytest
from support.sweeps.configs import problems

from sweeps.config.load import from_mapping, from_yaml


def test_an_override_fixes_a_parameter_by_name_or_symbol() -> None:
    for key in ("temperature", "T", "model.temperature", "model.T"):
        config = from_yaml("model: {T: 200, K: 100}", overrides=[f"{key}=250"])
        assert config.model == {"temperature": 250, "spring_stiffness": 100}


def test_a_number_for_a_swept_parameter_removes_its_axis() -> None:
    config = from_yaml("sweep: {T: [1, 2], k: [3, 4]}", overrides=["temperature=250"])
    assert config.model == {"temperature": 250}
    assert config.sweep == {"viscosity_coefficient": (3, 4)}


@pytest.mark.parametrize("value", ["[7, 8]", "{linspace: [7, 8], num: 2}"])
@pytest.mark.parametrize("key", ["T", "temperature", "sweep.T", "sweep.temperature"])
def test_an_axis_replaces_an_axis_in_its_place(key: str, value: str) -> None:
    config = from_yaml("sweep: {T: [1, 2], k: [3, 4]}", overrides=[f"{key}={value}"])
    assert list(config.sweep) == ["temperature", "viscosity_coefficient"]
    assert config.sweep["temperature"] == (7, 8)


@pytest.mark.parametrize("key", ["T", "temperature"])
def test_a_scheduled_parameter_is_replaced_by_name_or_symbol(key: str) -> None:
    for written in ("T", "temperature"):
        text = f"simulation: {{schedule: {{{written}: [200, 250]}}}}"
        config = from_yaml(text, overrides=[f"simulation.schedule.{key}=[1, 2, 3]"])
        assert config.simulation.schedule == {"temperature": (1.0, 2.0, 3.0)}


def test_an_axis_for_a_fixed_parameter_comes_after_the_others() -> None:
    config = from_yaml("model: {T: 1}\nsweep: {k: [3, 4]}", overrides=["T=[7, 8]"])
    assert list(config.sweep) == ["viscosity_coefficient", "temperature"]
    assert config.model == {}


def test_only_a_list_replaces_a_parameter_of_cases() -> None:
    text = "cases: {T: [1, 2], k: [3, 4]}"
    assert from_yaml(text, overrides=["T=[7, 8]"]).cases["temperature"] == (7, 8)
    assert problems(text, "T=7") == [
        "--set T=7: T: is linked in `cases` and cannot be set alone; pick one case with "
        "--set case=0, or give a list"
    ]
    assert "need the same number of values" in problems(text, "T=[7, 8, 9]")[0]


def test_a_parameter_of_a_sample_is_refused_with_the_ways_out() -> None:
    text = "sample: {sobol: 4, T: [150, 320], k: [4e4, 5e4]}"
    for change in ("temperature=200", "T=[200, 250]"):
        (message,) = problems(text, change)
        assert message.startswith(f"--set {change}: ")
        assert message.endswith(
            "is drawn by `sample`; pick one case with --set case=0, or change its range with "
            "--set 'sample.T=[LOW, HIGH]'"
        )
    config = from_yaml(text, overrides=["sample.T=[200, 250]"])
    assert min(config.cases["temperature"]) >= 200.0
    assert from_yaml(text, overrides=["case=0"]).model.keys() == config.cases.keys()


def test_a_case_is_picked() -> None:
    config = from_yaml("cases: {T: [1, 2], k: [3, 4]}\nmodel: {K: 5}", overrides=["case=1"])
    assert config.model == {"spring_stiffness": 5, "temperature": 2, "viscosity_coefficient": 4}
    assert config.cases == {}


@pytest.mark.parametrize(
    ("text", "override", "message"),
    [
        ("cases: {T: [1, 2]}", "case=2", "case: must be between 0 and 1"),
        ("cases: {T: [1, 2]}", "case=-1", "case: must be between 0 and 1"),
        ("cases: {T: [1, 2]}", "case=x", "case: must be a number, not 'x'"),
        ("{}", "case=0", "case: there are no `cases` to pick from"),
        ("{}", "T", "must be KEY=VALUE"),
        ("{}", "=3", "must be KEY=VALUE"),
        ("{}", "T=", "model.temperature: must be a number, not an empty value"),
        ("{}", "T=-1", "model.temperature: must be at least 0, not -1.0"),
        ("{}", "T=1e3 K", "write the number alone"),
        ("{}", "T=[1", "not valid YAML"),
        ("{}", "T=*a", "alias"),
        ("{}", "T=1\n---\n2", "second document"),
        ("{}", "temprature=3", "unknown key (did you mean 'temperature'?)"),
        ("{}", "model.temprature=3", "unknown parameter (did you mean 'temperature'?)"),
        ("{}", "velocity=1e-5", "it belongs under `simulation.drive`: simulation.drive.velocity"),
        ("{}", "rtol=1e-5", "under `integrator` or `stationary`: integrator.rtol or stationary."),
        ("{}", "simulation.velocity=1e-5", "it belongs under `drive`: drive.velocity"),
        ("{}", "integrator.rtoll=3", "integrator.rtoll: unknown key (did you mean 'rtol'?)"),
        ("{}", "integrator.rtol.x=3", "integrator.rtol: must be a number, not a mapping"),
        ("{}", "integrator=3", "integrator: must consist of lines"),
        ("title: x", "title.y=3", "title.y: there are no keys below title"),
        ("{}", "integrator" + ".x" * 5000 + "=3", "unknown key"),
        ("{}", "title=\udcff", "contains a control character"),
        ("{}", "title=run #3", "title: ' #' begins a comment; put the value in quotes"),
    ],
)
def test_problems_of_an_override_name_it(text: str, override: str, message: str) -> None:
    (line,) = problems(text, override)
    assert line.startswith("--set ")
    assert message in line
    assert len(line) < 400


def test_a_number_sign_in_quotes_begins_no_comment() -> None:
    assert from_mapping({}, overrides=["title='run #3'"]).title == "run #3"
    assert from_mapping({}, overrides=["title=run#3"]).title == "run#3"


def test_a_parameter_set_twice_is_refused() -> None:
    (line,) = problems("{}", "T=1", "temperature=2")
    assert "is set twice, first by --set T=1" in line


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("model.T=1", "model.temperature=2"),
        ("T=1", "model.temperature=2"),
        ("T=1", "model={K: 100}"),
        ("sweep.T=[1, 2]", "T=3"),
        ("integrator.rtol=1e-8", "integrator={max_error: 0.1}"),
    ],
)
def test_an_override_does_not_undo_an_earlier_one_in_silence(first: str, second: str) -> None:
    assert f"would undo --set {first}" in "\n".join(problems("{}", first, second))


def test_a_key_is_changed_after_its_section() -> None:
    config = from_yaml("{}", overrides=["model={K: 100}", "T=1", "integrator.rtol=1e-8"])
    assert config.model == {"spring_stiffness": 100, "temperature": 1}


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


def test_problems_of_the_file_and_of_the_overrides_are_reported_together() -> None:
    found = problems("model: {K: x}", "T=-1", "foo=1")
    assert {line.split(": ")[0] for line in found} == {"f.yaml:1", "--set T=-1", "--set foo=1"}
