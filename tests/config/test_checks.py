"""The parameters of a config, judged together: names and symbols, swapped values, other units."""

from __future__ import annotations

import pytest
from support.sweeps.configs import problems

from stickslip.variables import BY_SYMBOL, PARAMETERS
from sweeps.config.checks import warnings_of_columns
from sweeps.config.load import ConfigError, from_mapping, from_yaml


def test_symbols_and_names_mean_the_same() -> None:
    by_symbol = {v.symbol: v.default for v in PARAMETERS.values()}
    by_name = {name: by_symbol[v.symbol] for name, v in PARAMETERS.items()}
    assert from_mapping({"model": by_symbol}) == from_mapping({"model": by_name})
    assert list(from_mapping({"model": by_symbol}).model) == list(PARAMETERS)


def test_k_and_K_are_different_parameters() -> None:
    config = from_yaml("model: {k: 1e4, K: 100}")
    assert config.model == {"viscosity_coefficient": 1e4, "spring_stiffness": 100.0}


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
def test_the_closest_parameter_is_suggested(key: str, meant: str) -> None:
    (problem,) = problems(f"model: {{{key}: 1}}")
    assert problem.endswith(f"(did you mean {meant!r}?)")


@pytest.mark.parametrize(
    ("k", "K", "exchanged"),
    [(5e4, 3e3, 0), (3e3, 5e4, 1), (10, 1e6, 1), (1e4, 1e4, 0), (3e3, 3e3, 0), (1e5, 1e5, 0)],
)
def test_exchanged_k_and_K_are_noticed(k: float, K: float, exchanged: int) -> None:
    assert len(from_mapping({"model": {"k": k, "K": K}}).warnings) == exchanged
    assert (
        len(from_mapping({"sweep": {"k": [k, k * 1.5]}, "model": {"K": K}}).warnings) == exchanged
    )


@pytest.mark.parametrize("section", ["model: {%s: %s}", "sweep: {%s: [%s]}", "cases: {%s: [%s]}"])
@pytest.mark.parametrize("value", [".nan", ".inf", "-.inf", "1e400", "true", "abc", "[]", "{}"])
def test_every_parameter_refuses_values_that_are_no_finite_number(section: str, value: str) -> None:
    for name in PARAMETERS:
        with pytest.raises(ConfigError) as caught:
            from_yaml(section % (name, value))
        assert {p.line for p in caught.value.problems} == {1}


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ({"T_c": 27}, "T_c = 27 K is -246 degrees Celsius"),
        ({"a": 3}, "a = 3 Pa, against 4e+12 in the paper: is it in another unit?"),
        ({"h": 1}, "h = 1 m, against 1e-09"),
        ({"X_m": -0.8}, "X_m = -0.8 m"),
    ],
)
def test_values_of_another_unit_are_noticed(model: dict[str, float], message: str) -> None:
    (name,) = model
    (warning,) = from_mapping({"model": model}).warnings
    assert message in str(warning)
    swept = from_mapping({"sweep": {name: [model[name], PARAMETERS[BY_SYMBOL[name]].default]}})
    assert message in str(swept.warnings[0])


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"temperature": [20, 40, 60, 80, 100]}, "d.csv: T = 20 K is -253 degrees Celsius"),
        ({"temperature": [75, 85, 95]}, "d.csv: T = 75 K is -198 degrees Celsius"),
        ({"film_thickness": [1.0, 2.0]}, "d.csv: h = 1 m, against 1e-09 in the paper"),
        ({"spring_stiffness": [5e4, 6e4]}, "d.csv: K = 50000 N/m with k = 3000: both are far"),
        ({"temperature": [80, 110]}, None),
        ({"temperature": [80]}, None),
        ({"angular_frequency": [1, 100]}, None),
    ],
)
def test_columns_of_data_are_checked_as_the_axes_of_a_config(
    columns: dict[str, list[float]], message: str | None
) -> None:
    config = from_mapping({"model": {"k": 3000, "X_m": 1e-3}})  # no warning about its own values
    found = warnings_of_columns(columns, config, "d.csv")
    assert [message] == [line[: len(message)] for line in found] if message else not found


@pytest.mark.parametrize(
    "model",
    [
        {"T": 0},
        {"T": 80},
        {"a": 0},
        {"K": 0},
        {"k": 10, "gamma": 2 / 3},
        {"D": 1e-30},
        {"d": 3, "e": 5},
    ],
)
def test_unusual_values_are_not_taken_for_another_unit(model: dict[str, float]) -> None:
    assert not from_mapping({"model": model}).warnings


def test_the_largest_grid_of_coefficients_is_checked_quickly() -> None:
    axis = "{linspace: [1, 2], num: 1000}"
    config = from_yaml(f"sweep: {{c: {axis}, d: {axis}, e: {axis}}}")
    assert len(config.sweep) == 3
    assert (
        "otherwise the order parameter grows without bound"
        in problems(f"sweep: {{c: {axis}, d: {axis}, e: [0, 1]}}")[0]
    )


def test_a_grid_that_is_too_large_gets_no_further_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sweeps.config.checks.MAX_POINTS", 3)
    (problem,) = problems("sweep: {d: [0, 1], e: [0, 1]}")
    assert "4 points exceed the limit of 3" in problem
