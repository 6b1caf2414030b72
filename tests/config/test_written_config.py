"""How problems of a config are reported: all at once, a line for each, with its place."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from support.sweeps.configs import problems

from sweeps.config.load import ConfigError, from_mapping, from_yaml


def test_a_dict_that_contains_itself_is_refused() -> None:
    endless: dict[str, Any] = {}
    endless["model"] = endless
    with pytest.raises(ConfigError, match="nested too deeply"):
        from_mapping(endless)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.ma.array([200.0, 999.0], mask=[False, True]), "must have no masked values"),
        (np.array([10, 20], "m8[ns]"), "must be a number in SI units, not a time of NumPy"),
        (np.array(["1970-01-01"], "M8[ns]"), "must be a number in SI units, not a time"),
    ],
)
def test_arrays_that_are_no_plain_numbers_are_refused(values: Any, message: str) -> None:
    with pytest.raises(ConfigError, match=rf"sweep\.T: {message}"):
        from_mapping({"sweep": {"T": values}})
    with pytest.raises(ConfigError, match=r"model\.T: must be a number in SI units, not a time"):
        from_mapping({"model": {"T": np.timedelta64(10, "ns")}})


def test_all_problems_are_reported_at_once_in_the_order_of_the_lines() -> None:
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
    found = problems(text)
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
        "f.yaml:12: cases: linked parameters need the same number of values",
        "f.yaml:13: integrator.method: must be 'adaptive' or 'euler-cromer', not 'rk4'",
        "f.yaml:13: integrator.rtol: must be greater than 1e-13, not 0",
        "f.yaml:13: integrator.dtt: unknown key (did you mean 'dt'?)",
        "f.yaml:14: noise.treatment: initial_order_parameter (phi_0) is 0 with noise off",
        "f.yaml:15: execution.workers: must be at least 1, not 0",
        "f.yaml:16: output: must be text, not 3",
    ]
    assert len(found) == len(expected)
    for line, start in zip(found, expected, strict=True):
        assert line.startswith(start)


def test_a_refused_value_causes_no_further_problems() -> None:
    assert len(problems("model: {D: x}\nsweep: {phi_0: [0, 1]}")) == 1
    assert len(problems("model: {phi_0: x}\nnoise: {treatment: none}")) == 1
    assert len(problems("model: 3\nnoise: {treatment: none}")) == 1
    assert len(problems("sweep: {T: [1, *x]}\ncases: {k: *y}\nintegrator: *z")) == 3
    assert len(problems("integrator: {rtol: *x}\nstationary: {rtol: *y}")) == 2
    assert len(problems("sweep: {T: [x], k: [1]}\nfollow: T")) == 1
    assert len(problems("sweep: {T: [1, 2]}\nrefine: {axes: [T], levels: x}")) == 1
    assert len(problems("sweep: {Tx: {linspace: 3}}")) == 1
    assert len(problems("sample: {sobol: 4, Tx: 3, T: [1, 2]}")) == 1
    assert len(problems("noise: {treatment: random, seed: 3, realizations: 5}")) == 1


def test_a_refused_value_hides_no_other_problem_of_its_section() -> None:
    found = problems("simulation: {periods: 0, schedule: {T: [-1], x_0: [0]}}")
    assert [line.split(": ")[1] for line in found] == [
        "simulation.periods",
        "simulation.schedule.T[0]",
        "simulation.schedule.x_0",
    ]


def test_a_page_of_keys_is_one_problem() -> None:
    found = problems("".join(f"key{number}: 1\n" for number in range(5000)))
    assert found == ["f.yaml:2001: has more than 2000 keys, too many for a config"]


def test_a_page_in_a_list_gives_a_thousand_problems() -> None:
    found = problems("sweep:\n  T: [" + "a,\n" * 5000 + "]")
    assert len(found) == 1000
    assert found[-1].startswith("f.yaml:1001: sweep.T[999]: must be a number, not 'a'")


def test_each_problem_is_one_line_whatever_the_text_contains() -> None:
    found = problems('model: {"a\\nb": 1, "\\u2028": 2, T: "x\\ny"}\n"\\r": 1')
    assert len(found) == 4
    assert all(len(line.splitlines()) == 1 for line in found)


def test_the_error_survives_pickling() -> None:
    with pytest.raises(ConfigError) as caught:
        from_yaml("a: 1")
    copy = pickle.loads(pickle.dumps(caught.value))
    assert copy.problems == caught.value.problems
    assert str(copy) == str(caught.value)


def test_warnings_name_their_place_and_are_not_printed(capsys: pytest.CaptureFixture[str]) -> None:
    config = from_yaml("model:\n  k: 3000\n  K: 5e4\nsweep:\n  T: [100, 100.00000001]\n", "f.yaml")
    assert [w.partition(" ")[0] for w in config.warnings] == ["f.yaml:5:", "f.yaml:3:"]
    assert capsys.readouterr() == ("", "")
