"""`stickslip fit`: a table in, parameters, a file, a config and a picture out."""

from __future__ import annotations

import importlib.util
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.typing import NDArray
from support import messages
from support.sweeps.commands import Command

from stickslip import stationary_orbits
from stickslip.orbit import failed_row
from stickslip.parameters import Parameters
from stickslip.points import orbit_rows
from stickslip.status import Status
from sweeps.files.netcdf import open_result
from sweeps.fitting import fitting, posterior, trials

T = [170.0, 200.0, 240.0, 280.0]


@pytest.fixture(scope="module")
def table() -> str:
    force = stationary_orbits({"T": T, "k": 7e4}).friction_force_amplitude.values
    noise = np.array([1.01, 0.99, 0.995, 1.004])
    rows = zip(T, (force * noise).tolist(), (0.01 * force).tolist(), strict=True)
    return "T,F_max,F_max_error\n" + "".join(f"{t},{f!r},{e!r}\n" for t, f, e in rows)


@pytest.mark.stress
def test_a_posterior_is_drawn_kept_and_opened(
    command: Command, table: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("emcee")
    monkeypatch.setattr(posterior, "WALKERS", 16)
    monkeypatch.setattr(posterior, "LONG", 10.0)
    Path("d.csv").write_text(table)
    options = ("--free", "k=1e4:2e5", "-o", "fit.nc", "--prior", "k={lognormal: [7e4, 0.02]}")
    done = command.ok("fit", "d.csv", *options, "--set", "integrator.rtol=1e-4")
    assert "by the posterior: " in done.out
    assert "priors: viscosity_coefficient lognormal [70000, 0.02]" in done.out
    pictures = ["fit.png", "fit.pdf", "fit-posterior.png", "fit-posterior.pdf"]
    assert done.out.splitlines()[-6:] == ["fit.nc", "fit.yaml", *pictures]
    ds = open_result(Path("fit.nc"))
    low, high = (float(ds[f"parameter_posterior_{side}"][0]) for side in ("lower", "upper"))
    wide, wider = (float(ds[f"parameter_interval_{side}"][0]) for side in ("lower", "upper"))
    assert wide < low < 7e4 < high < wider  # the prior says more than the data
    again = command("fit", "d.csv", *options, "--set", "integrator.rtol=1e-4")
    assert f"fit.nc {messages.COMPLETE}" in again.err
    other = command("fit", "d.csv", *options[:-1], "k={lognormal: [7e4, 0.03]}")
    assert other.code == 2
    command.ok("replay", "fit.nc", "--at", "T=240")
    groups = xr.open_dataset("fit.nc", group="posterior")
    xr.testing.assert_equal(groups.viscosity_coefficient.variable, ds.posterior_draws[0].variable)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        arviz = pytest.importorskip("arviz")
        summary = arviz.summary(arviz.from_netcdf("fit.nc"), kind="stats")
    assert summary.loc["viscosity_coefficient", "mean"] == pytest.approx(7e4, rel=0.05)


def test_the_command_fits_and_its_files_can_be_used(command: Command, table: str) -> None:
    Path("d.csv").write_text(table)
    done = command.ok("fit", "d.csv", "--free", "k=1e4:2e5", "-o", "fit.nc", "--workers", "1")
    assert done.out.splitlines()[-4:] == ["fit.nc", "fit.yaml", "fit.png", "fit.pdf"]
    assert "viscosity_coefficient: " in done.out
    assert "stick_slip_symmetric" in done.out
    ds = open_result(Path("fit.nc"))
    low, high = (float(ds[f"parameter_interval_{side}"][0]) for side in ("lower", "upper"))
    assert low < 7e4 < high
    command.ok("sweep", "fit.yaml", "-o", "curve.nc")
    curve = open_result(Path("curve.nc"))
    for name, values in curve.data_vars.items():
        xr.testing.assert_equal(ds[name].drop_vars("datum_variable", errors="ignore"), values)
    at = curve.friction_force_amplitude.interp(temperature=T)
    np.testing.assert_allclose(ds.fitted_value, at, rtol=2e-3)
    replayed = command.ok("replay", "fit.nc", "--at", "T=240")
    assert messages.SAME_BITS in replayed.out
    command.ok("plot", "fit.nc", "-o", "again.svg")
    said = "fit.nc holds a fit, not a sweep; `stickslip info` describes it\n"
    assert command("status", "fit.nc") == (2, "", said)
    refused = command("sweep", "fit.yaml", "-o", "fit.nc")
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.startswith("fit.nc holds a fit, not a sweep; --overwrite")
    name = "viscosity_coefficient"
    again = command.ok("fit", "d.csv", "--free", f"{name}=1e4:2e5", "-o", "fit.nc")
    assert f"fit.nc {messages.COMPLETE}" in again.err
    again = command("fit", "d.csv", "--free", "k", "-o", "fit.nc")
    assert again.code == 2
    assert "--overwrite" in again.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("d.csv --free k=1", "--free k=1: a range is written k=LOW:HIGH"),
        ("d.csv --free k=1:2:3", "--free k=1:2:3: a range is written k=LOW:HIGH"),
        ("d.csv --free k=1_0:2e5", "must be a number, not '1_0'; write it without underscores"),
        ("d.csv --free k,k", "k is given twice"),
        ("d.csv --free T", "a column of the data"),
        ("d.csv --free k -o d.csv", "ends in .nc"),
        ("bad.csv --free k", "bad.csv:1, column Fmax: is neither a parameter"),
        ("d.csv --free k --profile", "needs two free parameters"),
        (
            "d.csv --free k --set T=200",
            "given both in the config and as columns of the data: temperature",
        ),
        ("milli.csv --free k", "times the model's even in the closest of 16 trials: are they in N"),
        ("least.csv --free k", "have the opposite sign to the model's in all trials"),
    ],
)
def test_mistakes_are_reported(command: Command, table: str, arguments: str, message: str) -> None:
    Path("d.csv").write_text(table)
    Path("bad.csv").write_text(table.replace("F_max,", "Fmax,"))
    frame = pd.read_csv("d.csv")
    frame.assign(F_max=1e3 * frame.F_max).to_csv("milli.csv", index=False)
    Path("least.csv").write_text(table.replace("F_max", "friction_force_min"))
    done = command("fit", *arguments.split())
    assert done.code == 2, done.err
    assert message in done.err


