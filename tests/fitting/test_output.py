"""The file of a fit: the config of the fitted curve, and the printed summary."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

from stickslip.orbit import failed_row
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import Config, from_mapping
from sweeps.fitting import output
from sweeps.fitting.fitting import model_of
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import GLANCE
from sweeps.fitting.output import curve_config, fit_dataset
from sweeps.fitting.statistics import statistics_of
from sweeps.fitting.trials import Trial
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


def test_a_motion_that_never_closes_is_not_said_to_be_at_a_jump(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It has no derivative either, but it counts in chi2 and in the ends of intervals."""
    monkeypatch.setattr(output, "run_in_memory", lambda *_, **__: xr.Dataset())
    table = {"T": [200, 240, 280], "F_max": [2.8e-3, 1.6e-3, 1.2e-3]}
    model = model_of(read_data(table), "k", from_mapping({}))
    rows = np.array([failed_row(code) for code in (Status.APERIODIC, Status.OK, Status.OK)])
    rows[0, RESULT_COLUMNS.index("regime")] = Regime.APERIODIC
    trial = Trial(np.array([model.free[0].start]), model.data.value, np.full(3, 0.1), rows)
    fit = Fit(model, trial, np.ones((3, 1)), np.array([True, True, False]))
    known = statistics_of(fit)
    ds = fit_dataset(fit, known, from_mapping({}), None, None, 1)
    assert ds.datum_at_jump.values.tolist() == [0, 1, 0]
