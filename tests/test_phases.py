"""The phase diagram: the three landscapes of Fig. 2, and Eqs. 17 to 20 on the data."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import Parameters, phase_diagram
from stickslip.parameters import ParameterError
from stickslip.variables import PARAMETERS, PHASES

A, ALPHA, T_C, BARRIER = 4e12, 0.95, 290.0, 230.0**2 / (4 * 850.0)


def signs(energy: np.ndarray) -> list[int]:
    """Whether the energy falls (-1) or rises (1), stretch by stretch."""
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


def test_everything_is_described() -> None:
    ds = phase_diagram(samples=3)
    for name in (*ds.data_vars, *ds.coords):
        assert ds[name].attrs["long_name"]
        assert (
            ds[name].attrs["units"]
            == {**PARAMETERS, **PHASES}.get(name, PHASES["elastic_strain"]).units
        )


def test_what_cannot_be_shown_is_refused() -> None:
    with pytest.raises(ValueError, match="at least two samples"):
        phase_diagram(samples=1)
    with pytest.raises(ValueError, match="needs a temperature"):
        phase_diagram(temperatures=[])
    with pytest.raises(ParameterError, match="temperature"):
        phase_diagram(temperatures=[-1.0])
