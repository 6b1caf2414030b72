"""Derivatives of amplitudes: known values, scalings, jumps, and the errors that they propagate."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr

from stickslip import Parameters, propagated, sensitivities, stationary_orbits

F, SIGMA = "friction_force_amplitude", "elastic_stress_amplitude"

# Measured by LSODA, settled to 1e-9 of X_m (central differences), good to the digits printed.
MEASURED = [
    (250.0, F, "viscosity_coefficient", 0.156721, 1e-6),
    (250.0, SIGMA, "viscosity_coefficient", -5.685e-4, 1e-7),
    (250.0, F, "temperature", -5.0837, 1e-4),
    (250.0, SIGMA, "temperature", -5.8957, 1e-4),
    (200.0, F, "viscosity_coefficient", 0.081123, 1e-6),
    (220.0, F, "viscosity_coefficient", 0.101487, 1e-6),
    (220.0, F, "film_thickness", -1.819e-3, 1e-6),
]


@pytest.fixture(scope="module")
def found() -> xr.Dataset:
    by = ["k", "T", "h", "rheological_index", "x_0"]
    return sensitivities({"temperature": [200.0, 220.0, 250.0]}, by)


@pytest.mark.parametrize(("temperature", "of", "by", "value", "digit"), MEASURED)
def test_derivatives_agree_with_an_independent_solver(
    found: xr.Dataset, temperature: float, of: str, by: str, value: float, digit: float
) -> None:
    point = found[{"point": [200.0, 220.0, 250.0].index(temperature)}].sel(parameter=by)
    assert point[f"{of}_sensitivity"].item() == pytest.approx(value, abs=digit)


def test_the_attributes_state_the_forms(found: xr.Dataset) -> None:
    forms = found[f"{F}_sensitivity"].attrs["form"].split()
    assert forms == ["logarithmic", "logarithmic", "logarithmic", "plain", "plain"]
    assert found.parameter.values.tolist()[:2] == ["viscosity_coefficient", "temperature"]


def test_the_orbits_are_returned_as_well(found: xr.Dataset) -> None:
    orbits = stationary_orbits({"temperature": [200.0, 220.0, 250.0]}, rtol=1e-8)
    xr.testing.assert_identical(found[list(orbits.data_vars)], orbits)


def test_the_index_of_a_plain_difference(found: xr.Dataset) -> None:
    step = 1e-4
    index = [-2 / 3 - step, -2 / 3 + step]
    force = stationary_orbits({"gamma": index, "T": 220.0}, rtol=1e-9)[F].values
    value = found[f"{F}_sensitivity"].sel(parameter="rheological_index")[1].item()
    assert value == pytest.approx(np.log(force[1] / force[0]) / (2 * step), rel=1e-5)


def test_an_amplitude_with_one_scale_follows_a_power_law() -> None:
    """The viscous stress of a film without elasticity has one scale, so that powers are exact."""
    ds = sensitivities({"a": 0.0, "gamma": 0.0, "K": 1e9, "k": 0.1}, ["k", "A"], F)
    assert ds[f"{F}_sensitivity"].values == pytest.approx([1.0, 1.0], abs=1e-3)


def test_the_stated_error_bounds_the_true_one() -> None:
    """Against a difference of order 4 at a tolerance of 1e-11."""
    rng, count, step = np.random.default_rng(3), 12, 2e-4
    points = {"T": rng.uniform(150, 330, count), "K": np.exp(rng.uniform(6.3, 9.2, count))}
    ds = sensitivities(points, "k", F)
    near = {shift: points | {"k": 5e4 * np.exp(shift * step)} for shift in (-2, -1, 1, 2)}
    logs = {shift: np.log(stationary_orbits(p, rtol=1e-11)[F]) for shift, p in near.items()}
    true = (8 * (logs[1] - logs[-1]) - (logs[2] - logs[-2])) / (12 * step)
    error = abs(ds[f"{F}_sensitivity"][:, 0] - true.values)
    assert (error <= ds[f"{F}_sensitivity_error"][:, 0]).all()
    assert ds[f"{F}_sensitivity_error"].max() < 1e-3


def test_a_jump_has_no_derivative() -> None:
    """From 14.9181 rad/s on, a film at 200 K melts once more in each period."""
    ds = sensitivities({"omega": [14.0, 14.9181, 16.0]}, "omega")
    nan = np.isnan(ds[f"{F}_sensitivity"].values[:, 0])
    assert nan.tolist() == [False, True, False]


def test_a_jump_that_changes_no_kind_is_part_of_the_error() -> None:
    """At gamma = -1.4e-4 the amplitude jumps by 2.2e-5 of itself, and the counts do not change."""
    film = {"T": 200.0, "k": 20.0, "omega": 10.0}
    ds = sensitivities({**film, "gamma": 0.0}, "gamma", F)
    force = stationary_orbits({**film, "gamma": [0.0, 5e-4]}, rtol=1e-10)[F].values
    true = np.log(force[1] / force[0]) / 5e-4
    assert abs(ds[f"{F}_sensitivity"].item() - true) <= ds[f"{F}_sensitivity_error"].item()


@pytest.mark.stress
def test_values_at_the_end_of_their_range_have_derivatives_from_one_side() -> None:
    ds = sensitivities({"T": 250.0}, ["initial_order_parameter", "e"], F)
    values = ds[f"{F}_sensitivity"]
    assert abs(values.sel(parameter="initial_order_parameter").item()) < 1e-4
    sextic = values.sel(parameter="sextic_coefficient").item()
    force = stationary_orbits({"T": 250.0, "e": [0.0, 0.1]}, rtol=1e-10)[F].values
    assert sextic == pytest.approx(np.log(force[1] / force[0]) / 0.1, rel=1e-2)


def test_neither_an_invalid_neighbour_nor_a_zero_has_a_derivative() -> None:
    ds = sensitivities({"T": 250.0, "D": 0.0, "phi_0": 0.1}, ["d", "D"])
    assert np.isnan(ds[f"{F}_sensitivity"].values).all()


def test_no_points_have_no_derivatives() -> None:
    assert sensitivities({"T": []}, "k")[f"{F}_sensitivity"].shape == (0, 1)


WRONG: dict[str, tuple[dict[str, Any], type[Exception], str]] = {
    "no amplitude": ({"by": "k", "of": "asymmetry"}, ValueError, "no amplitude asymmetry"),
    "no parameter": ({"by": "viscosity"}, TypeError, "did you mean 'viscosity_coefficient'?"),
    "none": ({"by": []}, ValueError, "by is empty"),
    "random paths": ({"by": "k", "noise": "stochastic"}, ValueError, "has no derivative"),
}


@pytest.mark.parametrize("case", WRONG)
def test_invalid_arguments_are_refused_with_a_reason(case: str) -> None:
    arguments, error, words = WRONG[case]
    with pytest.raises(error, match=re.escape(words)):
        sensitivities({}, **arguments)


def test_points_along_the_dimension_of_the_derivatives_are_refused() -> None:
    with pytest.raises(ValueError, match="the points have a dimension parameter"):
        sensitivities({"T": xr.DataArray([200.0, 250.0], dims="parameter")}, "k")


# --- errors that propagate ------------------------------------------------------------------------


def test_independent_errors_add_in_squares(found: xr.Dataset) -> None:
    errors = propagated(found, {"film_thickness": 1e-10, "k": 5e3, "gamma": 0.01})
    slopes = found[f"{F}_sensitivity"].values
    parts = np.array([0.1 * slopes[:, 2], 0.1 * slopes[:, 0], 0.01 * slopes[:, 3]])
    expected = found[F].values * np.sqrt((parts**2).sum(axis=0))
    assert errors[f"{F}_standard_error"].values == pytest.approx(expected, rel=1e-12)
    assert errors[f"{F}_standard_error"].attrs["units"] == "N"
    assert "parameter" not in errors.coords


def test_an_error_agrees_with_a_random_sample() -> None:
    spread, rng = 0.01 * Parameters().viscosity_coefficient, np.random.default_rng(1)
    center = {"T": 250.0, "k": Parameters().viscosity_coefficient}
    error = propagated(sensitivities(center, "k"), {"k": spread})[f"{F}_standard_error"].item()
    drawn = stationary_orbits(center | {"k": center["k"] + spread * rng.standard_normal(400)})
    assert error == pytest.approx(drawn[F].std().item(), rel=0.1)


def test_an_error_that_is_given_twice_is_refused(found: xr.Dataset) -> None:
    with pytest.raises(TypeError, match="viscosity_coefficient is given twice"):
        propagated(found, {"k": 5e3, "viscosity_coefficient": 1e3})


def test_a_name_repeated_in_by_counts_once() -> None:
    ds = sensitivities({}, by=["k", "viscosity_coefficient", "k"])
    assert ds.parameter.values.tolist() == ["viscosity_coefficient"]


def test_an_error_without_its_derivative_is_refused(found: xr.Dataset) -> None:
    with pytest.raises(ValueError, match="no derivatives with respect to block_mass"):
        propagated(found, {"M": 0.01})
    with pytest.raises(ValueError, match="no derivatives at all"):
        propagated(stationary_orbits({}), {"M": 0.01})
