"""The file of a fit: the config of the fitted curve, and the printed summary."""

from __future__ import annotations

from typing import Any

import numpy as np

from sweeps.config.load import Config, from_mapping
from sweeps.fitting.fitting import model_of
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import GLANCE
from sweeps.fitting.output import curve_config
from sweeps.measurements import read_data

ROUGH = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}


def curve_of(table: dict[str, Any], **written: Any) -> Config:
    """Return the config of the fitted curve of a fit of k that ends where it starts."""
    config = from_mapping(ROUGH | written)
    model = model_of(read_data(table), "k", config)
    (trial,) = model.trials(np.array([[each.start for each in model.free]]), GLANCE)
    count = len(model.data.value)
    fit = Fit(model, trial, np.ones((count, 1)), np.zeros(count, dtype=bool))
    return curve_config(fit, config)


def test_points_measured_twice_occur_once_in_the_sweep() -> None:
    """Three parameters vary, so the sweep has the points of the data instead of curves."""
    table = {"T": [200, 200, 240, 240], "omega": [10, 10, 10, 20], "K": [3e3, 3e3, 4e3, 3e3]}
    curve = curve_of(table | {"F_max": [2.8e-3, 2.9e-3, 1.5e-3, 1.6e-3]})
    assert not curve.sweep
    assert curve.cases == {
        "temperature": (200.0, 240.0, 240.0),
        "angular_frequency": (10.0, 10.0, 20.0),
        "spring_stiffness": (3e3, 4e3, 3e3),
    }


def test_values_that_differ_by_rounding_are_no_axis() -> None:
    rounded = 1000 * (0.1 + 0.2)
    assert rounded != 300.0
    curve = curve_of({"T": [300.0, rounded], "F_max": [1.2e-3, 1.2e-3]})
    assert not curve.sweep
    assert curve.model["temperature"] == 300.0


def test_a_schedule_of_a_parameter_in_the_data_does_not_end_the_fit() -> None:
    table = {"T": [200, 240], "F_max": [2.8e-3, 1.6e-3]}
    curve = curve_of(table, simulation={"periods": 3, "schedule": {"T": [200, 250]}})
    assert [*curve.sweep] == ["temperature"]
    assert curve.simulation.schedule is None
    assert curve.simulation.periods == 3
