"""A fit as a Dataset: the fitted curve as a sweep, and beside it data, parameters, statistics."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from uncertainties import ufloat

from stickslip.datasets import result_attributes, result_values
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS, RESULTS
from sweeps.config.load import Config, from_mapping
from sweeps.engine.run import run_in_memory
from sweeps.fitting.refinement import PATIENCE, Fit
from sweeps.fitting.statistics import LEVEL, Determination, Statistics
from sweeps.fitting.trials import Model
from sweeps.human import counted
from sweeps.measurements import Floats, Measurements, columns_of

if TYPE_CHECKING:
    import xarray as xr

DATUM, FREE, OTHER = "datum", "free_parameter", "other_parameter"
"""The dimensions of data and of free parameters."""

_CURVE = 101  # points of a fitted curve
_FEW = 8  # values that are worth a curve each
# What the data of a machine rarely say, and differs from the paper's.
_MACHINE = (
    "temperature", "angular_frequency", "drive_amplitude", "spring_stiffness", "block_mass",
    "film_thickness", "contact_area",
)  # fmt: skip
_PERIODS = RESULT_COLUMNS.index("periods_integrated")
_DECADE = 10.0  # an axis that spans more is logarithmic

RELATIVE = (
    "none were given: residuals are relative to the values, with a common unknown factor that "
    "chi2/dof estimates"
)
GIVEN = "those of the data; standard errors grow with the root of chi2/dof where that is above 1"


def fit_dataset(
    fit: Fit, known: Statistics, config: Config, profile: Floats | None, trials: int
) -> xr.Dataset:
    """Return the file of a fit: the sweep of the fitted curve, with the fit beside it.

    Along `datum`: `measured_value`, `measured_error`, `fitted_value`, `residual`, and so on; along
    `free_parameter`: `parameter_value`, `parameter_standard_error`, and so on.
    """
    curve = run_in_memory(curve_config(fit, config), workers=fit.model.workers)
    about = {
        "chi2": fit.trial.chi2,
        "degrees_of_freedom": fit.dof,
        "reduced_chi2": fit.reduced,
        "measurement_errors": RELATIVE if fit.model.data.relative else GIVEN,
        "trials": trials,
    }
    data = _of_data(fit, known) | _of_parameters(fit, known, profile)
    names = (FREE, [each.name for each in fit.model.free])
    along = {
        "datum_variable": (DATUM, list(fit.model.data.variable), {"long_name": "what was measured"})
    }
    return curve.assign(data).assign_coords({FREE: names} | along).assign_attrs(about)


def curve_config(fit: Fit, config: Config) -> Config:
    """Return the config whose sweep is the fitted curve, through the range of the data.

    Over the parameter with the most values, with a curve for each of the few values of another; at
    the data themselves where there is no such order.
    """
    data, fixed = fit.model.data, fitted_parameters(fit.model, fit.trial.u)
    varied = dict(columns_of(data))
    fixed |= {name: float(v[0]) for name, v in data.parameters.items() if name not in varied}
    axes = dict(sorted(varied.items(), key=lambda item: -len(np.unique(item[1]))))
    model = {name: value for name, value in fixed.items() if name not in varied}
    written: dict[str, Any] = config.resolved() | {"model": model, "sweep": {}, "cases": {}}
    if np.max(fit.trial.results[:, _PERIODS]) <= PATIENCE.periods:  # as much as the data needed
        written["stationary"]["max_periods"] = min(config.stationary.max_periods, PATIENCE.periods)
    names = ", ".join(each.name for each in fit.model.free)
    written["title"] = config.title or f"Fit of {names} to {counted(len(data.value), 'value')}"
    others = [*axes][1:]
    if len(others) <= 1 and all(len(np.unique(axes[name])) <= _FEW for name in others):
        written["sweep"] = {name: _axis(axes[name]) for name in [*axes][:1]}
        written["sweep"] |= {name: np.unique(axes[name]).tolist() for name in others}
    else:
        written["cases"] = {name: values.tolist() for name, values in varied.items()}
    return from_mapping(written, "the fitted curve")


def _axis(values: Floats) -> dict[str, Any]:
    low, high = float(values.min()), float(values.max())
    geometric = low > 0 and high / low > _DECADE
    return {"geomspace" if geometric else "linspace": [low, high], "num": _CURVE}


def fitted_parameters(model: Model, u: Floats) -> dict[str, float]:
    """Return all parameters with a place (p,) of the free ones."""
    values = {each.name: float(each.value(at)) for each, at in zip(model.free, u, strict=True)}
    return model.fixed._asdict() | values


def measured_errors(fit: Fit) -> Floats:
    """Return standard errors (n,) of the data; where none were given, as the residuals tell."""
    error = fit.model.data.error
    return error * np.sqrt(fit.reduced) if fit.model.data.relative else error


def _of_data(fit: Fit, known: Statistics) -> dict[str, Any]:
    data, trial = fit.model.data, fit.trial
    regimes, statuses = (
        result_values(name, trial.results[data.row, RESULT_COLUMNS.index(name)])
        for name in ("regime", "status")
    )
    errors = measured_errors(fit)
    with np.errstate(invalid="ignore", divide="ignore"):  # an exact fit has no errors
        residuals = (data.value - trial.fitted) / errors
    unit = {"comment": "in the unit of the variable, datum_variable"}
    variables: dict[str, Any] = {
        "measured_value": (DATUM, data.value, {"long_name": "measured value"} | unit),
        "measured_error": (DATUM, errors, {"long_name": "standard error of the value"} | unit),
        "fitted_value": (DATUM, trial.fitted, {"long_name": "fitted value"} | unit),
        "residual": (
            DATUM,
            residuals,
            {"long_name": "measured minus fitted value, in standard errors", "units": "1"},
        ),
        "datum_row": (DATUM, data.row.astype(np.int32), {"long_name": "row of the data"}),
        "datum_regime": (DATUM, regimes, result_attributes("regime")),
        "datum_status": (DATUM, statuses, result_attributes("status")),
        "datum_at_jump": (
            DATUM,
            np.where(fit.at_jump, 1, np.where(known.jumps, 2, 0)).astype(np.int8),
            {
                "long_name": "whether the motion changes within the step of a derivative, or "
                "within the intervals of the parameters",
                "units": "1",
                "flag_values": np.array([0, 1, 2], dtype=np.int8),
                "flag_meanings": "smooth at_jump jumps_within_intervals",
            },
        ),
    }
    for name, values in data.parameters.items():
        attributes = dict(PARAMETERS[name].attributes)
        variables[f"datum_{name}"] = (DATUM, values[data.row], attributes)
    return variables


def _of_parameters(fit: Fit, known: Statistics, profile: Floats | None) -> dict[str, Any]:
    free, u = fit.model.free, fit.trial.u
    named = [f"{each.name}: {PARAMETERS[each.name].unit or 1}" for each in free]
    units = {"comment": f"in {'; '.join(named)}"}
    values = np.array([float(each.value(at)) for each, at in zip(free, u, strict=True)])
    slopes = np.array([each.slope(at) for each, at in zip(free, u, strict=True)])
    starts = np.array([float(each.value(each.start)) for each in free])
    forms = {"form": " ".join(each.form for each in free)}
    percent = f"{100 * LEVEL:g} %"
    variables: dict[str, Any] = {
        "parameter_value": (FREE, values, {"long_name": "fitted value"} | units),
        "parameter_standard_error": (
            FREE,
            known.errors * slopes,
            {"long_name": "standard error of the fitted value"} | units | forms,
        ),
        "parameter_start": (FREE, starts, {"long_name": "start of the fit"} | units),
        "parameter_determination": (
            FREE,
            known.determination,
            {
                "long_name": "what the data say of the parameter",
                "units": "1",
                "flag_values": np.array([int(code) for code in Determination], dtype=np.int8),
                "flag_meanings": " ".join(code.name.lower() for code in Determination),
            },
        ),
        "parameter_correlation": (
            (FREE, OTHER),
            known.correlations,
            {"long_name": "correlation of the errors of two parameters", "units": "1"},
        ),
    }
    intervals = {"interval": (known.intervals, f"{percent} interval by the standard error")}
    if profile is not None:
        intervals["profile"] = (profile, f"{percent} interval by the profile likelihood")
    for name, (ends, what) in intervals.items():
        in_units = np.array(
            [np.sort(each.value(pair)) for each, pair in zip(free, ends, strict=True)]
        )
        for side, column in zip(("lower", "upper"), in_units.T, strict=True):
            attributes = {"long_name": f"{side} end of the {what}"} | units
            variables[f"parameter_{name}_{side}"] = (FREE, column, attributes)
    return variables


def table_of(ds: xr.Dataset) -> list[str]:
    """Return a fit in words: parameters, chi2, what is not known, and a line for each datum."""
    lines = [*_parameter_lines(ds), _machine_line(ds), *_statistic_lines(ds), ""]
    columns = [str(name) for name in ds.data_vars if _is_column(ds, str(name))]
    head = [name.removeprefix("datum_") for name in columns]
    rows = [[*head, "variable", "measured", "error", "fitted", "residual", "regime", ""]]
    for number in range(ds.sizes[DATUM]):
        datum = ds.isel({DATUM: number})
        regime = Regime(int(datum.datum_regime)).name.lower()
        status = Status(int(datum.datum_status))
        rows.append(
            [
                *(f"{float(datum[name]):.6g}" for name in columns),
                str(datum.datum_variable.values),
                *(f"{float(datum[n]):.6g}" for n in ("measured_value", "measured_error")),
                f"{float(datum.fitted_value):.6g}",
                f"{float(datum.residual):.2f}",
                regime if status.is_result else status.name.lower(),
                _JUMPS[int(datum.datum_at_jump)],
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines += [
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    return lines


_JUMPS = ("", "at a jump", "jumps within the intervals")


def _is_column(ds: xr.Dataset, name: str) -> bool:
    return name.removeprefix("datum_") in PARAMETERS and float(np.ptp(ds[name].values)) > 0


def _machine_line(ds: xr.Dataset) -> str:
    """Return the parameters of the machine that the fit took as given."""
    given = [name for name in _MACHINE if name in ds.coords and ds[name].ndim == 0]
    listed = (
        f"{PARAMETERS[name].symbol} = {float(ds[name]):g} {PARAMETERS[name].unit}".rstrip()
        for name in given
        if name not in ds[FREE].values and f"datum_{name}" not in ds
    )
    return f"computed with {', '.join(listed)} (--set or a config gives others)"


def _parameter_lines(ds: xr.Dataset) -> list[str]:
    lines = []
    for each in ds[FREE].values:
        own = ds.sel({FREE: each})
        name, code = str(each), Determination(int(own.parameter_determination))
        units = f" {PARAMETERS[name].unit}".rstrip()
        ends = [float(own[f"parameter_interval_{side}"]) for side in ("lower", "upper")]
        value, error = float(own.parameter_value), float(own.parameter_standard_error)
        line = f"{name}: {value:.7g}"
        if code is not Determination.AT_BOUND and np.isfinite(ends).all():
            # As many digits as the error has meaning; the file holds all.
            line = f"{name}: {ufloat(value, error):.2uP}{units}"
            line += f", {100 * LEVEL:g} %: {_interval(*ends)}"
        else:
            line += units
        if "parameter_profile_lower" in own:
            ends = [float(own[f"parameter_profile_{side}"]) for side in ("lower", "upper")]
            line += f", by the profile: {_interval(*ends)}"
        lines.append(line + _SAID[code])
    return lines


def _interval(low: float, high: float) -> str:
    if 0.0 < low * _ANYTHING < high:
        return f"any value, over more than {math.log10(_ANYTHING):.0f} decades"
    return f"{low:.6g} to {high:.6g}"


_ANYTHING = 1e6  # ends farther apart by this factor tell of no value
_SAID = {
    Determination.DETERMINED: "",
    Determination.UNDETERMINED: "; NOT DETERMINED by these data",
    Determination.AT_BOUND: "; AT ITS BOUND, and taken as fixed there",
}


def _statistic_lines(ds: xr.Dataset) -> list[str]:
    names = [str(name) for name in ds[FREE].values]
    lines = [
        f"correlation of {names[i]} and {names[j]}: {float(value):.3f}"
        for (i, j), value in np.ndenumerate(ds.parameter_correlation.values)
        if i < j and np.isfinite(value)
    ]
    chi2, dof = float(ds.attrs["chi2"]), int(ds.attrs["degrees_of_freedom"])
    reduced = f", chi2/dof {float(ds.attrs['reduced_chi2']):.4g}" if dof > 0 else ""
    lines.append(f"chi2 {chi2:.6g} with {counted(dof, 'degree')} of freedom{reduced}")
    lines.append(f"errors of the data: {ds.attrs['measurement_errors']}")
    if jumps := int((ds.datum_at_jump != 0).sum()):
        data = "a jump of 1 datum bounds" if jumps == 1 else f"jumps of {jumps} data bound"
        lines.append(
            f"{data} the basin of this minimum: intervals reach over all others that may be true"
        )
    return lines


def units_of(ds: xr.Dataset) -> dict[str, str]:
    """Return the unit of each measured variable."""
    return {name: RESULTS[name].units for name in map(str, np.unique(ds.datum_variable.values))}


def measurements_of(data: Measurements) -> str:
    """Return what was measured, in a few words."""
    return f"{counted(len(data.value), 'value')} of {', '.join(dict.fromkeys(data.variable))}"
