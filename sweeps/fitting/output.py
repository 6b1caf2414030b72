"""A fit as a Dataset: the sweep of the fitted curve, with data, parameters and statistics."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from stickslip.datasets import result_attributes, result_values
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.charts.labels import with_error
from sweeps.config.checks import NEAR
from sweeps.config.load import Config, from_mapping
from sweeps.engine.run import run_in_memory
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import PATIENCE
from sweeps.fitting.parameters import FreeParameter
from sweeps.fitting.posterior import ALIKE, LONG, Posterior
from sweeps.fitting.statistics import LEVEL, Determination, Statistics
from sweeps.human import counted
from sweeps.measurements import Floats

DATUM, FREE, OTHER = "datum", "free_parameter", "other_parameter"
"""The dimensions of data and of free parameters."""

CHAIN, DRAW = "chain", "draw"
"""The dimensions of a posterior, with the names that ArviZ uses."""

QUANTILES = {"lower": 0.5 - LEVEL / 2.0, "median": 0.5, "upper": 0.5 + LEVEL / 2.0}

_CURVE = 101  # points of a fitted curve
_FEW = 8  # the most values that get a curve each
# Parameters of the machine, often missing in the data and different from the paper's.
_MACHINE = (
    "temperature", "angular_frequency", "drive_amplitude", "spring_stiffness", "block_mass",
    "film_thickness", "contact_area",
)  # fmt: skip
_PERIODS = RESULT_COLUMNS.index("periods_integrated")
_DECADE = 10.0  # an axis that spans more is logarithmic

# Figures recognize the file of a fit without errors by the first word.
RELATIVE = (
    "none given; residuals are relative to the values, with a common unknown factor that chi2/dof "
    "estimates"
)
GIVEN = "given; standard errors are scaled by the root of chi2/dof if that is above 1"


def fit_dataset(
    fit: Fit,
    known: Statistics,
    config: Config,
    profile: Floats | None,
    posterior: Posterior | None,
    trials: int,
) -> xr.Dataset:
    """Return the Dataset of a fit: the sweep of the fitted curve, with the variables of the fit.

    Along `datum` it has `measured_value`, `measured_error`, `fitted_value`, `residual`, and so on;
    along `free_parameter` `parameter_value`, `parameter_standard_error`, and so on.
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
    if posterior is not None:
        data |= _of_posterior(fit, posterior)
        about |= about_posterior(posterior)
    coords = {
        FREE: (FREE, [each.name for each in fit.model.free]),
        "datum_variable": (DATUM, list(fit.model.data.variable), _named("measured variable")),
    }
    return curve.assign(data).assign_coords(coords).assign_attrs(about)


def curve_config(fit: Fit, config: Config) -> Config:
    """Return the config whose sweep is the fitted curve, over the range of the data.

    The curve runs along the parameter with the most values, with a curve for each value of a second
    parameter if these are few. Otherwise the sweep has only the points of the data, each once.
    """
    data, free = fit.model.data, fit.model.free
    columns = data.parameters.items()
    varied = {name: values for name, values in columns if not _is_constant(values)}
    given = {name: float(values[0]) for name, values in data.parameters.items()}
    fitted = {each.name: float(each.value(u)) for each, u in zip(free, fit.trial.u, strict=True)}
    model = fit.model.fixed._asdict() | given | fitted
    axes = {name: np.unique(values) for name, values in varied.items()}
    axes = dict(sorted(axes.items(), key=lambda axis: -len(axis[1])))
    written: dict[str, Any] = config.resolved() | {"sweep": {}, "cases": {}}
    written["model"] = {name: value for name, value in model.items() if name not in varied}
    if np.max(fit.trial.results[:, _PERIODS]) <= PATIENCE.periods:  # as much as the data needed
        written["stationary"]["max_periods"] = min(config.stationary.max_periods, PATIENCE.periods)
    names = ", ".join(each.name for each in free)
    # A schedule is for a run from the start, perhaps with a parameter that the data vary.
    written["simulation"].pop("schedule", None)
    written["title"] = config.title or f"Fit of {names} to {counted(len(data.value), 'value')}"
    others = [*axes][1:]
    if len(others) <= 1 and all(len(axes[name]) <= _FEW for name in others):
        written["sweep"] = {name: _axis(axes[name]) for name in [*axes][:1]}
        written["sweep"] |= {name: axes[name].tolist() for name in others}
    else:
        points = dict.fromkeys(zip(*(values.tolist() for values in varied.values()), strict=True))
        written["cases"] = dict(zip(varied, map(list, zip(*points, strict=True)), strict=True))
    return from_mapping(written, "the fitted curve")


