"""`sample`: points drawn from a box."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.stats
import xarray as xr
from support.sweeps.configs import problems

from sweeps.config.load import Config, ConfigError, from_mapping, from_yaml, load
from sweeps.files.attributes import global_attributes
from sweeps.grid import Grid
from sweeps.sensitivity import Request, SensitivityError

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


def test_a_sample_is_a_set_of_cases_and_the_file_describes_the_draw() -> None:
    config = from_yaml("sample: {sobol: 4, T: [150, 320]}\nsweep: {gamma: [0, 1]}\n")
    grid = Grid.from_config(config)
    assert (grid.dims, grid.shape) == (("rheological_index", "case"), (2, 4))
    assert global_attributes(config)["sample"] == "sobol 4, seed 0, temperature [150, 320]"
    assert from_yaml(config.resolved_yaml()).cases == config.cases
    one = from_yaml("sample: {sobol: 4, T: [150, 320]}\n", overrides=["case=2"])
    assert one.model["temperature"] == config.cases["temperature"][2]


@pytest.mark.parametrize(
    ("sample", "message"),
    [
        ("3", "sample: must be {sobol: 1024"),
        ("{sobol: 4}", "sample: needs exactly one of sobol and latin_hypercube, and parameters"),
        ("{T: [1, 2]}", "sample: needs exactly one of sobol and latin_hypercube, and parameters"),
        (
            "{sobol: 4, latin_hypercube: 4, T: [1, 2]}",
            "sample: needs exactly one of sobol and latin_hypercube",
        ),
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
        ("{sobol: 4, K: {log: [0, 2]}}", "sample.K: needs two values above 0 for a logarithm"),
        ("{sobol: 4, T: [-1, 2]}", "sample.T[0]: must be at least 0"),
    ],
)
def test_a_sample_that_cannot_be_drawn_is_refused(sample: str, message: str) -> None:
    (problem,) = problems(f"sample: {sample}\n")
    assert problem.startswith(f"f.yaml:1: {message}")


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


def test_a_distribution_with_many_invalid_values_is_refused() -> None:
    (problem,) = problems("sample: {sobol: 4, T: {normal: [10, 5]}}\n")
    assert problem.startswith(
        "f.yaml:1: sample.T: has values that temperature cannot have, with a probability of 0.02"
    )
    cases = from_yaml("sample: {sobol: 4096, T: {normal: [10, 3.2]}}\n").cases
    assert min(cases["temperature"]) >= 0.0


# --- `from`: the parameters of a fit --------------------------------------------------------------

MIDDLE, CORRELATION = {"viscosity_coefficient": 7e4, "rheological_index": -0.55}, -0.9
ERRORS = {"viscosity_coefficient": 7e3, "rheological_index": 0.02}


def fit_file(path: Path, **changes: Any) -> Path:
    """Write a fit's file with just the variables that describe its parameters, some changed."""
    values = {
        "value": [*MIDDLE.values()],
        "standard_error": [*ERRORS.values()],
        "determination": [0, 0],
    } | changes
    ds = xr.Dataset({f"parameter_{name}": ("free_parameter", v) for name, v in values.items()})
    ds["parameter_standard_error"].attrs["form"] = "logarithmic plain"
    correlations = [[1.0, CORRELATION], [CORRELATION, 1.0]]
    ds["parameter_correlation"] = ("free_parameter", "other_parameter"), correlations
    ds.assign_coords(free_parameter=[*MIDDLE]).to_netcdf(path)
    return path


def load_sample(folder: Path, sample: str) -> Config:
    (folder / "f.yaml").write_text(f"sample: {sample}\n")
    return load(folder / "f.yaml")


