"""The phase diagram: the three landscapes of Fig. 2, and Eqs. 17 to 20 on the data."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from support.points import TWO_SOLIDS

from stickslip import Parameters, phase_diagram
from stickslip.parameters import ParameterError
from stickslip.variables import PARAMETERS, PHASES

A, ALPHA, T_C, BARRIER = 4e12, 0.95, 290.0, 230.0**2 / (4 * 850.0)


def signs(energy: np.ndarray) -> list[int]:
    """Whether the energy falls (-1) or rises (1), from one extremum to the next."""
    slopes = np.sign(np.diff(energy)).astype(int)
    return slopes[np.append(True, np.diff(slopes) != 0)].tolist()


def test_fig_2_one_minimum_in_the_solid_two_between_one_in_the_liquid() -> None:
    ds = phase_diagram()
    assert ds.temperature.values.tolist() == [265.0, 286.0, 310.0]
    assert float(ds.applied_strain) == 2.1e-6
    assert [signs(f) for f in ds.free_energy.values] == [[-1, 1], [1, -1, 1], [1]]
    minimum = ds.free_energy.isel(temperature=0).idxmin("order_parameter")
    half = 230.0 / (2 * 850.0)
    root = half + np.sqrt(half**2 - (A * 2.1e-6**2 + 2 * ALPHA * (265 - T_C)) / 850.0)
    assert float(minimum) == pytest.approx(root, abs=1e-3)


def test_the_borders_are_those_of_equations_17_to_20() -> None:
    ds = phase_diagram(temperatures=[150.0, 265.0, 295.0, 310.0])
    eps, T = ds.elastic_strain.values, ds.temperature.values
    np.testing.assert_allclose(
        ds.melting_temperature, T_C - A * eps**2 / (2 * ALPHA) + BARRIER / (2 * ALPHA), rtol=1e-13
    )
    freezing = T_C - A * eps**2 / (2 * ALPHA)
    np.testing.assert_allclose(ds.solidification_temperature, freezing, rtol=1e-13)
    room = 2 * ALPHA * (T_C - T)
    melts = np.sqrt(np.maximum(room + BARRIER, 0) / A)
    np.testing.assert_allclose(ds.melting_strain, melts, rtol=1e-13)
    np.testing.assert_allclose(ds.solidification_strain, np.sqrt(np.maximum(room, 0) / A))


def test_strains_are_shown_down_to_the_temperature_of_the_parameters() -> None:
    ds = phase_diagram(Parameters(temperature=250.0), samples=11)
    assert ds.sizes["elastic_strain"] == ds.sizes["order_parameter"] == 11
    assert float(ds.melting_temperature[-1]) == pytest.approx(250.0)


def steps(ds: xr.Dataset, direction: str) -> list[tuple[float, float, float]]:
    """The jumps along a slow ramp: the strain, and the order parameters before and after."""
    phi = ds.ramped_order_parameter.isel(temperature=0).sel(ramp_direction=direction)
    values, eps = phi.values, ds.ramped_strain.values
    if direction == "falling":
        values, eps = values[::-1], eps[::-1]
    changes = np.flatnonzero(np.abs(np.diff(values)) > 0.05)
    return [(float(eps[i]), float(values[i]), float(values[i + 1])) for i in changes]


def test_a_film_with_two_solids_melts_in_two_steps_and_freezes_in_one() -> None:
    ds = phase_diagram(Parameters(**TWO_SOLIDS), temperatures=[200.0], samples=2001)
    (hard, *_), (soft, *_) = rising = steps(ds, "rising")
    assert (hard, soft) == pytest.approx((6.6067e-6, 6.7543e-6), abs=1e-9)
    (_, high, middle), (_, low, none) = rising
    assert high > 0.5 > 0.4 > middle > low > 0.12 > none == 0.0
    ((freezing, before, after),) = steps(ds, "falling")
    assert freezing == pytest.approx(6.5383e-6, abs=1e-9)
    assert before == 0.0
    assert after == pytest.approx(0.600, abs=1e-3)  # the hard solid at once
    assert float(ds.ramped_order_parameter[0, 0, 0]) == pytest.approx(0.89037, abs=1e-5)


@pytest.mark.parametrize(
    "p", [Parameters(), Parameters(**TWO_SOLIDS)], ids=["one solid", "two solids"]
)
def test_a_slow_ramp_stays_on_stable_equilibria(p: Parameters) -> None:
    ds = phase_diagram(p, temperatures=[200.0, 265.0])
    for index in range(2):
        at = ds.isel(temperature=index)
        phi, eps, stable = (at[name].values for name in ("order_parameter", "equilibrium_strain",
                                                         "equilibrium_stability"))  # fmt: skip
        for direction in range(2):
            followed = at.ramped_order_parameter.values[direction]
            solid = followed > 0.02
            square = np.interp(followed[solid], phi, eps**2) - at.ramped_strain.values[solid] ** 2
            assert np.all(np.abs(square) < 2e-4 * at.ramped_strain.values[-1] ** 2)
            assert np.all(np.interp(followed[solid], phi, stable) > 0.0)


def test_one_solid_melts_and_freezes_at_the_two_strains_of_the_paper() -> None:
    ds = phase_diagram(temperatures=[265.0], samples=2001)
    ((melting, *_),), ((freezing, *_),) = steps(ds, "rising"), steps(ds, "falling")
    assert melting == pytest.approx(float(ds.melting_strain[0]), rel=1e-3)
    assert freezing == pytest.approx(float(ds.solidification_strain[0]), rel=1e-3)


def test_everything_is_described() -> None:
    ds = phase_diagram(samples=3)
    for name in (*ds.data_vars, *ds.coords):
        assert ds[name].attrs["long_name"]
        assert (
            ds[name].attrs["units"]
            == {**PARAMETERS, **PHASES}.get(name, PHASES["elastic_strain"]).units
        )


def test_an_invalid_diagram_is_refused() -> None:
    with pytest.raises(ValueError, match="at least two samples"):
        phase_diagram(samples=1)
    with pytest.raises(ValueError, match="needs a temperature"):
        phase_diagram(temperatures=[])
    with pytest.raises(ParameterError, match="temperature"):
        phase_diagram(temperatures=[-1.0])