def _is_constant(values: Floats) -> bool:
    """Return whether the values of a column differ by rounding at most."""
    return bool(np.ptp(values) <= NEAR * np.abs(values).max())


def _axis(values: Floats) -> dict[str, Any]:
    """Return an axis of many values over the range of a few in increasing order."""
    low, high = float(values[0]), float(values[-1])
    geometric = low > 0 and high / low > _DECADE
    return {"geomspace" if geometric else "linspace": [low, high], "num": _CURVE}


def _of_data(fit: Fit, known: Statistics) -> dict[str, Any]:
    data, trial = fit.model.data, fit.trial
    regimes, statuses = (
        result_values(name, trial.results[data.row, RESULT_COLUMNS.index(name)])
        for name in ("regime", "status")
    )
    # Without errors in the data, the residuals show their size.
    errors = data.error * np.sqrt(fit.reduced) if data.relative else data.error
    with np.errstate(invalid="ignore", divide="ignore"):  # an exact fit has no errors
        residuals = (data.value - trial.fitted) / errors
    # A datum without a periodic orbit has no derivative, but need not be near a jump.
    jumps = np.where(fit.left_out, 1, np.where(known.jumps, 2, 0))
    unit = "in the unit of the variable named in datum_variable"
    off = "measured minus fitted value, in standard errors"
    changes = "whether the motion changes within the step of a derivative, or within the intervals"
    flags = _flags(("smooth", "at_jump", "jumps_within_intervals"))
    variables: dict[str, Any] = {
        "measured_value": (DATUM, data.value, _named("measured value", comment=unit)),
        "measured_error": (DATUM, errors, _named("standard error of the value", comment=unit)),
        "fitted_value": (DATUM, trial.fitted, _named("fitted value", comment=unit)),
        "residual": (DATUM, residuals, _named(off, units="1")),
        "datum_row": (DATUM, data.row.astype(np.int32), _named("row of the data")),
        "datum_regime": (DATUM, regimes, result_attributes("regime")),
        "datum_status": (DATUM, statuses, result_attributes("status")),
        "datum_at_jump": (
            DATUM,
            jumps.astype(np.int8),
            _named(f"{changes} of the parameters", **flags),
        ),
    }
    for name, values in data.parameters.items():
        variables[f"datum_{name}"] = (DATUM, values[data.row], dict(PARAMETERS[name].attributes))
    return variables


def _of_parameters(fit: Fit, known: Statistics, profile: Floats | None) -> dict[str, Any]:
    free, units = fit.model.free, _units(fit.model.free)
    places = [*zip(free, fit.trial.u, strict=True)]
    forms = " ".join(each.form for each in free)
    values = np.array([float(each.value(u)) for each, u in places])
    errors = known.errors * np.array([each.slope(u) for each, u in places])
    starts = np.array([float(each.value(each.start)) for each in free])
    flags = _flags(code.name.lower() for code in Determination)
    variables: dict[str, Any] = {
        "parameter_value": (FREE, values, _named("fitted value", comment=units)),
        "parameter_standard_error": (
            FREE,
            errors,
            _named("standard error of the fitted value", comment=units, form=forms),
        ),
        "parameter_start": (FREE, starts, _named("starting value of the fit", comment=units)),
        "parameter_determination": (
            FREE,
            known.determination,
            _named("whether the data determine the parameter", **flags),
        ),
        "parameter_correlation": (
            (FREE, OTHER),
            known.correlations,
            _named("correlation of the errors of two parameters", units="1"),
        ),
    }
    intervals = {"interval": (known.intervals, "standard error")}
    if profile is not None:
        intervals["profile"] = (profile, "profile likelihood")
    for name, (ends, method) in intervals.items():
        pairs = [np.sort(each.value(pair)) for each, pair in zip(free, ends, strict=True)]
        for side, column in zip(("lower", "upper"), np.array(pairs).T, strict=True):
            what = f"{side} end of the {100 * LEVEL:g} % interval by the {method}"
            variables[f"parameter_{name}_{side}"] = (FREE, column, _named(what, comment=units))
    return variables