def test_parameters_of_a_fit_are_drawn_with_its_covariance(tmp_path: Path) -> None:
    file = fit_file(tmp_path / "fit.nc")
    config = load_sample(tmp_path, "{sobol: 4096, from: fit.nc, h: {normal: [1e-9, 1e-11]}}")
    k, gamma = (np.array(config.cases[name]) for name in MIDDLE)
    sets = np.array([np.log(k / 7e4) / 0.1, (gamma + 0.55) / 0.02])
    assert np.abs(sets.mean(axis=1)).max() < 0.01
    assert np.abs(np.cov(sets) - [[1.0, CORRELATION], [CORRELATION, 1.0]]).max() < 0.02
    levels = scipy.stats.norm.ppf((np.arange(4096) + 0.5) / 4096)
    assert np.abs(np.sort(sets, axis=1) - levels)[:, 100:-100].max() < 0.05
    # The others are drawn independently of them.
    thickness = np.array(config.cases["film_thickness"])
    assert np.abs(np.corrcoef([*sets, thickness])[2, :2]).max() < 0.02
    how = global_attributes(config)["sample"]
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    assert f"ln viscosity_coefficient, rheological_index from fit.nc (sha256 {digest})" in how
    mean, covariance = map(
        json.loads, re.findall(r"(\[.*?\]+)(?=$|, cov)", how.partition("mean ")[2])
    )
    assert mean == pytest.approx([np.log(7e4), -0.55])
    assert np.ravel(covariance) == pytest.approx([0.01, -0.0018, -0.0018, 4e-4])
    # A result does not need the file again.
    assert from_yaml(config.resolved_yaml()).cases == config.cases


def test_invalid_draws_are_left_out_and_counted(tmp_path: Path) -> None:
    fit_file(tmp_path / "fit.nc", standard_error=[7e3, 0.14])
    config = load_sample(tmp_path, "{sobol: 8192, from: fit.nc}")
    left = 8192 - len(config.cases["rheological_index"])
    assert left == pytest.approx(8192 * scipy.stats.norm.cdf(-0.45 / 0.14), abs=3)
    assert min(config.cases["rheological_index"]) > -1.0
    assert global_attributes(config)["sample"].endswith(f"; sets left out as invalid: {left}")


@pytest.mark.parametrize(
    ("changes", "sample", "message"),
    [
        ({}, "{sobol: 4, from: none.nc}", "names none.nc, which cannot be read: No such file"),
        ({}, "{sobol: 4, from: f.yaml}", "names f.yaml, which cannot be read: "),
        ({}, "{sobol: 4, from: 3}", "must be the name of a file that `stickslip fit` wrote, not 3"),
        ({}, "{from: fit.nc}", "needs exactly one of sobol and latin_hypercube, and parameters"),
        (
            {},
            "{sobol: 4, from: fit.nc, k: [1e4, 1e5]}",
            "draws viscosity_coefficient, which sample.k gives too; keep one of the two",
        ),
        (
            {"determination": [0, 1]},
            "{sobol: 4, from: fit.nc}",
            "names fit.nc, whose data do not determine rheological_index: fit again with",
        ),
        (
            {"standard_error": [7e3, 0.2]},
            "{sobol: 4, from: fit.nc}",
            "has values that rheological_index cannot have, with a probability of 0.012",
        ),
        (
            {"value": [np.nan, -0.5]},
            "{sobol: 4, from: fit.nc}",
            "names fit.nc, which lacks values or correlations",
        ),
    ],
)
def test_mistakes_in_the_file_of_a_fit_are_reported(
    tmp_path: Path, changes: dict[str, Any], sample: str, message: str
) -> None:
    fit_file(tmp_path / "fit.nc", **changes)
    with pytest.raises(ConfigError) as refused:
        load_sample(tmp_path, sample)
    (problem,) = refused.value.problems
    assert (problem.line, problem.key.partition(".")[0]) == (1, "sample")
    assert message in problem.message


def test_a_result_that_is_no_fit_gives_no_parameters(tmp_path: Path) -> None:
    xr.Dataset({"status": 0}).to_netcdf(tmp_path / "sweep.nc")
    with pytest.raises(ConfigError, match="must be a file written by `stickslip fit`"):
        load_sample(tmp_path, "{sobol: 4, from: sweep.nc}")


def test_correlated_parameters_have_no_indices(tmp_path: Path) -> None:
    fit_file(tmp_path / "fit.nc")
    config = load_sample(tmp_path, "{sobol: 4, from: fit.nc}")
    with pytest.raises(SensitivityError, match="of a fit are correlated: leave out `from`"):
        Request(config, ["friction_force_amplitude"])
