"""`follow` and `refine` of a config."""

from __future__ import annotations

import re

import pytest
from support.sweeps.configs import problems

from sweeps.config.load import from_mapping, from_yaml
from sweeps.config.refinement import Refine
from sweeps.identity import settings_of

NINE = "sweep: {T: {linspace: [200, 280], num: 9}, omega: {linspace: [10, 18], num: 9}}\n"


def test_a_config_follows_by_name_or_symbol() -> None:
    for name in ("omega", "angular_frequency"):
        config = from_yaml(f"{NINE}follow: {name}\n")
        assert config.follow == "angular_frequency"
        assert from_yaml(config.resolved_yaml()) == config


def test_the_followed_axis_is_part_of_the_identity_and_refinement_is_not() -> None:
    plain, follow = from_yaml(NINE), from_yaml(f"{NINE}follow: T\n")
    refine = from_yaml(f"{NINE}refine: {{axes: [T], levels: 2}}\n")
    assert settings_of(plain) == settings_of(refine)
    assert settings_of(follow) == settings_of(plain) | {"follow": "temperature"}
    assert len({config.sha256() for config in (plain, follow, refine)}) == 3


def test_neither_is_the_default() -> None:
    config = from_mapping({"follow": None, "refine": None, "sample": None})
    assert (config.follow, config.refine, config.sample) == (None, None, None)
    assert not {"follow", "refine", "sample"} & set(config.resolved())


@pytest.mark.parametrize(
    ("where", "miss"),
    [
        ("", 1e-2),
        (", where: [regime]", None),
        (", where: [regime, 1/20]", 0.05),
        (", where: regime", None),
    ],
)
def test_a_refinement_is_read(where: str, miss: float | None) -> None:
    config = from_yaml(f"{NINE}refine: {{axes: [T, omega], levels: 2{where}}}\n")
    axes = ("temperature", "angular_frequency")
    assert config.refine == Refine(axes=axes, levels=2, where=[miss or "regime"])
    assert config.refine.miss == miss
    assert from_yaml(config.resolved_yaml()) == config


@pytest.mark.parametrize(
    ("yaml", "message"),
    [
        ("follow: K", "2: follow: must name a swept axis, not 'K'; swept axes: temp"),
        ("follow: 3", "2: follow: must be text"),
        ("follow: T\nrefine: {axes: [omega]}", "follow: cannot be combined with `refine`"),
        ("follow: T\ncases: {K: [1e3, 2e3]}", "follow: cannot be combined with `cases`"),
        ("refine: 3", "refine: must be {axes: "),
        ("refine: {levels: 2}", "refine.axes: is missing; write {axes: "),
        ("refine: {axes: [T, T], levels: 2}", "refine.axes: names an axis twice"),
        ("refine: {axes: [Tt], levels: 2}", "must name a swept axis, not 'Tt'"),
        ("refine: {axes: [T], levels: 0}", "refine.levels: must be at least 1, not 0"),
        (
            "refine: {axes: [T], levels: 4}",
            "temperature has 9 values; 4 levels need one more than a multiple of 16, such as 17",
        ),
        ("refine: {axes: [T], level: 2}", "refine.level: unknown key .did you mean 'levels'"),
        ("refine: {axes: [T], where: [regme]}", r"refine.where\[0\]: must be regime or a number"),
        ("refine: {axes: [T], where: [2]}", "must be a fraction between 0 and 1, not 2"),
        ("refine: {axes: [T], where: [0.1, 0.2]}", "takes regime and at most one number"),
    ],
)
def test_an_impossible_follow_or_refine_is_refused(yaml: str, message: str) -> None:
    (problem,) = problems(f"{NINE}{yaml}\n")
    assert re.search(message.replace("{", r"\{"), problem), problem


@pytest.mark.parametrize("cases", ["cases: {K: [1e3, 2e3]}", "sample: {sobol: 4, K: [1e3, 2e3]}"])
def test_an_axis_is_followed_for_one_of_several_cases(cases: str) -> None:
    config = from_yaml(f"{NINE}follow: T\n{cases}\n", overrides=["case=1"])
    assert (config.follow, config.cases, config.sample) == ("temperature", {}, None)
    assert len(problems(f"{NINE}follow: T\n{cases}\n", "case=4")) == 2


@pytest.mark.parametrize("axis", [[200, 210, 300], [200, 300, 250], [0, 1, 10], [-1, 1, 10]])
def test_a_refined_axis_must_be_even(axis: list[float]) -> None:
    (problem,) = problems(f"sweep: {{x_0: {axis}}}\nrefine: {{axes: [x_0], levels: 1}}\n")
    assert "initial_displacement needs values with a constant step or ratio" in problem


@pytest.mark.parametrize(
    "axis",
    [
        [200, 250, 300],
        [300, 250, 200],
        [-400, -200, -100],
        "{geomspace: [1e-3, 7], num: 17}",
        "{linspace: [0.1, 0.3], num: 17}",
    ],
)
def test_even_axes_are_refined(axis: object) -> None:
    config = from_yaml(f"sweep: {{x_0: {axis}}}\nrefine: {{axes: [x_0], levels: 1}}\n")
    assert from_yaml(config.resolved_yaml()) == config


def test_a_followed_axis_must_rise_and_be_no_initial_value() -> None:
    (problem,) = problems("sweep: {T: [300, 200]}\nfollow: T\n")
    assert "needs the values of temperature in increasing order" in problem
    (problem,) = problems("sweep: {x_0: [0, 1e-7]}\nfollow: x_0\n")
    assert "cannot be initial_displacement: each point on a followed line starts from" in problem