def _of_posterior(fit: Fit, posterior: Posterior) -> dict[str, Any]:
    free, units = fit.model.free, _units(fit.model.free)
    draws = np.moveaxis(posterior.places, -1, 0)
    drawn = np.array([each.value(own) for each, own in zip(free, draws, strict=True)])
    variables: dict[str, Any] = {
        "posterior_draws": (
            (FREE, CHAIN, DRAW),
            drawn,
            _named("values drawn from the posterior", comment=units),
        ),
        "posterior_log_probability": (
            (CHAIN, DRAW),
            posterior.logs,
            _named("logarithm of the probability of a draw, up to a constant", units="1"),
        ),
    }
    quantiles = np.quantile(drawn, list(QUANTILES.values()), axis=(1, 2))
    for (name, level), values in zip(QUANTILES.items(), quantiles, strict=True):
        variables[f"parameter_posterior_{name}"] = (
            FREE,
            values if posterior.settled else np.full_like(values, np.nan),
            _named(f"{100 * level:g} % quantile of the posterior", comment=units),
        )
    return variables


def about_posterior(posterior: Posterior) -> dict[str, Any]:
    """Return the reliability of a posterior, as attributes of the file."""
    return {
        "posterior_priors": posterior.priors,
        "posterior_steps": posterior.steps,
        "posterior_thinning": posterior.thinning,
        "posterior_autocorrelation": float(posterior.correlated.max()),
        "posterior_independent_draws": posterior.independent,
        "posterior_agreement": posterior.agreement,
        "posterior_settled": int(posterior.settled),
        "posterior_trials_without_value": posterior.lost,
    }


def _named(long_name: str, **attributes: Any) -> dict[str, Any]:
    return {"long_name": long_name, **attributes}


def _units(free: Iterable[FreeParameter]) -> str:
    """Return the unit of each free parameter, as a comment."""
    return "in " + "; ".join(f"{each.name}: {PARAMETERS[each.name].unit or 1}" for each in free)


def _flags(meanings: Iterable[str]) -> dict[str, Any]:
    """Return the attributes of a variable whose values 0, 1, ... have these meanings."""
    words = [*meanings]
    values = np.arange(len(words), dtype=np.int8)
    return {"units": "1", "flag_values": values, "flag_meanings": " ".join(words)}


