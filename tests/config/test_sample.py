"""`sample`: points drawn from a box."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats
from support.sweeps.configs import problems

from sweeps.config.load import from_mapping, from_yaml
from sweeps.files.attributes import global_attributes
from sweeps.grid import Grid

BOX = {"T": [150, 320], "K": {"log": [500, 1e4]}}


def drawn(**how: object) -> dict[str, tuple[float, ...]]:
    return from_mapping({"sample": {**how, **BOX}}).cases


@pytest.mark.parametrize("way", ["sobol", "latin_hypercube"])
def test_points_fill_their_box_evenly(way: str) -> None:
    cases = drawn(**{way: 256}, seed=3)
    parts = [
        (np.array(cases["temperature"]) - 150) / 170,
        np.log(np.array(cases["spring_stiffness"]) / 500) / np.log(20),
    ]
    for part in parts:
        # One point in each of 256 slices: of a Sobol sequence and of a Latin hypercube alike.
        assert sorted(np.floor(part * 256).astype(int)) == list(range(256))
    assert abs(np.corrcoef(parts)[0, 1]) < 0.2


def test_the_seed_decides_and_a_longer_sequence_begins_with_the_shorter() -> None:
    assert drawn(sobol=8, seed=1) == drawn(sobol=8, seed=1) != drawn(sobol=8, seed=2)
    long, short = drawn(sobol=20, seed=1), drawn(sobol=8, seed=1)
    assert {name: values[:8] for name, values in long.items()} == short


def test_a_sample_is_a_set_of_cases_and_the_file_says_how_it_was_drawn() -> None:
    config = from_yaml("sample: {sobol: 4, T: [150, 320]}\nsweep: {gamma: [0, 1]}\n")
    grid = Grid.from_config(config)
    assert (grid.dims, grid.shape) == (("rheological_index", "case"), (2, 4))
    assert global_attributes(config)["sample"] == "sobol 4, seed 0, temperature [150, 320]"
    assert from_yaml(config.resolved_yaml()).cases == config.cases
    one = from_yaml("sample: {sobol: 4, T: [150, 320]}\n", overrides=["case=2"])
    assert one.model["temperature"] == config.cases["temperature"][2]


@pytest.mark.parametrize(
    ("sample", "said"),
    [
        ("3", "sample: must be {sobol: 1024"),
        ("{sobol: 4}", "sample: needs sobol or latin_hypercube, and parameters"),
        ("{T: [1, 2]}", "sample: needs sobol or latin_hypercube, and parameters"),
        ("{sobol: 4, latin_hypercube: 4, T: [1, 2]}", "sample: needs sobol or latin_hypercube"),
        ("{sobol: 0, T: [1, 2]}", "sample.sobol: must be at least 1, not 0"),
        ("{sobol: 4, seed: -1, T: [1, 2]}", "sample.seed: must be at least 0"),
        ("{sobol: 4, Tx: [1, 2], T: [1, 2]}", "sample.Tx: unknown parameter"),
        ("{sobol: 4, T: [2, 1]}", "sample.T: must rise from low to high, not from 2 to 1"),
        (
            "{sobol: 4, T: [1, 2, 3]}",
            "sample.T: must be [low, high], {log: ",
        ),
        (
            "{sobol: 4, K: {lag: [1, 2]}}",
            "sample.K.lag: unknown key (did you mean 'log'?)",
        ),
        ("{sobol: 4, K: {log: [0, 2]}}", "sample.K: no logarithm leads from 0 to 2"),
        ("{sobol: 4, T: [-1, 2]}", "sample.T[0]: must be at least 0"),
    ],
)
def test_a_sample_that_cannot_be_drawn_is_refused(sample: str, said: str) -> None:
    (problem,) = problems(f"sample: {sample}\n")
    assert problem.startswith(f"f.yaml:1: {said}")


def test_drawn_and_listed_cases_exclude_each_other() -> None:
    (problem,) = problems("sample: {sobol: 4, T: [1, 2]}\ncases: {K: [1e3, 2e3]}\n")
    assert "draws the cases, and `cases` lists them" in problem
    (problem,) = problems("sample: {sobol: 4, T: [1, 2]}\nsweep: {T: [1, 2]}\n")
    assert "gives temperature a second time" in problem


def test_values_of_a_normal_distribution_have_its_quantiles() -> None:
    sample = "{sobol: 4096, T: {normal: [250, 5]}, k: {lognormal: [5e4, 0.3]}}"
    cases = from_yaml(f"sample: {sample}\n").cases
    T, k = (np.sort(cases[name]) for name in ("temperature", "viscosity_coefficient"))
    levels = (np.arange(4096) + 0.5) / 4096
    exact = scipy.stats.norm.ppf(levels)
    assert np.abs((T - 250.0) / 5.0 - exact)[40:-40].max() < 0.02
    assert np.abs(np.log(k / 5e4) / 0.3 - exact)[40:-40].max() < 0.02


def test_a_distribution_with_values_that_cannot_be_is_refused() -> None:
    (problem,) = problems("sample: {sobol: 4, T: {normal: [10, 5]}}\n")
    assert problem.startswith(
        "f.yaml:1: sample.T: has values that temperature cannot have, with a probability of 0.02"
    )
    cases = from_yaml("sample: {sobol: 4096, T: {normal: [10, 3.2]}}\n").cases
    assert min(cases["temperature"]) >= 0.0