def test_a_posterior_that_cannot_be_drawn_is_refused_before_the_fit(
    command: Command, table: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("d.csv").write_text(table)
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "corner" else found(name)
    )
    monkeypatch.setattr(fitting, "fit_measured", lambda *_, **__: pytest.fail("it was computed"))
    done = command("fit", "d.csv", "--free", "k", "--posterior")
    assert done.code == 2
    assert "the picture of a posterior needs corner, which is not installed" in done.err


def test_temperatures_in_celsius_are_reported_before_the_fit(command: Command) -> None:
    Path("celsius.csv").write_text("T,F_max\n20,0.0046662\n60,0.0025126\n100,0.0023459\n")
    done = command("fit", "celsius.csv", "--free", "T")
    assert done.code == 2
    first, second = done.err.splitlines()
    assert first.startswith("warning: celsius.csv: T = 20 K is -253 degrees Celsius")
    assert "temperature is free and also a column of the data" in second


@pytest.mark.stress
def test_data_without_a_fitted_value_and_bounds_are_reported(
    command: Command, table: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without_the_first(rows: NDArray[np.float64], *others: Any) -> NDArray[np.float64]:
        found = orbit_rows(rows, *others)
        cold = rows[:, Parameters._fields.index("temperature")] == T[0]
        found[cold] = failed_row(Status.STEP_LIMIT)
        return found

    monkeypatch.setattr(trials, "orbit_rows", without_the_first)
    Path("d.csv").write_text(table)
    done = command("fit", "d.csv", "--free", "k=1e5:2e5,gamma=-0.2:0", "-o", "fit.nc")
    assert done.code == 3, done.err
    assert (
        "all free parameters end at a bound: viscosity_coefficient, rheological_index" in done.err
    )
    assert "warning: 1 of 4 data have no fitted value: no orbit was found" in done.err
    assert "step_limit" in done.out
    ds = open_result(Path("fit.nc"))
    residuals = ds.residual.values
    assert np.isnan(residuals).tolist() == [True, False, False, False]
    assert ds.attrs["chi2"] == pytest.approx(np.nansum(residuals**2))
    assert ds.attrs["degrees_of_freedom"] == 1


def test_a_missing_file_is_a_storage_error(command: Command) -> None:
    done = command("fit", "none.csv", "--free", "k")
    assert done.code == 5
    assert "No such file" in done.err