def table_of(ds: xr.Dataset) -> list[str]:
    """Return the lines of a summary: parameters, statistics, and a line for each datum."""
    columns = [
        name
        for name in map(str, ds.data_vars)
        if name.removeprefix("datum_") in PARAMETERS and np.ptp(ds[name].values) > 0
    ]
    head = [name.removeprefix("datum_") for name in columns]
    rows = [[*head, "variable", "measured", "error", "fitted", "residual", "regime", ""]]
    for datum in (ds.isel({DATUM: number}) for number in range(ds.sizes[DATUM])):
        status = Status(int(datum.datum_status))
        end = Regime(int(datum.datum_regime)) if status.is_result else status
        rows.append(
            [
                *(f"{float(datum[name]):.6g}" for name in columns),
                str(datum.datum_variable.values),
                *(f"{float(datum[name]):.6g}" for name in _NUMBERS),
                f"{float(datum.residual):.2f}",
                end.name.lower(),
                _JUMPS[int(datum.datum_at_jump)],
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
    return [*_parameter_lines(ds), _machine_line(ds), *_statistic_lines(ds), "", *lines]


_NUMBERS = ("measured_value", "measured_error", "fitted_value")
_JUMPS = ("", "at a jump", "jumps within the intervals")


def _machine_line(ds: xr.Dataset) -> str:
    """Return a line with the fixed parameters of the machine."""
    listed = (
        f"{PARAMETERS[name].symbol} = {float(ds[name]):g} {PARAMETERS[name].unit}".rstrip()
        for name in _MACHINE
        if name in ds.coords and ds[name].ndim == 0
        if name not in ds[FREE].values and f"datum_{name}" not in ds
    )
    return f"computed with {', '.join(listed)} (change them with --set or a config)"


def _parameter_lines(ds: xr.Dataset) -> list[str]:
    lines = []
    for name in map(str, ds[FREE].values):
        own = ds.sel({FREE: name})
        code = Determination(int(own.parameter_determination))
        value, error = float(own.parameter_value), float(own.parameter_standard_error)
        units = f" {PARAMETERS[name].unit}".rstrip()
        low, high = _ends(own, "interval")
        line = f"{name}: {value:.7g}{units}"
        if code is not Determination.AT_BOUND and np.isfinite([low, high]).all():
            # The error limits the digits; the file has all of them.
            line = f"{name}: {with_error(value, error)}{units}"
            line += f", {100 * LEVEL:g} %: {_interval(low, high)}"
        if "parameter_profile_lower" in own:
            line += f", by the profile: {_interval(*_ends(own, 'profile'))}"
        if "parameter_posterior_lower" in own and ds.attrs["posterior_settled"]:
            line += f", by the posterior: {_interval(*_ends(own, 'posterior'))}"
        lines.append(line + _REMARKS[code])
    return lines


def posterior_line(ds: xr.Dataset) -> str:
    """Return a sentence on the reliability of the posterior."""
    steps, walkers = int(ds.attrs["posterior_steps"]), ds.sizes[CHAIN]
    agreement = f"R-hat {float(ds.attrs['posterior_agreement']):.3g}"
    if not ds.attrs["posterior_settled"]:
        if float(ds.attrs["posterior_agreement"]) < ALIKE:
            return (
                f"posterior: NOT DETERMINED, since {steps} steps of {walkers} walkers are too few "
                f"for {LONG:g} autocorrelation times ({agreement})"
            )
        return (
            f"posterior: NOT DETERMINED, since {walkers} walkers do not agree after {steps} steps "
            f"({agreement}): they move between basins too rarely"
        )
    draws = round(float(ds.attrs["posterior_independent_draws"]))
    time, priors = float(ds.attrs["posterior_autocorrelation"]), ds.attrs["posterior_priors"]
    return (
        f"posterior: {draws} independent draws by {walkers} walkers in {steps} steps, "
        f"autocorrelation time {time:.3g} steps, {agreement}; priors: {priors}"
    )


def posterior_groups(ds: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the groups of a file for ArviZ, from a fit with a posterior."""
    own = ds.reset_coords(drop=True)
    draws = {
        name: own["posterior_draws"].sel({FREE: name}, drop=True).assign_attrs(variable.attributes)
        for name, variable in PARAMETERS.items()
        if name in own[FREE].values
    }
    return {
        "posterior": xr.Dataset(draws, attrs={"inference_library": "emcee"}),
        "sample_stats": xr.Dataset({"lp": own["posterior_log_probability"]}),
        "observed_data": own[["measured_value"]],
    }


def _ends(parameter: xr.Dataset, name: str) -> tuple[float, float]:
    low, high = (float(parameter[f"parameter_{name}_{side}"]) for side in ("lower", "upper"))
    return low, high


def _interval(low: float, high: float) -> str:
    if 0.0 < low * _ANYTHING < high:
        return f"any value, over more than {math.log10(_ANYTHING):.0f} decades"
    return f"{low:.6g} to {high:.6g}"


_ANYTHING = 1e6  # an interval with a larger ratio of its ends allows any value
_REMARKS = {
    Determination.DETERMINED: "",
    Determination.UNDETERMINED: "; NOT DETERMINED by these data",
    Determination.AT_BOUND: "; AT ITS BOUND, where it counts as fixed",
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
    if "posterior_draws" in ds:
        lines.append(posterior_line(ds))
    if jumps := int((ds.datum_at_jump != 0).sum()):
        data = "a jump at 1 datum bounds" if jumps == 1 else f"jumps at {jumps} data bound"
        lines.append(
            f"{data} the basin of this minimum: intervals include all other possible basins"
        )
    return lines
